//! Numbers from independent code: NumPy for the filters, Pinocchio and the
//! corrected matrices of the paper for the regressor.
//!
//! A few of them stand in `fixtures/`; the full sets are read where they lie
//! beside the repository.
#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a test may panic, and says what it measured"
)]

use serde_json::Value;
use sprung_core::filter::{Discretization, FilterPair, FilterState};
use sprung_core::regressor::{JointState, PARAMETERS, PlanarArm, ROW_COLUMNS};

/// Largest error, as part of the largest number of the same kind.
const TOLERANCE: f64 = 1e-12;

/// The parameters that the golden products were formed with.
const THETA: [f64; PARAMETERS] = [
    0.207_184, 0.017_58, 0.013_163, 0.216_776, 0.006_842, 0.037_675, 0.002_959, 8.435_283,
    0.135_564, 9.358_73, 4.212_811, 0.015_771, 0.005_018, 1.360_21, 0.162_529,
];

fn fixture(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// A file of the full sets, or nothing and a word about it.
fn golden(name: &str) -> Option<Value> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/golden");
    if let Ok(text) = std::fs::read_to_string(format!("{folder}/{name}")) {
        Some(fixture(&text))
    } else {
        eprintln!("skipped: no golden vectors at {folder}/{name}");
        None
    }
}

fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().unwrap();
    list.iter().map(|x| x.as_f64().unwrap()).collect()
}

fn pair(value: &Value) -> [f64; 2] {
    numbers(value).try_into().unwrap()
}

fn assert_close(what: &str, found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    let scale = expected.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
    let worst = (found.iter().zip(expected))
        .map(|(a, b)| (a - b).abs() / scale)
        .fold(0.0, f64::max);
    println!("{what}: {worst:.1e}");
    assert!(worst < TOLERANCE, "{what}: {worst:e}");
}

fn check_filters(golden: &Value) {
    let (cutoff, period) = (&golden["lam"], &golden["T"]);
    let x = numbers(&golden["x"]);
    for (name, discretization) in [
        ("zoh", Discretization::ZeroOrderHold),
        ("tustin", Discretization::Tustin),
    ] {
        let pair = FilterPair::new(
            cutoff.as_f64().unwrap(),
            period.as_f64().unwrap(),
            discretization,
        )
        .unwrap();
        let (mut f, mut g) = (FilterState::default(), FilterState::default());
        let low: Vec<f64> = x.iter().map(|&x| pair.process(&mut f, 0.0, x)).collect();
        let rate: Vec<f64> = x.iter().map(|&x| pair.process(&mut g, x, 0.0)).collect();
        assert_close(
            &format!("{name} f"),
            &low,
            &numbers(&golden[name]["f_rest"]),
        );
        assert_close(
            &format!("{name} g"),
            &rate,
            &numbers(&golden[name]["g_rest"]),
        );
    }
}

fn check_regressor(golden: &Value) {
    let arm = PlanarArm {
        coulomb_sharpness: [100.0, 100.0],
    };
    for case in golden["cases"].as_array().unwrap() {
        let state = JointState {
            q: pair(&case["q"]),
            dq: pair(&case["qd"]),
            phi: pair(&case["phi"]),
            dphi: pair(&case["phid"]),
        };
        let (mut y_a, mut y_b) = ([[0.0; PARAMETERS]; 4], [[0.0; PARAMETERS]; 4]);
        let entries = arm.regressor(&state);
        let mut next = entries.iter();
        for (row, columns) in ROW_COLUMNS.iter().enumerate() {
            for (&column, entry) in columns.iter().zip(&mut next) {
                y_a[row][column] = entry.momentum;
                y_b[row][column] = entry.rest;
            }
        }
        let times = |y: &[[f64; PARAMETERS]; 4]| {
            y.map(|row| row.iter().zip(THETA).map(|(y, x)| y * x).sum::<f64>())
        };
        for (name, found) in [("paper_Ya", &y_a), ("paper_Yb", &y_b)] {
            for (row, expected) in found.iter().zip(case[name].as_array().unwrap()) {
                assert_close(name, row, &numbers(expected));
            }
            let product = numbers(&case[format!("{name}_theta")]);
            assert_close("times theta", &times(found), &product);
        }
        check_against_bodies(&state, case);
    }
}

/// Pinocchio's torque for the bodies that the first three parameters describe.
fn check_against_bodies(state: &JointState, case: &Value) {
    let accelerations = pair(&case["qdd"]);
    let mut free = THETA;
    // The motor is cut off: only links are left.
    free[5..].fill(0.0);
    let arm = PlanarArm {
        coulomb_sharpness: [100.0, 100.0],
    };
    let mass = PlanarArm::mass_matrix(&THETA, &state.q);
    let without = arm.acceleration(&free, state, &[0.0; 2]).ddq;
    let torque: Vec<f64> = mass
        .iter()
        .map(|row| {
            (0..2)
                .map(|j| row[j] * (accelerations[j] - without[j]))
                .sum()
        })
        .collect();
    assert_close("inverse dynamics", &torque, &numbers(&case["pin_tau"]));
    let momentum: Vec<f64> = mass
        .iter()
        .map(|row| row[0] * state.dq[0] + row[1] * state.dq[1])
        .collect();
    assert_close("momentum", &momentum, &numbers(&case["pin_momentum"]));
}

#[test]
fn filters_are_those_of_numpy() {
    check_filters(&fixture(include_str!("fixtures/filters.json")));
}

#[test]
fn regressor_is_that_of_independent_code() {
    check_regressor(&fixture(include_str!("fixtures/planar_2r.json")));
}

#[test]
fn all_golden_vectors_agree() {
    if let Some(golden) = golden("filters.json") {
        check_filters(&golden);
    }
    if let Some(golden) = golden("planar2r.json") {
        check_regressor(&golden);
    }
}
