//! The design of an experiment, as it is written to `excitation.json`.

use schemars::JsonSchema;
use serde::Serialize;

use super::checked_loop::Simulation;

/// Version of the format of `excitation.json`.
pub const EXCITATION_FORMAT: u32 = 1;

/// A designed experiment.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Excitation {
    /// Version of the format.
    pub format: u32,
    /// Program and version.
    pub generator: String,
    /// Name of the robot.
    pub robot: String,
    /// What made the motion: `optimal`, `paper`, `random` or `reference`.
    pub method: String,
    /// What the search made best.
    pub objective: String,
    /// Whether this is a first small motion for an unknown robot.
    pub is_warm_up: bool,
    /// Whether all limits hold: those of the reference between samples, those of the simulated loop at every period of the
    /// controller.
    pub is_certified: bool,
    /// The motion.
    pub motion: MotionResult,
    /// The motion for validation; `None` without a search.
    pub hold_out: Option<MotionResult>,
    /// The slow motion for friction; `None` if none was requested.
    pub slow: Option<MotionResult>,
    /// How near the motion comes to each limit.
    pub limits: Vec<LimitUsed>,
    /// Standard errors of the motion.
    pub promise: Vec<Promised>,
    /// Condition number of the information about the inertial parameters of the links, with columns of length one; `None`
    /// if there are none.
    pub links_condition_number: Option<f64>,
    /// Standard errors with more experiments.
    pub more: Vec<More>,
    /// Assumptions of the design, one sentence each.
    pub assumed: Vec<String>,
    /// The search.
    pub search: SearchResult,
}

/// A motion as a Fourier series, and its times.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct MotionResult {
    /// Length without approach, s.
    pub duration_s: f64,
    /// Length of the approach before it, s; 0 if the robot is there.
    pub approach_s: f64,
    /// Lowest frequency, Hz.
    pub base_frequency_hz: f64,
    /// Multiples of it.
    pub harmonics: Vec<usize>,
    /// Number of periods.
    pub periods: usize,
    /// Coefficients of each joint.
    pub joints: Vec<JointMotion>,
}

/// The series of one joint.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct JointMotion {
    /// Name of the joint.
    pub joint: String,
    /// Centre, rad (m).
    pub centre_rad: f64,
    /// Position at the beginning and at the end, rad (m).
    pub start_rad: f64,
    /// Amplitude of the sine of each multiple, rad (m).
    pub sine_rad: Vec<f64>,
    /// Amplitude of the cosine of each multiple, rad (m).
    pub cosine_rad: Vec<f64>,
}

/// How near the motion comes to one limit.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct LimitUsed {
    /// Joint; `None` for the tool.
    pub joint: Option<String>,
    /// The limited quantity.
    pub quantity: String,
    /// Unit of the limits.
    pub unit: String,
    /// Lowest allowed value; `None` without one.
    pub lowest: Option<f64>,
    /// Highest allowed value; `None` without one.
    pub highest: Option<f64>,
    /// Largest part of the limit that the motion uses, percent.
    pub used_percent: f64,
    /// Time of its largest value, s.
    pub time_s: f64,
    /// How it was shown: `between samples` or `simulated`.
    pub shown: String,
}

/// The standard error of one parameter for the motion.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Promised {
    /// Name of the parameter.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Value for which the experiment was designed.
    pub value: f64,
    /// Standard error, the bound of Cramér and Rao.
    pub standard_error: f64,
    /// Relative standard error, percent; `None` for a value of zero.
    pub relative_percent: Option<f64>,
    /// Whether the standard error is smaller than the value.
    pub is_determined: bool,
    /// The change that determines the parameter, if this motion does not.
    pub cure: Option<String>,
}

/// Standard errors after more experiments.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct More {
    /// The experiments.
    pub what: String,
    /// Standard errors relative to those of the promise, geometric mean.
    pub factor: f64,
    /// Number of parameters that stay undetermined.
    pub undetermined: usize,
}

/// The search for a motion.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct SearchResult {
    /// Seed.
    pub seed: u64,
    /// Largest number of steps of each search.
    pub steps: usize,
    /// Values of the objective of all searches, logarithms of standard errors, the best first.
    pub objectives: Vec<f64>,
    /// Value of the motion that was taken.
    pub objective: f64,
}

/// A designed experiment with its curves.
#[derive(Clone, Debug, PartialEq)]
pub struct Excited {
    /// What is written to JSON.
    pub excitation: Excitation,
    /// The simulated motion.
    pub simulation: Simulation,
    /// Samples of the files for the controller.
    pub trajectory: Trajectory,
    /// Those of the motion for validation.
    pub hold_out: Option<Trajectory>,
    /// Those of the slow motion.
    pub slow: Option<Trajectory>,
    /// Places of links and tool over the simulated motion; `None` without lengths.
    pub skeleton: Option<Skeleton>,
}

/// Samples of a motion at the rate of the controller, approach first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Trajectory {
    /// Names of the joints.
    pub joints: Vec<String>,
    /// Whether each joint turns.
    pub turns: Vec<bool>,
    /// Times, s.
    pub time_s: Vec<f64>,
    /// Positions, rad (m), one list per joint.
    pub position: Vec<Vec<f64>>,
    /// Velocities, rad/s (m/s), one list per joint.
    pub velocity: Vec<Vec<f64>>,
    /// Accelerations, rad/s² (m/s²), one list per joint.
    pub acceleration: Vec<Vec<f64>>,
}

/// Places of links and tool over a motion.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Skeleton {
    /// Times, s.
    pub time_s: Vec<f64>,
    /// Index of the point that carries each point; `None` for one on the base. The tool is the last point.
    pub parents: Vec<Option<usize>>,
    /// Places of all points at each time, m, in a frame whose z axis points against gravity.
    pub points: Vec<Vec<[f64; 3]>>,
}

impl Excitation {
    /// Returns the parameters that the motion does not determine.
    pub fn undetermined(&self) -> impl Iterator<Item = &Promised> {
        self.promise
            .iter()
            .filter(|promised| !promised.is_determined)
    }
}
