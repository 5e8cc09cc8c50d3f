//! The two controllers against numbers worked out by hand.
use sprung_core::controller::{pd, state_feedback};
use sprung_core::drives::State;
use sprung_core::friction::Shape;
use sprung_core::robot::Values;

use crate::planar_2r::{PARAMETERS, bodies, robot};
use crate::support::{JointState, feedforward};

const SHAPES: [Shape; 2] = [Shape {
    sharpness: 100.0,
    stribeck_velocity: 0.1,
    presliding_width: 0.5,
    hysteresis_width: 0.05,
    play: 0.0,
    play_centre: 0.0,
}; 2];

fn nominal(theta: &[f64; PARAMETERS], q_d: &[[f64; 5]; 2]) -> (Vec<f64>, JointState) {
    let bodies = &bodies(theta);
    feedforward(&robot(&SHAPES), &Values { theta, bodies }, q_d, None)
}

#[test]
fn pd_torque_is_that_of_a_hand_calculation() {
    let mut tau = [f64::NAN; 2];
    pd(
        &[50.0, 5.0],
        &[0.05, 0.01],
        [&[0.3, -0.1], &[2.0, 1.0]],
        [&[0.1, 0.1], &[-2.0, 3.0]],
        &mut tau,
    );
    // 50 · 0.2 + 0.05 · 4 and 5 · (-0.2) + 0.01 · (-2).
    assert!((tau[0] - 10.2).abs() < 1e-14 && (tau[1] + 1.02).abs() < 1e-15);
}

#[test]
fn state_feedback_takes_errors_in_the_printed_order() {
    let gain: [&[f64]; 2] = [
        &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0],
        &[10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0],
    ];
    let zero = [0.0; 2];
    let desired = State {
        q: &zero,
        dq: &zero,
        phi: &zero,
        dphi: &zero,
        excess: &[],
        elements: &[],
    };
    // The errors of q, phi, dq and dphi are distinct decimal digits, so each digit of the torque shows one gain.
    let measured = State {
        q: &[-1.0, -1e1],
        phi: &[-1e2, -1e3],
        dq: &[-1e4, -1e5],
        dphi: &[-1e6, -1e7],
        excess: &[],
        elements: &[],
    };
    let mut tau = [0.5, -0.5];
    state_feedback(&gain, &desired, &measured, &mut tau);
    // Rounding: 1e-15 of the torques.
    assert!((tau[0] - 87_654_321.5).abs() < 1e-7, "{}", tau[0]);
    assert!((tau[1] - 876_543_209.5).abs() < 1e-6, "{}", tau[1]);
}

#[test]
fn state_feedback_on_the_desired_state_is_the_feedforward() {
    let theta = [
        0.2, 0.02, 0.01, 0.2, 0.007, 0.04, 0.003, 8.0, 0.1, 9.0, 4.0, 0.02, 0.005, 1.4, 0.2,
    ];
    let q_d = [[0.1, 0.2, -0.3, 0.4, -0.5], [-0.3, 0.5, 0.7, -0.2, 0.1]];
    let (feedforward, desired) = nominal(&theta, &q_d);
    let mut tau = feedforward.clone();
    let gain: [&[f64]; 2] = [&[1e6; 8]; 2];
    state_feedback(&gain, &desired.view(), &desired.view(), &mut tau);
    for (tau, nominal) in tau.iter().zip(feedforward) {
        assert!(nominal.is_finite() && (tau - nominal).abs() < 1e-15);
    }
}

#[test]
fn feedforward_without_stiffness_does_not_look_like_a_torque() {
    let (tau, _) = nominal(&[0.0; PARAMETERS], &[[0.1; 5]; 2]);
    assert!(tau.iter().all(|tau| !tau.is_finite()));
}
