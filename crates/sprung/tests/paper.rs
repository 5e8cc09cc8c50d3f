//! The numbers of the paper's method, on the digital twin.

use std::collections::BTreeMap;

use sprung::demo;
use sprung::description::{self, DiscretizationName, Experiment};
use sprung::estimate::fit;
use sprung::model::{Model, Theta};
use sprung::regression::{FilteredRegression, Reduction};
use sprung::simulate::ClosedLoop;

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
        let tau = plant.command(&state.q, &state.phi);
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

#[test]
fn simulation_error_is_below_1e_7_rad() {
    let (experiment, model, truth) = setup();
    let mut plant_a = plant(&experiment, &model, &truth);
    let mut plant_b = plant(&experiment, &model, &truth).with_tolerance(1e-12);
    let mut worst: f64 = 0.0;
    for _ in 0..10_000 {
        for plant in [&mut plant_a, &mut plant_b] {
            let state = plant.state();
            let tau = plant.command(&state.q, &state.phi);
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
