//! Errors of the base parameters of the twin with seven joints, with and without constraints, with nominal values that
//! are wrong by 30 %. Then values near their bounds. Then errors and intervals of payloads of a twin with six
//! joints.
//!
//! `cargo bench -p sprung --bench physical [-- --seeds 20] [--only bodies|bounds|payload]`
#![expect(clippy::print_stdout, reason = "a benchmark says what it measured")]

mod bounds;
#[path = "../../tests/twin/in_memory.rs"]
mod in_memory;
mod payload;

use std::collections::BTreeMap;

use rayon::prelude::*;
use sprung_base::progress::Unheard;
use sprung_core::spatial::BODY_NAMES;
use sprung_log::Channels;
use sprung_method::estimate::identify;
use sprung_method::simulate::{TwinSetup, record};
use sprung_model::Model;
use sprung_robot::{self as description, Distance, Estimator, Experiment, no_files};
use sprung_testing::Figure;

use in_memory::with_source;

const EXPERIMENT: &str = include_str!("../../../../examples/seven-joint-twin/experiment.toml");
const TRUTH: &str = include_str!("../../../../examples/seven-joint-twin/truth.toml");

const DURATION_S: f64 = 6.0;
const JOINTS: u32 = 7;

/// Standard deviation of the nominal masses and lengths, relative.
const NOMINAL_ERROR: f64 = 0.3;

/// Results of one log.
struct Draw {
    /// Errors of the base parameters, %: without and with constraints.
    errors: [f64; 2],
}

fn main() {
    if !std::env::args().any(|argument| argument == "--bench") {
        println!("cargo bench -p sprung --bench physical prints the tables");
        return;
    }
    let seeds = seeds();
    let only = after("--only");
    let wanted = |part: &str| only.as_deref().is_none_or(|only| only == part);
    if wanted("bodies") {
        bodies(seeds);
    }
    if wanted("bounds") {
        bounds::bounds(seeds);
    }
    if wanted("payload") {
        payload::payloads(seeds);
    }
}

/// Prints the errors of base parameters.
fn bodies(seeds: u32) {
    println!(
        "Twin with seven joints, {DURATION_S} s, least squares, {seeds} logs per row. Error of the base \
         parameters of the links: length of the difference over the length of the truth.\n"
    );
    println!("| torque noise | distance | without constraints | robots that can exist |");
    println!("|---|---|---|---|");
    for noise in [0.5, 2.0] {
        for (name, distance) in [
            ("entropic", Distance::Entropic),
            ("euclidean", Distance::Euclidean),
        ] {
            let draws: Vec<Draw> = (1..=seeds)
                .into_par_iter()
                .map(|seed| draw(noise, distance, seed))
                .collect();
            let mean = |of: &dyn Fn(&Draw) -> f64| -> f64 {
                draws.iter().map(of).sum::<f64>() / f64::from(seeds)
            };
            let [without, with] = [0, 1].map(|i| mean(&|draw| draw.errors[i]));
            println!("| {noise} N·m | {name} | {without:.2} % | {with:.2} % |");
            let text = format!("torque noise of {noise} N·m, `distance = \"{name}\"`");
            Figure::lower(&format!("bodies, {noise}, {name}"), &text, with, "%")
                .beside("without constraints", without)
                .note();
        }
    }
}

/// Returns the word after an argument.
fn after(argument: &str) -> Option<String> {
    std::env::args()
        .skip_while(|other| other != argument)
        .nth(1)
}

/// Returns the number after `--seeds`, 20 without it.
fn seeds() -> u32 {
    after("--seeds")
        .and_then(|text| text.parse().ok())
        .unwrap_or(20)
}

fn draw(noise: f64, distance: Distance, seed: u32) -> Draw {
    let values: BTreeMap<String, f64> = toml::from_str(TRUTH).expect("the example has true values");
    let mut experiment = description::read("arm", EXPERIMENT, &[], &mut no_files)
        .expect("the example is an experiment");
    experiment.robot.nominal = wrong(&values, seed);
    experiment.identify.estimator = vec![Estimator::LeastSquares];
    experiment.identify.physical.distance = distance;
    let model = Model::new(&experiment).expect("the example is a robot");
    let twin = Twin {
        experiment: &experiment,
        model: &model,
        values: &values,
    };
    let log = twin.log((noise, seed), DURATION_S);
    let found = with_source(&log, |source| {
        identify(&experiment, &model, &mut [source], &mut Unheard)
            .expect("the twin's log can be identified")
    });
    let result = &found.identification.results[0];
    let truth = model
        .theta(&known(&model, &values))
        .expect("all values are known");
    let (mut squares, mut all) = ([0.0; 2], 0.0);
    for ((estimate, truth), parameter) in
        result.parameters.iter().zip(&truth).zip(model.parameters())
    {
        if parameter.joint.is_none() {
            for (sum, value) in squares
                .iter_mut()
                .zip([estimate.unconstrained, estimate.value])
            {
                *sum += (value.unwrap_or(f64::NAN) - truth).powi(2);
            }
            all += truth * truth;
        }
    }
    Draw {
        errors: squares.map(|square| 100.0 * (square / all).sqrt()),
    }
}

/// A twin with its true parameters.
struct Twin<'a> {
    experiment: &'a Experiment,
    model: &'a Model,
    values: &'a BTreeMap<String, f64>,
}

impl Twin<'_> {
    /// Returns a log.
    ///
    /// - `noise`: of the torques, N·m; `duration`: s.
    fn log(&self, (noise, seed): (f64, u32), duration: f64) -> Vec<u8> {
        let settings = self.experiment.simulate.clone();
        let mut settings = settings.expect("the example has a twin");
        settings.duration_s = duration;
        settings.seed = u64::from(seed);
        settings.torque_noise_nm = vec![noise; self.model.joint_count()];
        let theta = self.model.theta(&known(self.model, self.values));
        let controller = self.experiment.controller.as_ref();
        let setup = TwinSetup {
            model: self.model,
            theta: &theta.expect("all values are known"),
            controller: controller.expect("the example has a controller"),
            settings: &settings,
        };
        let columns = self.experiment.log.as_ref().expect("the example has a log");
        let channels = Channels::new(&self.experiment.robot, columns);
        let channels = channels.expect("the columns are the robot's");
        let mut log = Vec::new();
        record(&setup, &channels, &mut log, &mut Unheard).expect("the twin moves");
        log
    }
}

/// The values of parameters that a model has.
fn known(model: &Model, values: &BTreeMap<String, f64>) -> BTreeMap<String, f64> {
    let mut values = values.clone();
    values.retain(|name, _| {
        model
            .check_names(&BTreeMap::from([(name.clone(), 0.0)]))
            .is_ok()
    });
    values
}

/// Returns the true parameters of the links with wrong masses and lengths; the bodies can exist.
fn wrong(values: &BTreeMap<String, f64>, seed: u32) -> BTreeMap<String, f64> {
    let mut state = u64::from(seed).wrapping_mul(0x9E37_79B9_7F4A_7C15) + 1;
    let mut random = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    // The sum of twelve uniform numbers minus six has the variance 1.
    let mut factor = || {
        let normal: f64 = (0..12).map(|_| random()).sum::<f64>() - 6.0;
        (1.0 + NOMINAL_ERROR * normal).max(0.2)
    };
    let mut all = BTreeMap::new();
    for link in 1..=JOINTS {
        let (mass, length) = (factor(), factor());
        for kind in BODY_NAMES {
            let name = format!("link{link}.{kind}");
            let power = match kind.len() {
                1 => 0,
                2 => 1,
                _ => 2,
            };
            let true_value = values.get(&name).copied().unwrap_or(0.0);
            all.insert(name, mass * length.powi(power) * true_value);
        }
    }
    all
}
