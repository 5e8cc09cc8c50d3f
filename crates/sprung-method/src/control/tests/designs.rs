//! Tests of gains, bandwidths, vibrations and simulated designs.

use std::f64::consts::TAU;

use faer::linalg::solvers::Solve;
use faer::{Mat, c64};
use sprung_base::progress::Unheard;
use sprung_core::parameters::JointParameter;

use super::super::gains::{Aim, gains};
use super::super::judge::{drawn, identified, look};
use super::super::pose::linear;
use super::super::sampled::{Law, Sampled};
use super::super::{ControlRefusal, ControlTask, Controlled, design_control, workspace_poses};
use super::{Arm, PERIOD, arm};
use crate::description::{Control, Controller, Feedback, Simulate};
use crate::model::{Model, Theta};
use crate::simulate::{Move, Trajectory};

/// Returns the robot with stiffer springs.
fn stiffened(model: &Model, theta: &[f64], factor: f64) -> Vec<f64> {
    let mut theta = theta.to_vec();
    for joint in 0..model.joint_count() {
        theta[model.index(JointParameter::Stiffness, joint).unwrap()] *= factor;
    }
    theta
}

fn without_friction(model: &Model, theta: &mut [f64]) {
    for (parameter, value) in model.parameters().iter().zip(theta) {
        if parameter.is_friction() {
            *value = 0.0;
        }
    }
}

fn state_feedback(controller: &Controller, gain: Vec<Vec<f64>>) -> Controller {
    Controller {
        kind: crate::description::ControllerKind::StateFeedback,
        gain,
        velocity_window: [0, 0],
        ..controller.clone()
    }
}

/// Returns the rates of the poles of a loop, 1/s, the slowest first.
fn rates(plant: &Sampled, controller: &Controller) -> Vec<c64> {
    let poles = plant.poles(&Law::of(controller, 2)).unwrap();
    let mut all: Vec<c64> = poles.iter().filter_map(|pole| plant.rate(*pole)).collect();
    all.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
    all
}

#[test]
fn with_stiff_springs_the_joints_have_the_bandwidth_and_the_damping_that_are_asked_for() {
    const SHORT: f64 = 2e-5;
    let Arm {
        model,
        mut theta,
        controller,
    } = arm();
    without_friction(&model, &mut theta);
    let stiff = stiffened(&model, &theta, 1e4);
    let value = |name: &str| theta[model.index_of(name).unwrap()];
    // In this pose no inertia couples the joints, so each moves as one body.
    let elbow = (-value("link2.inertia") / value("link2.coupling")).acos();
    let linear = linear(&model, &stiff, &[0.2, elbow]).unwrap();
    let plant = Sampled::new(&model, &linear, SHORT);
    let aim = Aim {
        feedback: Feedback::StateFeedback,
        bandwidth_hz: vec![6.0, 6.0],
        damping: 0.9,
    };
    let gain = gains(&model, &linear, &plant, &aim).unwrap();
    let all = rates(&plant, &state_feedback(&controller, gain));
    for rate in &all[..4] {
        let (hz, damping) = (rate.norm() / TAU, -rate.re / rate.norm());
        assert!((hz / 6.0 - 1.0).abs() < 0.02, "{hz} Hz");
        assert!((damping - 0.9).abs() < 0.02, "{damping}");
    }
}

#[test]
fn damped_links_have_the_poles_of_a_damper_between_link_and_base() {
    const SHORT: f64 = 1e-6;
    let Arm {
        model,
        mut theta,
        controller,
    } = arm();
    without_friction(&model, &mut theta);
    let linear = linear(&model, &theta, &[0.3, 0.8]).unwrap();
    let plant = Sampled::new(&model, &linear, SHORT);
    let aim = Aim {
        feedback: Feedback::LinkDamping,
        bandwidth_hz: vec![2.0, 2.0],
        damping: 0.7,
    };
    let gain = gains(&model, &linear, &plant, &aim).unwrap();
    let found = rates(&plant, &state_feedback(&controller, gain));
    // M q̈ + D q̇ + K (q - η) = 0, B η̈ + kd η̇ + kp η + K (η - q) = 0, written out.
    let rate = TAU * 2.0;
    let (mass, spring) = (&linear.mass, &linear.stiffness);
    let damper = Mat::from_fn(4, 4, |i, j| match (i == j, i < 2) {
        (false, _) => 0.0,
        (true, true) => 1.4 * (-spring[(i + 2, i)] * mass[(i, i)]).sqrt(),
        (true, false) => 1.4 * rate * (mass[(i, i)] + mass[(i - 2, i - 2)]),
    });
    let stiffness = Mat::from_fn(4, 4, |i, j| {
        let kp = rate * rate * (mass[(i, i)] + mass[(i % 2, i % 2)]);
        spring[(i, j)] + if i == j && i >= 2 { kp } else { 0.0 }
    });
    let factors = mass.partial_piv_lu();
    let (by_position, by_velocity) = (factors.solve(&stiffness), factors.solve(&damper));
    let whole = Mat::from_fn(8, 8, |i, j| match (i < 4, j < 4) {
        (true, _) => f64::from(u8::from(j == i + 4)),
        (false, true) => -by_position[(i - 4, j)],
        (false, false) => -by_velocity[(i - 4, j - 4)],
    });
    for known in whole.eigenvalues().unwrap() {
        let nearest = found
            .iter()
            .map(|pole| (pole - known).norm())
            .fold(f64::INFINITY, f64::min);
        assert!(nearest < 2e-3 * known.norm(), "{known} {nearest}");
    }
}

/// A design with its own twin.
struct Case {
    model: Model,
    theta: Theta,
    draws: Vec<Theta>,
    declared: Controller,
    settings: Control,
    poses: Vec<Vec<f64>>,
    twin: Simulate,
}

impl Case {
    /// Returns the demo's arm, and robots whose springs and inertias differ by up to 2 %.
    fn new(settings: Control) -> Self {
        let Arm {
            model,
            theta,
            controller: declared,
        } = arm();
        let draws = (0..6)
            .map(|k| {
                let factor = 1.0 + 0.004 * (f64::from(k) - 2.5);
                stiffened(&model, &theta, factor)
            })
            .collect();
        Self {
            poses: workspace_poses(&[[-2.0, 2.0]; 2], 5),
            twin: toml::from_str("duration_s = 3.0\nperiod_s = 0.001").unwrap(),
            theta,
            draws,
            declared,
            model,
            settings,
        }
    }

    fn task(&self) -> ControlTask<'_> {
        ControlTask {
            model: &self.model,
            theta: &self.theta,
            draws: &self.draws,
            settings: &self.settings,
            declared: Some(&self.declared),
            period: PERIOD,
            window: [4, 4],
            poses: &self.poses,
            ranges: &[[-2.0, 2.0]; 2],
            torque_limits: &[f64::INFINITY; 2],
            twin: &self.twin,
            reference: Some(&self.declared.reference),
        }
    }

    fn design(&self) -> Result<Controlled, ControlRefusal> {
        design_control(&self.task(), "arm", None, Vec::new(), &mut Unheard)
    }
}

fn settings(feedback: Feedback) -> Control {
    Control {
        feedback,
        simulations: 3,
        ..Control::default()
    }
}

#[test]
fn the_largest_bandwidth_keeps_the_margins_and_more_is_refused_with_it() {
    let free = Case::new(settings(Feedback::Pd)).design().unwrap().design;
    let largest = free.bandwidth.unwrap().largest_hz;
    for margins in &free.loops {
        assert!(margins.gain_db.is_none_or(|gain| gain.worst >= 6.0));
        assert!(margins.phase_deg.worst >= 40.0);
    }
    let asked = |part: f64| {
        let hz = largest.iter().map(|bandwidth| part * bandwidth).collect();
        Case::new(Control {
            bandwidth_hz: hz,
            ..settings(Feedback::Pd)
        })
        .design()
    };
    let slower = asked(0.7).unwrap().design;
    let used = slower.bandwidth.unwrap().used_hz;
    assert!((used[0] / largest[0] - 0.7).abs() < 1e-9);
    match asked(1.5) {
        Err(ControlRefusal::TooFast { largest_hz, .. }) => {
            assert!((largest_hz[1] / largest[1] - 1.0).abs() < 0.1);
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn held_links_vibrate_with_the_roots_of_their_two_equations() {
    let case = Case::new(settings(Feedback::Declared));
    let task = case.task();
    let cases = [identified(&task), drawn(&task)].concat();
    let seen = look(&task, &case.declared, &cases);
    let value = |name: &str| case.theta[case.model.index_of(name).unwrap()];
    let stiffness =
        |joint: usize| case.theta[case.model.index(JointParameter::Stiffness, joint).unwrap()];
    for view in seen.iter().filter(|view| view.robot == 0) {
        let cos = case.poses[view.pose][1].cos();
        let (coupling, second) = (value("link2.coupling"), value("link2.inertia"));
        let first = value("link1.inertia_total") + 2.0 * coupling * cos;
        let mixed = second + coupling * cos;
        // |K - w² M| = 0 as a quadratic equation of w².
        let a = first * second - mixed * mixed;
        let b = first * stiffness(1) + second * stiffness(0);
        let root = (b * b - 4.0 * a * stiffness(0) * stiffness(1)).sqrt();
        let known =
            [(b - root) / (2.0 * a), (b + root) / (2.0 * a)].map(|square| square.sqrt() / TAU);
        let mut found: Vec<f64> = view.springs[1]
            .iter()
            .flatten()
            .map(|[hz, _]| *hz)
            .collect();
        found.sort_by(f64::total_cmp);
        for (found, known) in found.iter().zip(known) {
            assert!((found / known - 1.0).abs() < 1e-3, "{found} {known}");
        }
    }
}

#[test]
fn feedforward_and_state_feedback_follow_better_than_the_declared_loop() {
    let design = Case::new(settings(Feedback::StateFeedback))
        .design()
        .unwrap()
        .design;
    for tracking in &design.proof.tracking {
        assert!(tracking.designed_rad.worst < 0.25 * tracking.declared_rad.unwrap());
    }
    assert_eq!(design.proof.moves.limit_cycles, 0);
    assert!(design.shaper.is_none());
}

#[test]
fn a_shaper_leaves_little_of_the_vibration_of_a_simulated_move() {
    let all = Control {
        shaper_modes: Some(3),
        ..settings(Feedback::Declared)
    };
    let design = Case::new(all).design().unwrap().design;
    let shaper = design.shaper.unwrap();
    assert!(shaper.reached && shaper.largest_percent <= 5.0);
    let moves = design.proof.moves;
    assert!(moves.unshaped_rad.identified > 1e-3);
    // Twice the level: the deviation from the mean also contains the end of motions that do not vibrate.
    let largest = moves.largest_percent.unwrap();
    assert!(largest < 10.0, "{largest}");
}

#[test]
fn moves_are_as_smooth_as_they_say() {
    let motion = Trajectory::of_move(Move {
        ends: [vec![0.2], vec![-0.5]],
        begin: 0.1,
        duration: 0.8,
    })
    .shaped(vec![[0.0, 0.6], [0.3, 0.4]]);
    let at = |time: f64| {
        let mut states = [[0.0; 5]];
        motion.at(time, &mut states);
        states[0]
    };
    assert!((at(0.0)[0] - 0.2).abs() < 1e-12 && (at(1.3)[0] + 0.5).abs() < 1e-12);
    let step = 1e-5;
    for k in 0..140 {
        let time = 0.01 * f64::from(k) + 0.003;
        let (before, after, here) = (at(time - step), at(time + step), at(time));
        for order in 0..4 {
            let slope = (after[order] - before[order]) / (2.0 * step);
            let size = 1.0 + here[order + 1].abs();
            assert!(
                (slope - here[order + 1]).abs() < 1e-5 * size,
                "{time} {order}"
            );
        }
    }
}

#[test]
fn a_shaped_step_has_the_steps_of_its_impulses() {
    let motion = Trajectory::of_move(Move {
        ends: [vec![0.2], vec![1.2]],
        begin: 0.0,
        duration: 0.0,
    })
    .shaped(vec![[0.0, 0.6], [0.3, 0.4]]);
    for (time, position) in [(0.0, 0.8), (0.29, 0.8), (0.31, 1.2)] {
        let mut states = [[0.0; 5]];
        motion.at(time, &mut states);
        assert!(
            (states[0][0] - position).abs() < 1e-12,
            "{time}: {}",
            states[0][0]
        );
    }
}

#[test]
fn an_unstable_declared_loop_is_refused() {
    let mut case = Case::new(settings(Feedback::Declared));
    case.declared.kp_nm_per_rad = vec![5000.0, 500.0];
    case.declared.kd_nms_per_rad = vec![0.0, 0.0];
    assert!(matches!(
        case.design(),
        Err(ControlRefusal::Unstable { .. })
    ));
}
