//! Times closed loops of 10 s at 1 kHz: the demo with and without sensors, and an arm with seven
//! flexible joints.
#![expect(clippy::print_stdout, reason = "a benchmark says what it measured")]

use std::collections::BTreeMap;

use divan::Bencher;
use divan::counter::ItemsCount;
use sprung_base::demo;
use sprung_method::simulate::{ClosedLoop, Twin, TwinSetup};
use sprung_model::{Model, Theta};
use sprung_robot::{self as description, Experiment, no_files};

const SAMPLES: usize = 10_000;

fn main() {
    divan::main();
}

const SEVEN: &str = include_str!("../../../examples/seven-joint-twin/experiment.toml");
const SEVEN_TRUTH: &str = include_str!("../../../examples/seven-joint-twin/truth.toml");

/// A twin's experiment, its model and its true parameters.
struct TrueTwin {
    experiment: Experiment,
    model: Model,
    theta: Theta,
}

fn twin_of(experiment: &str, truth: &str) -> TrueTwin {
    let experiment =
        description::read("twin", experiment, &[], &mut no_files).expect("the twin is right");
    let model = Model::new(&experiment).expect("the twin is right");
    let truth: BTreeMap<String, f64> = toml::from_str(truth).expect("the twin is right");
    let theta = model.theta(&truth).expect("the twin is right");
    TrueTwin {
        experiment,
        model,
        theta,
    }
}

fn run(mut plant: ClosedLoop) -> ClosedLoop {
    for _ in 0..SAMPLES {
        let state = plant.state();
        let tau = plant.command(plant.time(), &state.q, &state.phi);
        plant.advance(&tau).expect("the twin is stable");
    }
    plant
}

/// Returns the largest deviation of the positions from those at a thousandth of the tolerance, rad.
fn error(start: &dyn Fn() -> ClosedLoop, tolerance: f64) -> f64 {
    let mut coarse = start().with_tolerance(tolerance);
    let mut fine = start().with_tolerance(1e-3 * tolerance);
    let mut worst: f64 = 0.0;
    for _ in 0..SAMPLES {
        let mut states = Vec::new();
        for plant in [&mut coarse, &mut fine] {
            let state = plant.state();
            let tau = plant.command(plant.time(), &state.q, &state.phi);
            plant.advance(&tau).expect("the twin is stable");
            states.push(plant.state());
        }
        let pairs =
            (states[0].q.iter().zip(&states[1].q)).chain(states[0].phi.iter().zip(&states[1].phi));
        worst = pairs.fold(worst, |worst, (a, b)| worst.max((a - b).abs()));
    }
    worst
}

#[divan::bench(sample_count = 5, args = [1e-7, 1e-6])]
fn closed_loop_of_seven_joints(bencher: Bencher, tolerance: f64) {
    let TrueTwin {
        experiment,
        model,
        theta,
    } = twin_of(SEVEN, SEVEN_TRUTH);
    let controller = experiment.controller.expect("the twin has one");
    let start = || {
        ClosedLoop::new(&model, &theta, &controller, 1e-3, None)
            .expect("the twin is right")
            .with_tolerance(tolerance)
    };
    println!(
        "seven joints, tolerance {tolerance:e}: largest position error {:.1e} rad",
        error(&start, tolerance)
    );
    bencher
        .counter(ItemsCount::new(SAMPLES))
        .with_inputs(start)
        .bench_local_values(run);
}

#[divan::bench(sample_count = 10, args = [1e-8, 1e-7, 1e-6])]
fn closed_loop(bencher: Bencher, tolerance: f64) {
    let TrueTwin {
        experiment,
        model,
        theta,
    } = twin_of(demo::EXPERIMENT, demo::TRUTH);
    let controller = experiment.controller.expect("the demo has one");
    bencher
        .counter(ItemsCount::new(SAMPLES))
        .with_inputs(|| {
            ClosedLoop::new(&model, &theta, &controller, 1e-3, None)
                .expect("the demo is right")
                .with_tolerance(tolerance)
        })
        .bench_local_values(run);
}

#[divan::bench(sample_count = 10)]
fn twin(bencher: Bencher) {
    let TrueTwin {
        experiment,
        model,
        theta,
    } = twin_of(demo::EXPERIMENT, demo::TRUTH);
    let controller = experiment.controller.expect("the demo has one");
    let settings = experiment.simulate.expect("the demo has one");
    let setup = TwinSetup {
        model: &model,
        theta: &theta,
        controller: &controller,
        settings: &settings,
    };
    bencher
        .counter(ItemsCount::new(SAMPLES))
        .with_inputs(|| Twin::new(&setup).expect("the demo is right"))
        .bench_local_values(|mut twin| {
            for _ in 0..SAMPLES {
                twin.sample().expect("the demo is stable");
            }
            twin
        });
}
