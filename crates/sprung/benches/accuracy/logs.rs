//! Logs with known parameters: of the demo's twin, and of a plant with laws that the model lacks.

use std::collections::BTreeMap;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use sprung_base::demo;
use sprung_base::progress::Unheard;
use sprung_log::{Channels, LogWriter};
use sprung_method::estimate::{KnownNoise, KnownTruth, information_bound};
use sprung_method::simulate::{ClosedLoop, TwinSetup, record};
use sprung_model::{Model, Theta};
use sprung_robot::{self as description, Experiment, Simulate, no_files};

use crate::in_memory::with_source;

/// Relative increase of the stiffness of the other plant at the largest deflection.
const CUBIC_STIFFENING: f64 = 0.2;

/// Stribeck friction of the other plant relative to the Coulomb friction of its motors, and its velocity.
const STRIBECK_OVER_COULOMB: f64 = 0.3;
const STRIBECK_RAD_PER_S: f64 = 0.05;

/// The demo's experiment and the true parameters of its robot.
pub(crate) struct Demo {
    pub(crate) experiment: Experiment,
    pub(crate) model: Model,
    pub(crate) truth: Theta,
}

impl Demo {
    pub(crate) fn new() -> Self {
        let experiment = read(demo::EXPERIMENT);
        let model = Model::new(&experiment).expect("the demo has a model");
        let truth = model.theta(&truth()).expect("the demo has its parameters");
        Self {
            experiment,
            model,
            truth,
        }
    }

    pub(crate) fn settings(&self, seed: u64) -> Simulate {
        let mut settings = self
            .experiment
            .simulate
            .clone()
            .expect("the demo has a twin");
        settings.seed = seed;
        settings
    }

    /// Returns a log of the twin.
    pub(crate) fn log(&self, settings: &Simulate) -> Vec<u8> {
        let setup = TwinSetup {
            model: &self.model,
            theta: &self.truth,
            controller: self
                .experiment
                .controller
                .as_ref()
                .expect("the demo has one"),
            settings,
        };
        let mut log = Vec::new();
        record(&setup, &channels(&self.experiment), &mut log, &mut Unheard).expect("the twin runs");
        log
    }
}

fn truth() -> BTreeMap<String, f64> {
    toml::from_str(demo::TRUTH).expect("the demo has its parameters")
}

fn read(text: &str) -> Experiment {
    description::read("experiment.toml", text, &[], &mut no_files).expect("the demo is right")
}

fn channels(experiment: &Experiment) -> Channels {
    let log = experiment.log.as_ref().expect("the demo has a log");
    Channels::new(&experiment.robot, log).expect("the demo is right")
}

/// Returns the demo's experiment with the friction and spring laws of the other plant. The fit must
/// find its Stribeck velocity and its torque delay.
pub(crate) fn with_its_laws() -> Experiment {
    let experiment = laws(None);
    read(&experiment.replace(
        "motor_torque_nm    = [\"tau1_nm\", \"tau2_nm\"]",
        "motor_torque_nm    = [\"tau1_nm\", \"tau2_nm\"]\n\
         delay_s = { tau1_nm = \"estimate\", tau2_nm = \"estimate\" }",
    ))
}

fn laws(stribeck: Option<f64>) -> String {
    let velocity = stribeck.map_or(String::new(), |velocity| {
        format!("stribeck_velocity_rad_per_s = {velocity}\n")
    });
    let mut text = demo::EXPERIMENT.to_owned();
    for joint in ["joint1", "joint2"] {
        let name = format!("\nname = \"{joint}\"\n");
        assert!(text.contains(&name), "the demo names its joints");
        text = text.replace(
            &name,
            &format!(
                "{name}spring = [\"linear\", \"cubic\"]\n\
                 motor_friction = [\"viscous\", \"coulomb\", \"stribeck\"]\n{velocity}"
            ),
        );
    }
    text
}

/// Delay of the torque columns of the other plant, s: the torques act one sample late.
const TORQUE_DELAY_S: f64 = -1e-3;

/// A plant with stiffening springs, with Stribeck friction in its motors, and with torques that act
/// one sample late.
pub(crate) struct Other {
    experiment: Experiment,
    model: Model,
    theta: Theta,
}

impl Other {
    pub(crate) fn new(demo: &Demo) -> Self {
        let experiment = read(&laws(Some(STRIBECK_RAD_PER_S)));
        let model = Model::new(&experiment).expect("the plant has a model");
        let mut values = truth();
        for (joint, peak) in peaks(demo).into_iter().enumerate() {
            let name = &demo.model.joints()[joint];
            let of = |what: &str| values[&format!("{name}.{what}")];
            let cubic = CUBIC_STIFFENING * of("stiffness") / (peak * peak);
            let stribeck = STRIBECK_OVER_COULOMB * of("motor_coulomb");
            values.insert(format!("{name}.cubic_stiffness"), cubic);
            values.insert(format!("{name}.motor_stribeck"), stribeck);
        }
        let theta = model.theta(&values).expect("the plant has its parameters");
        Self {
            experiment,
            model,
            theta,
        }
    }

    /// Returns names and values of the plant's parameters.
    pub(crate) fn truth(&self) -> Vec<(String, f64)> {
        let names = self.model.parameters().iter().map(|p| p.name.clone());
        names.zip(self.theta.iter().copied()).collect()
    }

    /// Returns the Cramér-Rao bound of each parameter on a log of the plant, with known laws, unknown Stribeck
    /// velocities and unknown delays of the torques; `None` if the log is too short.
    pub(crate) fn bound(&self, settings: &Simulate, log: &[u8]) -> Option<Vec<f64>> {
        let experiment = with_its_laws();
        let model = Model::new(&experiment).expect("the plant has a model");
        let model = (0..model.joint_count()).fold(model, |model, joint| {
            model.with_stribeck(joint, STRIBECK_RAD_PER_S)
        });
        let delays = ["tau1_nm", "tau2_nm"].map(|column| (column.to_owned(), TORQUE_DELAY_S));
        let truth = KnownTruth {
            theta: &self.theta,
            noise: &KnownNoise::from(settings),
            delays: &BTreeMap::from(delays),
        };
        with_source(log, |source| {
            let bound = information_bound(&experiment, &model, truth, &mut [source]);
            bound
                .expect("the log is right")
                .map(|bound| bound.standard_errors())
        })
    }

    /// Returns a log of the plant, with the encoders and the noise of the demo.
    pub(crate) fn log(&self, settings: &Simulate) -> Vec<u8> {
        let controller = self
            .experiment
            .controller
            .as_ref()
            .expect("the demo has one");
        let period = settings.period_s;
        let mut plant = ClosedLoop::new(&self.model, &self.theta, controller, period, None)
            .expect("the plant is one");
        let mut rng = ChaCha8Rng::seed_from_u64(settings.seed);
        let mut encoders = |counts: &[u32]| -> Vec<(f64, f64)> {
            let step = |&counts: &u32| std::f64::consts::TAU / f64::from(counts);
            counts.iter().map(|c| (step(c), rng.random())).collect()
        };
        let link = encoders(&settings.link_encoder_counts_per_turn);
        let motor = encoders(&settings.motor_encoder_counts_per_turn);
        let read = |encoders: &[(f64, f64)], positions: &[f64]| -> Vec<f64> {
            (encoders.iter().zip(positions))
                .map(|((step, phase), position)| step * (position / step + phase).floor())
                .collect()
        };
        let mut log = Vec::new();
        let mut writer =
            LogWriter::new(&mut log, &channels(&self.experiment)).expect("memory takes a log");
        let mut before = vec![0.0; 2];
        for _ in 0..(settings.duration_s / period).round() as usize {
            let (state, time) = (plant.state(), plant.time());
            let (q, phi) = (read(&link, &state.q), read(&motor, &state.phi));
            let tau = plant.command(time, &q, &phi);
            let noisy: Vec<f64> = (tau.iter().zip(&settings.torque_noise_nm))
                .map(|(tau, noise)| tau + noise * rng.sample::<f64, _>(StandardNormal))
                .collect();
            writer
                .write(time, [&q, &phi], [&noisy, &[0.0; 2]], &[], &[])
                .expect("memory takes a log");
            plant.advance(&before).expect("the loop is stable");
            before = tau;
        }
        writer.finish().expect("memory takes a log");
        log
    }
}

/// Returns the largest deflections of the demo's springs, rad.
fn peaks(demo: &Demo) -> Vec<f64> {
    let controller = demo
        .experiment
        .controller
        .as_ref()
        .expect("the demo has one");
    let mut plant = ClosedLoop::new(&demo.model, &demo.truth, controller, 1e-3, None)
        .expect("the demo is a robot");
    let mut peaks = vec![0.0_f64; 2];
    for _ in 0..10_000 {
        let state = plant.state();
        for (peak, (q, phi)) in peaks.iter_mut().zip(state.q.iter().zip(&state.phi)) {
            *peak = peak.max((q - phi).abs());
        }
        let tau = plant.command(plant.time(), &state.q, &state.phi);
        plant.advance(&tau).expect("the demo is stable");
    }
    peaks
}
