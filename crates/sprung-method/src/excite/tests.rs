//! Tests of the design of experiments.

use super::approach::Approach;
use super::assemble::problem;
use super::bounds::{Bounds, Limited};
use super::certify::certify_reference;
use super::design::{design, value_of};
use super::fourier::Series;
use super::noise::Errors;
use super::problem::ORDERS;
use super::starts::random_motion;
use super::task::{Frequencies, Task};
use crate::demo;
use crate::description::{Excite, Experiment, no_files, read};
use crate::model::Model;
use crate::progress::Unheard;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;

fn demo_experiment(more: &[&str]) -> Experiment {
    let more: Vec<String> = more.iter().map(|&line| line.to_owned()).collect();
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

/// Runs a test on a task for the demo's arm.
fn with_task(more: &[&str], has_loop: bool, test: impl FnOnce(&Task<'_>, &Frequencies)) {
    let experiment = demo_experiment(more);
    let model = Model::new(&experiment).unwrap();
    let (theta, errors, bounds) = (truth(&model), errors(), Bounds::new(&experiment));
    let task = Task {
        model: &model,
        robots: &[],
        theta: &theta,
        settings: &experiment.excite,
        bounds: &bounds,
        errors: &errors,
        controller: experiment.controller.as_ref().filter(|_| has_loop),
        kinematics: None,
        known: None,
        chosen: &[],
    };
    test(&task, &Frequencies::of(&task));
}

/// Compares the gradient of a problem with differences.
fn check_gradient(more: &[&str], has_loop: bool) {
    with_task(more, has_loop, |task, frequencies| {
        let mut problem = problem(task, frequencies, &[1.0; Limited::ALL.len()]);
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
    });
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
    let more = [LIMITS, "excite.steps=40", "excite.starts=2"];
    with_task(&more, true, |task, frequencies| {
        let parts = [0.98; Limited::ALL.len()];
        let found = design(task, frequencies, &parts, None, &mut Unheard).unwrap();
        let begun = Task {
            settings: &Excite {
                steps: 0,
                ..task.settings.clone()
            },
            ..task.clone()
        };
        let start = design(&begun, frequencies, &parts, None, &mut Unheard).unwrap();
        // 0.1 are errors that are 10 % smaller.
        assert!(
            found.objective < start.objective - 0.1,
            "{} {}",
            found.objective,
            start.objective
        );
        let value = value_of(task, frequencies, &found.series).unwrap();
        assert!(
            (value - found.objective).abs() < 1e-9,
            "{value} {}",
            found.objective
        );
    });
}

#[test]
fn a_certificate_holds_on_a_grid_and_names_what_breaks() {
    let more = [
        LIMITS,
        "excite.harmonics=5",
        "excite.steps=5",
        "excite.starts=1",
    ];
    with_task(&more, false, |task, frequencies| {
        let found = design(
            task,
            frequencies,
            &[0.95; Limited::ALL.len()],
            None,
            &mut Unheard,
        )
        .unwrap();
        let kept = certify_reference(&found.series, task.bounds).unwrap();
        for limit in &kept {
            let order = ORDERS.iter().position(|what| *what == limit.what).unwrap();
            let interval = task.bounds.joints[limit.joint].of(limit.what);
            let most = (0..20_000)
                .map(|t| found.series.at(limit.joint, 5e-4 * f64::from(t))[order])
                .fold(0.0, |most: f64, x| most.max(interval.place(x).abs()));
            assert!(most <= limit.part + 1e-9, "{limit:?} {most}");
            assert!(limit.part <= most + 0.01, "{limit:?} {most}");
        }
        let larger = found.series.scaled(4.0);
        let broken = certify_reference(&larger, task.bounds).unwrap_err();
        assert!(broken.part > 1.0 && broken.time_s < 10.0, "{broken:?}");
    });
}

#[test]
fn an_approach_begins_and_ends_at_rest_within_the_limits() {
    let experiment = demo_experiment(&[LIMITS, "excite.harmonics=5"]);
    let model = Model::new(&experiment).unwrap();
    let theta = truth(&model);
    let bounds = Bounds::new(&experiment);
    let series = Series {
        rate: 1.0,
        harmonics: vec![1],
        joints: vec![vec![0.5, 0.0, 0.0], vec![-0.3, 0.0, 0.0]],
    };
    let robot = (&model, theta.as_slice());
    let way = Approach::new(&[0.0, 0.4], &series, robot, &bounds, None)
        .unwrap()
        .unwrap();
    for joint in 0..2 {
        let begin = way.at(joint, 0.0);
        assert!((begin[0] - [0.0, 0.4][joint]).abs() < 1e-12);
        assert!(begin[1..4].iter().all(|x| x.abs() < 1e-12), "{begin:?}");
        let end = way.at(joint, way.duration);
        assert!((end[0] - series.at(joint, 0.0)[0]).abs() < 1e-12);
        assert!(end[1..4].iter().all(|x| x.abs() < 1e-9), "{end:?}");
        for t in 0..1000 {
            let at = way.at(joint, way.duration * f64::from(t) / 1000.0);
            let orders = &bounds.joints[joint].orders;
            assert!(
                (0..3).all(|order| orders[order].place(at[order]).abs() <= 1.0),
                "{t}: {at:?}"
            );
        }
    }
    let far = Approach::new(&[3.0, 0.0], &series, robot, &bounds, None).unwrap_err();
    assert_eq!((far.what, far.joint), (Limited::Position, 0));
}
