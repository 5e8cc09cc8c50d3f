//! Logs of the arm with seven joints, torque sensors and very stiff springs, and the results about the springs. The
//! tests of the twin use one of them.

use std::collections::BTreeMap;

use sprung_base::progress::Unheard;
use sprung_log::Channels;
use sprung_method::estimate::{EstimateResult, Identification, identify};
use sprung_method::simulate::{TwinSetup, record};
use sprung_model::{Model, Theta};
use sprung_robot::{self as description, Experiment, no_files};

use crate::in_memory::with_source;

const EXPERIMENT: &str = include_str!("../../../../examples/seven-joint-twin/experiment.toml");
const TRUTH: &str = include_str!("../../../../examples/seven-joint-twin/truth.toml");

const TORQUE: &str = "motor_torque_nm    =";
const SENSORS: &str =
    "joint_torque_nm = [\"ts1\", \"ts2\", \"ts3\", \"ts4\", \"ts5\", \"ts6\", \"ts7\"]\n";

/// Factor on the frequencies of the example, whose highest is 1.21 Hz.
const SLOWER: f64 = 0.8;

/// Factor on the gains of the velocities: the sampled loop would excite the resonances of stiff springs, which the
/// friction of the motors damps.
const CALMER: f64 = 0.15;

/// 0.1 % of the ranges of 87 and 12 N·m.
const NOISE: [f64; 7] = [0.087, 0.087, 0.087, 0.087, 0.012, 0.012, 0.012];

/// Stiffness with which no log of this twin shows a deflection, N·m/rad.
const RIGID: f64 = 1e9;

/// Counts of the encoders per turn.
const COUNTS: [f64; 2] = [131_072.0, 13_107_200.0];

/// Result of a log about the spring of a joint.
pub(crate) struct Spring {
    pub(crate) truth: f64,
    /// Estimate, if the log determines it, N·m/rad.
    pub(crate) value: Option<f64>,
    /// Lower bound, if it does not, N·m/rad.
    pub(crate) above: Option<f64>,
    /// Bound by a known model with the noise of these encoders, N·m/rad.
    pub(crate) known: f64,
}

/// Results of one log.
pub(crate) struct Draw {
    pub(crate) springs: Vec<Spring>,
    /// Sum of the squared errors of all parameters but those of springs, in standard errors of the fit with rigid joints:
    /// as identified, with rigid joints.
    pub(crate) squares: [f64; 2],
    pub(crate) identification: Identification,
}

/// The arm with given springs.
pub(crate) struct Twin {
    pub(crate) experiment: Experiment,
    pub(crate) model: Model,
    /// True values by name.
    pub(crate) values: BTreeMap<String, f64>,
    stiffness: [f64; 7],
}

impl Twin {
    /// - `stiffness`: of each joint, N·m/rad; `has_sensors`: whether the joints have torque sensors.
    ///
    /// # Panics
    ///
    /// If the example is wrong.
    pub(crate) fn new(stiffness: [f64; 7], has_sensors: bool) -> Self {
        let sensors = if has_sensors { SENSORS } else { "" };
        let text = EXPERIMENT.replacen(TORQUE, &format!("{sensors}{TORQUE}"), 1);
        let text = with_nominal(&text, &stiffness);
        let experiment =
            description::read("arm", &text, &[], &mut no_files).expect("the example is right");
        let mut values: BTreeMap<String, f64> = toml::from_str(TRUTH).expect("values by name");
        for (joint, stiffness) in experiment.robot.joint.iter().zip(stiffness) {
            values.insert(format!("{}.stiffness", joint.name), stiffness);
        }
        let model = Model::new(&experiment).expect("the example has a model");
        values.retain(|name, _| {
            model
                .check_names(&BTreeMap::from([(name.clone(), 0.0)]))
                .is_ok()
        });
        Self {
            experiment,
            model,
            values,
            stiffness,
        }
    }

    fn truth(&self) -> Theta {
        self.model
            .theta(&self.values)
            .expect("all values are given")
    }

    /// Returns a log.
    ///
    /// # Panics
    ///
    /// If the twin does not move.
    pub(crate) fn log(&self, seed: u64, duration_s: f64) -> Vec<u8> {
        let mut settings = (self.experiment.simulate.clone()).expect("it has a twin");
        (settings.seed, settings.duration_s) = (seed, duration_s);
        let log = self.experiment.log.as_ref().expect("it has a log");
        if log.joint_torque_nm.is_some() {
            settings.joint_torque_noise_nm = NOISE.to_vec();
        }
        let mut controller = (self.experiment.controller.clone()).expect("it has a controller");
        for (joint, gains) in controller.gain.iter_mut().enumerate() {
            gains[3 * 7 + joint] *= CALMER;
        }
        let mut random = uniform(seed);
        for sine in &mut controller.reference.sines {
            sine.frequency_hz *= SLOWER * (1.0 - 0.2 * random());
        }
        let setup = TwinSetup {
            model: &self.model,
            theta: &self.truth(),
            controller: &controller,
            settings: &settings,
        };
        let channels = Channels::new(&self.experiment.robot, log).expect("the columns are right");
        let mut log = Vec::new();
        record(&setup, &channels, &mut log, &mut Unheard).expect("the twin moves");
        log
    }

    /// Identifies a log.
    ///
    /// # Panics
    ///
    /// If the log is refused.
    pub(crate) fn identify(&self, log: &[u8]) -> Identification {
        identified(&self.experiment, log)
    }

    /// Returns the result of a log about each spring.
    pub(crate) fn springs(&self, found: &Identification, log: &[u8]) -> Vec<Spring> {
        let of = |(joint, &truth): (usize, &f64)| {
            let name = &self.model.joints()[joint];
            let parameter = found.results[0].parameter(&format!("{name}.stiffness"));
            let mut rigid = found.rigid_joints.iter();
            Spring {
                truth,
                value: parameter.and_then(|parameter| parameter.value),
                above: rigid
                    .find(|joint| joint.joint == *name)
                    .map(|joint| joint.stiffness_above_nm_per_rad),
                known: known_bound(joint, truth, log),
            }
        };
        self.stiffness.iter().enumerate().map(of).collect()
    }

    /// Identifies a log with rigid joints: the same equations, with springs that deflect less than any log shows.
    fn rigid(&self, log: &[u8]) -> Identification {
        let mut rigid = self.experiment.clone();
        let names = self.model.joints().iter();
        let names = names.map(|joint| format!("{joint}.stiffness"));
        (rigid.robot.fixed).extend(names.map(|name| (name, RIGID)));
        identified(&rigid, log)
    }
}

/// Simulates and identifies a log of the twin with torque sensors.
pub(crate) fn draw(seed: u64, duration_s: f64, stiffness: [f64; 7]) -> Draw {
    let twin = Twin::new(stiffness, true);
    let log = twin.log(seed, duration_s);
    let (identification, reference) = (twin.identify(&log), twin.rigid(&log));
    let results = [&identification, &reference].map(|found| &found.results[0]);
    Draw {
        springs: twin.springs(&identification, &log),
        squares: squares(&twin.model, &twin.truth(), results),
        identification,
    }
}

fn identified(experiment: &Experiment, log: &[u8]) -> Identification {
    let model = Model::new(experiment).expect("the example has a model");
    with_source(log, |source| {
        identify(experiment, &model, &mut [source], &mut Unheard)
            .expect("the log is right")
            .identification
    })
}

/// Returns the example with nominal stiffnesses, which the controller of the twin uses.
fn with_nominal(text: &str, stiffness: &[f64; 7]) -> String {
    let mut values = stiffness.iter();
    let line = |line: &str| match (line.split_once("stiffness = "), line.starts_with("nominal")) {
        (Some((before, after)), true) => {
            let rest = after.split_once(',').map_or("", |(_, rest)| rest);
            let value = values.next().expect("seven joints");
            format!("{before}stiffness = {value:?},{rest}\n")
        }
        _ => format!("{line}\n"),
    };
    text.lines().map(line).collect()
}

/// Stiffnesses of a seed, distributed by their logarithms from 1e5 to 1e7 N·m/rad.
pub(crate) fn stiffnesses(seed: u64) -> [f64; 7] {
    let mut random = uniform(seed);
    std::array::from_fn(|_| 10f64.powf(5.0 + 2.0 * random()))
}

/// Returns numbers between 0 and 1.
fn uniform(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(1);
    move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Squared errors of two results in standard errors of the second.
fn squares(model: &Model, truth: &[f64], results: [&EstimateResult; 2]) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for (index, parameter) in model.parameters().iter().enumerate() {
        if parameter.joint.is_some_and(|(kind, _)| kind.is_of_spring()) {
            continue;
        }
        let Some(error) = results[1].parameters[index].standard_error else {
            continue;
        };
        for (sum, result) in sums.iter_mut().zip(results) {
            let value = result.parameters[index].value.unwrap_or(0.0);
            *sum += ((value - truth[index]) / error).powi(2);
        }
    }
    sums
}

/// The bound of a known model: compliance by torque with white errors of both encoders, one-sided at 95 %.
fn known_bound(joint: usize, truth: f64, log: &[u8]) -> f64 {
    let text = std::str::from_utf8(log).expect("the log is a text");
    let mut lines = text.lines();
    let name = format!("ts{}", joint + 1);
    let mut head = lines.next().expect("the log has a head").split(',');
    let at = head.position(|other| other == name);
    let at = at.expect("the log has the column");
    let torque = |line: &str| line.split(',').nth(at).map(str::parse);
    let torques: Vec<f64> = lines
        .map(|line| torque(line).expect("a value").expect("a number"))
        .collect();
    let mean = torques.iter().sum::<f64>() / torques.len() as f64;
    let spread: f64 = torques.iter().map(|torque| (torque - mean).powi(2)).sum();
    let variance: f64 = COUNTS
        .iter()
        .map(|counts| (std::f64::consts::TAU / counts).powi(2) / 12.0)
        .sum();
    (truth.recip() + 1.645 * (variance / spread).sqrt()).recip()
}
