//! Tests of the design of experiments.

use super::bounds::{Bounds, Limited};
use super::design::{Frequencies, Task, design, information, problem, random_motion};
use super::noise::Errors;
use crate::demo;
use crate::description::{Experiment, no_files, read};
use crate::model::Model;
use crate::progress::Unheard;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;

fn demo_experiment(more: &[&str]) -> Experiment {
    let more: Vec<String> = more.iter().map(|&own| own.to_owned()).collect();
    read("demo", demo::EXPERIMENT, &more, &mut no_files).unwrap()
}

fn truth(model: &Model) -> Vec<f64> {
    let values: BTreeMap<String, f64> = toml::from_str(demo::TRUTH).unwrap();
    model.theta(&values).unwrap()
}

fn errors() -> Errors {
    let steps = vec![std::f64::consts::TAU / 16384.0; 2];
    Errors {
        period: 1e-3,
        steps: [steps.clone(), steps],
        torque: vec![0.02, 0.005],
        disturbances: [vec![0.0; 2], vec![0.0; 2]],
        corner: 3.0,
    }
}

/// Compares the gradient of a problem with differences.
fn check_gradient(more: &[&str], has_loop: bool) {
    let experiment = demo_experiment(more);
    let model = Model::new(&experiment).unwrap();
    let theta = truth(&model);
    let errors = errors();
    let bounds = Bounds::new(&experiment);
    let controller = experiment.controller.as_ref().filter(|_| has_loop);
    let task = Task {
        model: &model,
        theta: &theta,
        settings: &experiment.excite,
        bounds: &bounds,
        errors: &errors,
        controller,
        kinematics: None,
        known: None,
        chosen: &[],
    };
    let frequencies = Frequencies::of(&task);
    let mut problem = problem(&task, &frequencies, &[1.0; Limited::ALL.len()]);
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let x = random_motion(&mut problem, &mut rng, 0.8).unwrap();
    let value = problem.value(&x, 0.1).unwrap();
    for k in [0, 1, 2, x.len() / 2, x.len() - 1] {
        let step = 1e-6;
        let at = |step: f64, problem: &mut super::problem::Problem| {
            let mut x = x.clone();
            x[k] += step;
            problem.value(&x, 0.1).unwrap().total
        };
        let slope = (at(step, &mut problem) - at(-step, &mut problem)) / (2.0 * step);
        let found = value.by_motion[k] + value.by_reference[k];
        assert!(
            (found - slope).abs() < 1e-4 * (1e-3 + slope.abs()),
            "{k}: {found} {slope}"
        );
    }
}

const LIMITS: &str = "robot.joint_defaults.limits={position_rad=[-1.0, 1.2], velocity_rad_per_s=3.0, \
     acceleration_rad_per_s2=20.0, torque_nm=8.0, torque_rate_nm_per_s=100.0, deflection_rad=0.4}";

#[test]
fn the_gradient_of_a_followed_motion_is_that_of_differences() {
    check_gradient(&[LIMITS, "excite.harmonics=5"], false);
}

#[test]
fn the_gradient_of_a_closed_loop_is_that_of_differences() {
    check_gradient(&[LIMITS, "excite.harmonics=5", "excite.duration_s=3"], true);
}

#[test]
fn a_search_makes_the_errors_smaller() {
    let experiment = demo_experiment(&[LIMITS, "excite.steps=40", "excite.starts=2"]);
    let model = Model::new(&experiment).unwrap();
    let theta = truth(&model);
    let errors = errors();
    let bounds = Bounds::new(&experiment);
    let task = Task {
        model: &model,
        theta: &theta,
        settings: &experiment.excite,
        bounds: &bounds,
        errors: &errors,
        controller: experiment.controller.as_ref(),
        kinematics: None,
        known: None,
        chosen: &[],
    };
    let frequencies = Frequencies::of(&task);
    let started = std::time::Instant::now();
    let found = design(&task, &frequencies, &[0.98; Limited::ALL.len()], None, &mut Unheard);
    let found = found.unwrap();
    println!("{:?} {:?} {:?}", started.elapsed(), found.objective, found.of_starts);
    assert!(information(&task, &frequencies, &found.series).is_some());
}
