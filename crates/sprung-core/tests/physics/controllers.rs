//! The two controllers against numbers worked out by hand.

use sprung_core::controller::{Feedforward, Pd, StateFeedback};
use sprung_core::regressor::JointState;

#[test]
fn pd_torque_is_that_of_a_hand_calculation() {
    let pd = Pd {
        kp: [50.0, 5.0],
        kd: [0.05, 0.01],
    };
    let tau = pd.torque(&[0.3, -0.1], &[2.0, 1.0], &[0.1, 0.1], &[-2.0, 3.0]);
    // 50 · 0.2 + 0.05 · 4 and 5 · (-0.2) + 0.01 · (-2).
    assert!((tau[0] - 10.2).abs() < 1e-14 && (tau[1] + 1.02).abs() < 1e-15);
}

#[test]
fn state_feedback_takes_errors_in_the_printed_order() {
    let feedback = StateFeedback {
        gain: [
            [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0],
            [10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0],
        ],
    };
    let desired = Feedforward {
        tau: [0.5, -0.5],
        state: JointState::default(),
    };
    // The errors of q, phi, dq, dphi are distinct digits.
    let state = JointState {
        q: [-1.0, -1e1],
        phi: [-1e2, -1e3],
        dq: [-1e4, -1e5],
        dphi: [-1e6, -1e7],
    };
    let tau = feedback.torque(&desired, &state);
    assert!((tau[0] - 87_654_321.5).abs() < 1e-7, "{}", tau[0]);
    assert!((tau[1] - 876_543_209.5).abs() < 1e-6, "{}", tau[1]);
}

#[test]
fn state_feedback_on_the_desired_state_is_the_feedforward() {
    let theta = [
        0.2, 0.02, 0.01, 0.2, 0.007, 0.04, 0.003, 8.0, 0.1, 9.0, 4.0, 0.02, 0.005, 1.4, 0.2,
    ];
    let q_d = [[0.1, 0.2, -0.3, 0.4, -0.5], [-0.3, 0.5, 0.7, -0.2, 0.1]];
    let desired = Feedforward::new(&q_d, &theta);
    let feedback = StateFeedback {
        gain: [[1e6; 8]; 2],
    };
    let tau = feedback.torque(&desired, &desired.state);
    for (tau, nominal) in tau.iter().zip(desired.tau) {
        assert!(nominal.is_finite() && (tau - nominal).abs() < 1e-15);
    }
}

#[test]
fn feedforward_without_stiffness_does_not_look_like_a_torque() {
    let desired = Feedforward::new(&[[0.1; 5]; 2], &[0.0; 15]);
    assert!(desired.tau.iter().all(|tau| !tau.is_finite()));
}
