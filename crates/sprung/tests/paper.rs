//! The numbers of the paper's method, on the digital twin.
//!
//! `cargo test --release --package sprung --test paper -- --nocapture` prints
//! them.

#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "these are tests")]

use std::collections::BTreeMap;
use std::io::Read;

use sprung::demo;
use sprung::description::{self, DiscretizationName, Experiment};
use sprung::estimate::{fit, identify};
use sprung::log::{Channels, LogSource};
use sprung::model::{Model, Theta};
use sprung::regression::{FilteredRegression, Reduction};
use sprung::simulate::{ClosedLoop, TwinSetup, record};

fn setup() -> (Experiment, Model, Theta) {
    let experiment = description::read("experiment.toml", demo::EXPERIMENT, &[]).unwrap();
    let model = Model::new(&experiment.robot).unwrap();
    let truth: BTreeMap<String, f64> = toml::from_str(demo::TRUTH).unwrap();
    let truth = model.theta(&truth).unwrap();
    (experiment, model, truth)
}

fn plant(experiment: &Experiment, model: &Model, truth: &Theta) -> ClosedLoop {
    let controller = experiment.controller.as_ref().unwrap();
    ClosedLoop::new(model, truth, controller, 1e-3, &[0.0; 2], &[0.0; 2]).unwrap()
}

/// Errors in percent of least squares on exact states, without noise.
fn noise_free(discretization: DiscretizationName) -> Vec<f64> {
    let (experiment, model, truth) = setup();
    let mut plant = plant(&experiment, &model, &truth);
    let mut regression = FilteredRegression::new(model.arm(), 30.0, 1e-3, discretization).unwrap();
    let mut reduction = Reduction::new(&model);
    for _ in 0..=10_000 {
        let (state, time) = (plant.state(), plant.time());
        let tau = plant.command(plant.time(), &state.q, &state.phi);
        reduction.push(&regression.process(time, &state, &tau));
        plant.advance(&tau).unwrap();
    }
    let found = fit(&model, &reduction.finish()).unwrap().theta();
    (found.iter().zip(truth))
        .map(|(x, t)| 100.0 * (x / t - 1.0))
        .collect()
}

#[test]
fn matched_filters_have_no_bias() {
    let errors = noise_free(DiscretizationName::Matched);
    println!("{errors:.3?}");
    assert!(errors.iter().all(|error| error.abs() < 0.3), "{errors:.3?}");
}

#[test]
fn held_filters_have_the_bias_of_the_paper() {
    let errors = noise_free(DiscretizationName::Paper);
    println!("{errors:.3?}");
    // Zero-order hold makes inertias λT/2 too small and link friction too big.
    for (index, expected) in [
        (0, -1.53),
        (1, -1.56),
        (2, -1.47),
        (3, 2.12),
        (5, 11.9),
        (6, 35.9),
    ] {
        assert!(
            (errors[index] - expected).abs() < 0.3,
            "theta{}: {}",
            index + 1,
            errors[index]
        );
    }
}

/// Median errors in percent over all parameters and ten seeds, on the twin with
/// its encoders and noise: least squares and LSFF.
fn quantised(discretization: DiscretizationName) -> [f64; 2] {
    let (mut experiment, model, truth) = setup();
    experiment.identify.discretization = discretization;
    let channels = Channels::new(&experiment.robot, experiment.log.as_ref().unwrap()).unwrap();
    let mut errors = [Vec::new(), Vec::new()];
    for seed in 0..10 {
        let mut twin = experiment.simulate.clone().unwrap();
        twin.seed = seed;
        let mut log = Vec::new();
        let setup = TwinSetup {
            model: &model,
            theta: &truth,
            controller: experiment.controller.as_ref().unwrap(),
            settings: &twin,
        };
        record(&setup, &channels, &mut log, &mut |_| ()).unwrap();
        let mut reader = || Ok(Box::new(std::io::Cursor::new(log.clone())) as Box<dyn Read>);
        let mut source = LogSource {
            name: "twin".to_owned(),
            reader: &mut reader,
        };
        let found = identify(&experiment, &model, &mut source, &mut |_| ()).unwrap();
        for (errors, result) in errors.iter_mut().zip(&found.identification.results) {
            let values = result.parameters.iter().map(|p| p.value.unwrap());
            errors.extend(values.zip(truth).map(|(x, t)| 100.0 * (x / t - 1.0).abs()));
        }
    }
    errors.map(|mut all| {
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    })
}

#[test]
fn quantised_twin_gives_the_medians_of_the_method() {
    let [paper, lsff] = quantised(DiscretizationName::Paper);
    let [matched, _] = quantised(DiscretizationName::Matched);
    println!("median error: paper {paper:.2} %, matched {matched:.2} %, LSFF {lsff:.1} %");
    assert!((1.3..2.0).contains(&paper), "{paper}");
    assert!((0.9..1.4).contains(&matched), "{matched}");
    assert!((25.0..35.0).contains(&lsff), "{lsff}");
}

#[test]
fn simulation_error_is_below_1e_7_rad() {
    let (experiment, model, truth) = setup();
    let mut plant_a = plant(&experiment, &model, &truth);
    let mut plant_b = plant(&experiment, &model, &truth).with_tolerance(1e-12);
    let mut worst: f64 = 0.0;
    for _ in 0..10_000 {
        for plant in [&mut plant_a, &mut plant_b] {
            let state = plant.state();
            let tau = plant.command(plant.time(), &state.q, &state.phi);
            plant.advance(&tau).unwrap();
        }
        let (a, b) = (plant_a.state(), plant_b.state());
        for i in 0..2 {
            worst = worst
                .max((a.q[i] - b.q[i]).abs())
                .max((a.phi[i] - b.phi[i]).abs());
        }
    }
    println!("largest position error: {worst:.1e} rad");
    assert!(worst < 1e-7, "{worst:e}");
}
