//! Functions that run once per sample do not allocate.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

#[path = "planar_2r/mod.rs"]
mod planar_2r;

use std::hint::black_box;

use allocation_counter::measure;
use planar_2r::PARAMETERS;
use sprung_core::chain::{Chain, ChainJoint, DhRow};
use sprung_core::controller::{
    Compensation, Feedforward, FeedforwardScratch, TorqueSeries, pd, state_feedback,
};
use sprung_core::drives::{State, Term};
use sprung_core::filter::{Discretization, FilterPair, FilterState};
use sprung_core::friction::Shape;
use sprung_core::links::{JointScratch, PairScratch, Step, Workspace, numbers_len};
use sprung_core::parameters::JointParameter::{RotorInertia, Stiffness};
use sprung_core::presliding::ALL_ELEMENTS;
use sprung_core::recursive::{ForgettingLeastSquares, Settings, memory_len};
use sprung_core::robot::{Links, Robot, Torques, Values};
use sprung_core::scalar::Scalar;
use sprung_core::shaper::{Mode, Shaper, Tap, sample, zero_vibration};
use sprung_core::spatial::BODY;
use sprung_core::velocity::AveragedVelocity;

const THETA: [f64; PARAMETERS] = [
    0.207, 0.0176, 0.0132, 0.217, 0.00684, 0.0377, 0.00296, 8.44, 0.136, 9.36, 4.21, 0.0158,
    0.00502, 1.36, 0.163,
];

const fn shapes<const N: usize>() -> [Shape; N] {
    [Shape {
        sharpness: 100.0,
        stribeck_velocity: 0.1,
        presliding_width: 0.5,
        hysteresis_width: 0.05,
        play: 0.0,
        play_centre: 0.0,
    }; N]
}

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

/// Runs regressor, acceleration and feedforward with all memory on the stack.
///
/// - `N`: joints; `PAIRS`: their square; `NUMBERS`: [`numbers_len`] of them.
fn assert_physics_is_free<const N: usize, const PAIRS: usize, const NUMBERS: usize>(
    robot: &Robot<'_>,
    values: &Values<'_>,
    entries: [&mut [f64]; 2],
) {
    let state = State {
        q: &[0.1; N],
        dq: &[0.3; N],
        phi: &[0.15; N],
        dphi: &[0.3; N],
        excess: &[],
        elements: &[],
    };
    let mut workspace = Workspace {
        joints: &mut [JointScratch::default(); N],
        steps: &mut [Step::default(); N],
        pairs: &mut [PairScratch::default(); PAIRS],
        numbers: &mut [0.0; NUMBERS],
    };
    let [momentum, rest] = entries;
    assert_free("a regressor", || {
        (robot.regressor(black_box(&state), &mut workspace, momentum, rest)).unwrap();
        black_box((momentum, rest));
    });
    assert_free("an acceleration", || {
        let torques = Torques {
            motor: &black_box([1.0; N]),
            link: None,
        };
        let [mut torque, mut out] = [[0.0; NUMBERS]; 2];
        let torque = &mut torque[..robot.rows()];
        let out = &mut out[..robot.rows()];
        robot.coordinate_torques(&torques, torque).unwrap();
        (robot.acceleration(values, &state, torque, &mut workspace, out)).unwrap();
        assert!(out.iter().all(|x| x.is_finite()));
    });
    let elements = vec![0.5; N * ALL_ELEMENTS];
    assert_free("a feedforward", || {
        let mut series = [[TorqueSeries::ZERO; N]; 4];
        let mut scratch = FeedforwardScratch {
            series: series.each_mut().map(<[_; N]>::as_mut_slice),
            steps: &mut [Step::default(); N],
        };
        let mut out = Feedforward {
            tau: &mut [0.0; N],
            phi: &mut [0.0; N],
            dphi: &mut [0.0; N],
        };
        let wanted = black_box([[0.1; 5]; N]);
        for speed in [None, Some(0.1)] {
            let compensation = speed.map(|speed| Compensation {
                speed,
                elements: &elements,
            });
            (out.fill(robot, values, &wanted, compensation, &mut scratch)).unwrap();
            assert!(out.tau.iter().all(|x| x.is_finite()));
        }
    });
}

#[test]
fn physics_of_the_planar_arm_is_free_of_allocations() {
    const N: usize = planar_2r::JOINTS;
    let values = Values {
        theta: &THETA,
        bodies: &planar_2r::bodies(&THETA),
    };
    let [mut momentum, mut rest] = [[0.0; planar_2r::ENTRIES]; 2];
    assert_physics_is_free::<N, { N * N }, { numbers_len(N) }>(
        &planar_2r::robot(&shapes()),
        &values,
        [&mut momentum, &mut rest],
    );
}

/// A tree of seven joints with two rigid ones at its end. One motor of the flexible part and one of the rigid part
/// also turn another joint.
#[test]
fn physics_of_a_tree_is_free_of_allocations() {
    const N: usize = 7;
    const FLEXIBLE: usize = 5;
    let joints: [ChainJoint; N] = std::array::from_fn(|j| {
        let row = DhRow {
            alpha: [1.5, -1.2][j % 2],
            a: 0.3,
            d: 0.1,
            theta: 0.2,
        };
        // Two branches leave joint 4.
        let parent = [None, Some(0), Some(1), Some(2), Some(3), Some(4), Some(4)][j];
        ChainJoint::modified_dh(parent, &row)
    });
    let chain = Chain::new(&joints, [0.0, 0.0, -9.81]).unwrap();
    let bodies = [[1.0, 0.1, 0.0, 0.05, 0.2, 0.0, 0.2, 0.0, 0.0, 0.2]; N];
    let motor_rows: [Option<usize>; N] = std::array::from_fn(|i| (i < FLEXIBLE).then_some(N + i));
    let mut coupling = [0.0; N * N];
    for k in 0..N {
        coupling[k * N + k] = 1.0;
    }
    coupling[N] = 0.2;
    coupling[N * N - 2] = -0.3;
    let mut theta: Vec<f64> = bodies.concat();
    let mut entries = N * N * BODY;
    let mut terms = Vec::new();
    for joint in 0..N {
        let column = theta.len();
        let mut put = |row: usize, column: usize, what, gain: f64| {
            terms.push(Term {
                row,
                entry: entries,
                column,
                what,
                joint,
                gain,
            });
            entries += 1;
        };
        for (i, motor_row) in motor_rows.iter().enumerate() {
            put(
                motor_row.unwrap_or(i),
                column,
                RotorInertia,
                coupling[joint * N + i],
            );
        }
        if let Some(motor_row) = motor_rows[joint] {
            put(joint, column + 1, Stiffness, -1.0);
            put(motor_row, column + 1, Stiffness, 1.0);
        }
        theta.extend([0.1, 200.0]);
    }
    let robot = Robot {
        links: Links {
            shares: &[],
            chain,
            selected: &std::array::from_fn::<usize, { N * BODY }, _>(|k| k % BODY),
            first: &std::array::from_fn::<usize, { N + 1 }, _>(|j| j * BODY),
            entries: &std::array::from_fn::<usize, { N * N }, _>(|pair| pair * BODY),
        },
        terms: &terms,
        shapes: &shapes::<N>(),
        coupling: Some(&coupling),
        motor_rows: &motor_rows,
        entries,
    };
    let values = Values {
        theta: &theta,
        bodies: &bodies,
    };
    let [mut momentum, mut rest] = [(); 2].map(|()| vec![0.0; entries]);
    assert_physics_is_free::<N, { N * N }, { numbers_len(N) }>(
        &robot,
        &values,
        [&mut momentum, &mut rest],
    );
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
    let two = [0.1, -0.2];
    assert_free("PD", || {
        let mut tau = [0.0; 2];
        let reference = black_box([&two[..]; 2]);
        pd(&[50.0, 5.0], &[0.05, 0.01], reference, [&two; 2], &mut tau);
        black_box(tau);
    });
    assert_free("state feedback", || {
        let state = State {
            q: &two,
            dq: &two,
            phi: &two,
            dphi: &two,
            excess: &[],
            elements: &[],
        };
        let mut tau = black_box([1.0; 2]);
        state_feedback(&[&[1.0; 8][..]; 2], &state, &black_box(state), &mut tau);
        black_box(tau);
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

#[test]
fn a_shaper_is_free_of_allocations() {
    let mode = Mode::from_hz(25.0, 0.05).unwrap();
    assert_free("input shaper", || {
        let mut taps = [Tap::default(); 6];
        let count = sample(&zero_vibration::<3>(&mode), 1e-3, &mut taps).unwrap();
        let mut memory = [0.0; 2 * 42];
        let mut shaper = Shaper::new(&taps[..count], &[0.0; 2], &mut memory[..]).unwrap();
        let mut output = [0.0; 2];
        shaper.process(&black_box([1.0, 2.0]), &mut output).unwrap();
        black_box(output);
    });
}
