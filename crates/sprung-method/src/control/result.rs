//! A designed controller, as it is written to `control.json`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::shapers::ShaperDesign;

/// Version of the format of `control.json`.
pub const CONTROL_FORMAT: u32 = 1;

/// A designed controller with its margins and tests.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ControlDesign {
    /// Version of the format.
    pub format: u32,
    /// Program and version.
    pub generator: String,
    /// Name of the robot.
    pub robot: String,
    /// Names of the joints.
    pub joints: Vec<String>,
    /// Word of the verdict on the values; `None` for values that come from no identification.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub verdict: Option<String>,
    /// Whether the values include a payload.
    #[serde(default)]
    pub has_payload: bool,
    /// The controller.
    pub controller: DesignedController,
    /// Bandwidths; `None` for a declared controller.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bandwidth: Option<Bandwidth>,
    /// Margins of the loop of each motor, \[n\].
    pub loops: Vec<LoopMargins>,
    /// Least damping ratio of the loop's vibrations.
    pub least_damping: WithDraws,
    /// Poses of the workspace or of the path, link positions, rad (m), \[poses\]\[n\].
    pub poses: Vec<Vec<f64>>,
    /// Number of robots from the posterior.
    pub draws: usize,
    /// Vibrations over poses and robots.
    pub vibrations: Vec<Vibration>,
    /// The input shaper; `None` if none is needed or wanted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shaper: Option<ShaperDesign>,
    /// What the simulations show.
    pub proof: Proof,
    /// Assumptions and omissions of the design, one sentence each.
    pub assumed: Vec<String>,
}

/// A controller with all its numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DesignedController {
    /// `state-feedback`, `pd`, `link-damping` or `declared`.
    pub feedback: String,
    /// Period, s.
    pub period_s: f64,
    /// Windows of the velocity estimator, samples.
    pub velocity_window: [usize; 2],
    /// Whether the torques of the model are fed forward.
    pub has_feedforward: bool,
    /// Velocity within which the compensation of friction changes its direction, rad/s (m/s); `None` without compensation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction_compensation_speed_rad_per_s: Option<f64>,
    /// Gains on the errors of link positions, motor positions, link velocities and motor velocities, \[n\]\[4n\], N·m/rad and
    /// N·m·s/rad (N/m, N·s/m).
    pub gain: Vec<Vec<f64>>,
    /// Times, s, and parts of the impulses of the shaper; empty without one.
    pub shaper: Vec<[f64; 2]>,
    /// Largest torques, \[n\], N·m (N); `None` without limit.
    pub torque_limits_nm: Vec<Option<f64>>,
}

/// Bandwidths of the joints, Hz, \[n\] each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Bandwidth {
    /// Those of the design.
    pub used_hz: Vec<f64>,
    /// The largest in the same proportions that keep the margins at all poses.
    pub largest_hz: Vec<f64>,
    /// Reason for the limit, in a sentence.
    pub limited_by: String,
}

/// A figure for the identified robot and the worst over all robots of the posterior, both at their worst pose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct WithDraws {
    /// Of the identified robot.
    pub identified: f64,
    /// The worst of the robots.
    pub worst: f64,
}

/// The margins of the loop of one motor, opened there while the others are closed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LoopMargins {
    /// Name of the joint.
    pub joint: String,
    /// Least factor by which the gain may change, dB; `None` if every gain keeps the loop stable.
    pub gain_db: Option<WithDraws>,
    /// Least phase that may change, degrees.
    pub phase_deg: WithDraws,
    /// Highest frequency at which the open loop of the identified robot has the gain one in the first pose, Hz; 0 if it has none.
    pub crossover_hz: f64,
}

/// Where the motors are while the robot vibrates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Motors {
    /// No torque acts on them.
    Free,
    /// They do not move.
    Held,
    /// The controller acts on them.
    Controlled,
}

impl Motors {
    /// Returns a phrase for people.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Free => "motors free",
            Self::Held => "motors held",
            Self::Controlled => "loop closed",
        }
    }
}

/// A vibration over all poses and robots.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Vibration {
    /// The motors.
    pub motors: Motors,
    /// Joint whose spring has the largest part of its energy; of a closed loop its place from the lowest frequency.
    pub name: String,
    /// Over all poses and robots.
    pub all: Mode,
    /// At each pose; `None` where the identified robot does not vibrate so. \[poses\]
    pub poses: Vec<Option<Mode>>,
}

/// Natural frequency and damping ratio with intervals that hold 95 % of the robots.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Mode {
    /// Natural frequency of the identified robot, Hz; over poses the median.
    pub hz: f64,
    /// Ends of its interval, Hz.
    pub hz_95: [f64; 2],
    /// Damping ratio of the identified robot; over poses the median.
    pub damping: f64,
    /// Ends of its interval.
    pub damping_95: [f64; 2],
}

/// Results of simulations of the loop with robots from the posterior. The model in the controller is that of the
/// identified robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Proof {
    /// Number of simulated robots, the identified one among them.
    pub robots: usize,
    /// Root mean square error of the links on the reference of the experiment, \[n\]; empty without one.
    pub tracking: Vec<Tracking>,
    /// Motions from rest to rest.
    pub moves: Moves,
    /// Largest torque of all these motions in percent of its limit; `None` without limits.
    pub torque_percent: Option<f64>,
}

/// Tracking error of a link, root mean square, rad (m).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Tracking {
    /// Name of the joint.
    pub joint: String,
    /// With `[controller]`, on the identified robot; `None` without one, or if its loop runs away.
    pub declared_rad: Option<f64>,
    /// With the designed controller.
    pub designed_rad: WithDraws,
}

/// Residual vibration of moves: the largest deviation of a link from its rest after the end of the command.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Moves {
    /// Length of a move, s.
    pub duration_s: f64,
    /// Way of each joint, rad (m), \[n\].
    pub way_rad: Vec<f64>,
    /// Without shaper, rad (m): the largest over the links.
    pub unshaped_rad: WithDraws,
    /// With the shaper, or the same without one.
    pub shaped_rad: WithDraws,
    /// The largest shaped residual in percent of the unshaped one of the same robot and pose; `None` if moves without shaper
    /// leave less than 1 % of the way.
    pub largest_percent: Option<f64>,
    /// Number of robots that still move long after the end: a limit cycle.
    pub limit_cycles: usize,
}
