//! Searches of the refinement for random robots and from nominal values. The tests of the twin run some of them.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sprung_base::demo;
use sprung_base::progress::Unheard;
use sprung_log::Channels;
use sprung_method::estimate::{EstimateResult, identify};
use sprung_method::simulate::{TwinSetup, record};
use sprung_model::{Model, Theta};
use sprung_robot::{self as description, Estimator, Experiment, Simulate, StartName, no_files};

use crate::in_memory::with_source;

/// A robot with known parameters and an experiment that refines them.
struct Robot {
    experiment: Experiment,
    model: Model,
    truth: Theta,
}

impl Robot {
    /// The demo's robot, to be refined.
    fn demo() -> Self {
        let mut experiment =
            description::read("experiment.toml", demo::EXPERIMENT, &[], &mut no_files)
                .expect("the demo is right");
        experiment.identify.estimator = vec![Estimator::PredictionError];
        let model = Model::new(&experiment).expect("the demo has a model");
        let truth = toml::from_str(demo::TRUTH).expect("the demo has its parameters");
        let truth = model.theta(&truth).expect("the demo has its parameters");
        Self {
            experiment,
            model,
            truth,
        }
    }

    /// The demo's robot with each parameter times 0.5 to 2, and gains that move it.
    fn random(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut robot = Self::demo();
        let usual = robot.truth.clone();
        loop {
            for (value, usual) in robot.truth.iter_mut().zip(&usual) {
                *value = usual * 2.0_f64.powf(rng.random_range(-1.0..1.0));
            }
            // Not all draws are inertias of a robot.
            if robot.model.check_inertias(&robot.truth).is_ok() {
                break;
            }
        }
        let controller = robot.experiment.controller.as_mut().expect("it has one");
        for (joint, name) in robot.model.joints().iter().enumerate() {
            let times = |what: &str| {
                let index = robot.model.index_of(&format!("{name}.{what}"));
                let index = index.expect("the robot has its parameters");
                robot.truth[index] / usual[index]
            };
            let factor = (["stiffness", "motor_viscous", "motor_coulomb"].into_iter())
                .map(times)
                .fold(0.0, f64::max);
            controller.kp_nm_per_rad[joint] *= factor;
            controller.kd_nms_per_rad[joint] *= factor;
        }
        robot
    }

    fn settings(&self, seed: u64, duration_s: f64) -> Simulate {
        let settings = self.experiment.simulate.clone();
        Simulate {
            seed,
            duration_s,
            ..settings.expect("the demo has a twin")
        }
    }

    fn log(&self, settings: &Simulate) -> Vec<u8> {
        let setup = TwinSetup {
            model: &self.model,
            theta: &self.truth,
            controller: self.experiment.controller.as_ref().expect("it has one"),
            settings,
        };
        let columns = self.experiment.log.as_ref().expect("it has a log");
        let channels = Channels::new(&self.experiment.robot, columns).expect("the demo is right");
        let mut log = Vec::new();
        record(&setup, &channels, &mut log, &mut Unheard).expect("the twin runs");
        log
    }

    fn refined(&self, log: &[u8]) -> EstimateResult {
        with_source(log, |source| {
            let found = identify(&self.experiment, &self.model, &mut [source], &mut Unheard);
            let mut results = found.expect("the log is right").identification.results;
            results.remove(0)
        })
    }
}

/// Returns why a refinement failed, if it failed.
fn failure(result: &EstimateResult) -> Option<String> {
    let mut warnings = result.warnings.iter();
    let failed = warnings.find(|finding| finding.code == "refinement-failed");
    failed.map(|finding| finding.text.clone())
}

/// Outcome of a search.
pub(crate) struct Search {
    /// Name of each parameter and its distance, in standard errors: from the truth, or from the other search.
    pub(crate) away: Vec<(String, f64)>,
    /// Why the refinement failed, if it failed.
    pub(crate) failure: Option<String>,
    /// Runs of the filter.
    pub(crate) runs: usize,
}

impl Search {
    /// Largest distance, and the name of its parameter.
    pub(crate) fn worst(&self) -> (&str, f64) {
        let worst = self.away.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        worst.map_or(("", f64::NAN), |(name, away)| (name, *away))
    }

    fn new(result: &EstimateResult, reference: &[f64], standard_errors: &[f64]) -> Self {
        let away = result.parameters.iter().zip(reference).zip(standard_errors);
        let away = away.map(|((p, reference), error)| {
            let value = p.value.unwrap_or(f64::NAN);
            (p.name.clone(), ((value - reference) / error).abs())
        });
        Self {
            away: away.collect(),
            failure: failure(result),
            runs: result.refinement.as_ref().map_or(0, |found| found.runs),
        }
    }
}

fn standard_errors(result: &EstimateResult) -> Vec<f64> {
    let errors = result.parameters.iter().map(|p| p.standard_error);
    errors.map(|error| error.unwrap_or(f64::NAN)).collect()
}

/// Refines a log of a random robot; distances are from the truth.
pub(crate) fn random(seed: u64, duration_s: f64) -> Search {
    let robot = Robot::random(seed);
    let result = robot.refined(&robot.log(&robot.settings(seed, duration_s)));
    Search::new(&result, &robot.truth, &standard_errors(&result))
}

/// Refines a log of the demo's robot from nominal values. Distances are from the result of a start by least squares.
///
/// Every fourth log is undisturbed. The others have coarse encoders, disturbed motors or disturbed links.
///
/// # Panics
///
/// If the refinement from least squares fails.
pub(crate) fn from_nominal_values(index: u64, duration_s: f64) -> Search {
    let mut robot = Robot::demo();
    let mut settings = robot.settings(1000 + index, duration_s);
    match index % 4 {
        1 => {
            settings.link_encoder_counts_per_turn = vec![4096; 2];
            settings.motor_encoder_counts_per_turn = vec![4096; 2];
        }
        2 => settings.torque_disturbance_nm = vec![0.05, 0.01],
        3 => settings.link_torque_disturbance_nm = vec![0.01; 2],
        _ => {}
    }
    let log = robot.log(&settings);
    let usual = robot.refined(&log);
    assert_eq!(failure(&usual), None, "log {index}, from least squares");
    robot.experiment.identify.start = StartName::Nominal;
    let values: Vec<f64> = (usual.parameters.iter())
        .map(|p| p.value.unwrap_or(f64::NAN))
        .collect();
    Search::new(&robot.refined(&log), &values, &standard_errors(&usual))
}
