//! Nothing that runs once per sample allocates.

use std::hint::black_box;

use allocation_counter::measure;
use sprung_core::controller::{Feedforward, Pd, StateFeedback};
use sprung_core::filter::{Discretization, FilterPair, FilterState};
use sprung_core::recursive::{ForgettingLeastSquares, Settings, memory_len};
use sprung_core::regressor::{JointState, PARAMETERS, PlanarArm};
use sprung_core::velocity::AveragedVelocity;

const ARM: PlanarArm = PlanarArm {
    coulomb_sharpness: [100.0, 100.0],
};

const THETA: [f64; PARAMETERS] = [
    0.207, 0.0176, 0.0132, 0.217, 0.00684, 0.0377, 0.00296, 8.44, 0.136, 9.36, 4.21, 0.0158,
    0.00502, 1.36, 0.163,
];

const STATE: JointState = JointState {
    q: [0.1, -0.2],
    dq: [0.3, 0.4],
    phi: [0.15, -0.25],
    dphi: [-0.5, 0.6],
};

fn assert_free(what: &str, step: impl FnOnce()) {
    let count = measure(step).count_total;
    assert_eq!(count, 0, "{what} allocates {count} times");
}

#[test]
fn the_counter_sees_allocations() {
    assert_eq!(
        measure(|| drop(black_box(vec![1.0; 15]))).count_total,
        1,
        "a vector is one allocation"
    );
}

#[test]
fn physics_is_free_of_allocations() {
    assert_free("a regressor", || {
        black_box(ARM.regressor(black_box(&STATE)));
    });
    assert_free("an acceleration", || {
        black_box(ARM.acceleration(&THETA, black_box(&STATE), &[1.0, 2.0]));
    });
}

#[test]
fn filters_are_free_of_allocations() {
    assert_free("a filter", || {
        let pair = FilterPair::new(30.0, 1e-3, Discretization::Tustin).unwrap();
        let mut state = FilterState::default();
        for k in 0..3 {
            black_box(pair.process(&mut state, f64::from(k), 1.0));
        }
    });
    assert_free("a velocity", || {
        let mut velocity = AveragedVelocity::new(4, 4, 1e-3).unwrap();
        for k in 0..3 {
            black_box(velocity.process(f64::from(k)));
        }
    });
}

#[test]
fn controllers_are_free_of_allocations() {
    let pd = Pd {
        kp: [50.0, 5.0],
        kd: [0.05, 0.01],
    };
    let feedback = StateFeedback {
        gain: [[1.0; 8]; 2],
    };
    assert_free("PD", || {
        let [q, dq, phi, dphi] = black_box([STATE.q, STATE.dq, STATE.phi, STATE.dphi]);
        black_box(pd.torque(&q, &dq, &phi, &dphi));
    });
    assert_free("state feedback", || {
        let desired = Feedforward::new(black_box(&[[0.1; 5]; 2]), &THETA);
        black_box(feedback.torque(&desired, &STATE));
    });
}

#[test]
fn a_recursive_step_is_free_of_allocations() {
    let settings = Settings {
        forgetting: 1.0,
        initial_gain: 10.0,
        gain_limit: 1e8,
        period: 1e-3,
    };
    let memory = [0.0; memory_len(PARAMETERS)];
    assert_free("LSFF", || {
        let mut lsff = ForgettingLeastSquares::new(&settings, PARAMETERS, memory).unwrap();
        lsff.forget();
        for row in 0..4 {
            lsff.update(&black_box([0.1; PARAMETERS]), f64::from(row));
        }
        black_box(lsff.theta());
    });
}
