//! The demo's closed loop, 10 s at 1 kHz, with and without its sensors.

use std::collections::BTreeMap;

use divan::Bencher;
use divan::counter::ItemsCount;
use sprung::demo;
use sprung::description::{self, no_files};
use sprung::model::Model;
use sprung::simulate::{ClosedLoop, Twin, TwinSetup};

const SAMPLES: usize = 10_000;

fn main() {
    divan::main();
}

#[divan::bench(sample_count = 10, args = [1e-8, 1e-7, 1e-6])]
fn closed_loop(bencher: Bencher, tolerance: f64) {
    let experiment =
        description::read("demo", demo::EXPERIMENT, &[], &mut no_files).expect("the demo is right");
    let model = Model::new(&experiment).expect("the demo is right");
    let truth: BTreeMap<String, f64> = toml::from_str(demo::TRUTH).expect("the demo is right");
    let theta = model.theta(&truth).expect("the demo is right");
    let controller = experiment.controller.expect("the demo has one");
    bencher
        .counter(ItemsCount::new(SAMPLES))
        .with_inputs(|| {
            ClosedLoop::new(&model, &theta, &controller, 1e-3, None)
                .expect("the demo is right")
                .with_tolerance(tolerance)
        })
        .bench_local_values(|mut plant| {
            for _ in 0..SAMPLES {
                let state = plant.state();
                let tau = plant.command(plant.time(), &state.q, &state.phi);
                plant.advance(&tau).expect("the demo is stable");
            }
            plant
        });
}

#[divan::bench(sample_count = 10)]
fn twin(bencher: Bencher) {
    let experiment =
        description::read("demo", demo::EXPERIMENT, &[], &mut no_files).expect("the demo is right");
    let model = Model::new(&experiment).expect("the demo is right");
    let truth: BTreeMap<String, f64> = toml::from_str(demo::TRUTH).expect("the demo is right");
    let theta = model.theta(&truth).expect("the demo is right");
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
