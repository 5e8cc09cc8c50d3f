//! Numbers from independent code: NumPy for the filters, Pinocchio and the
//! corrected matrices of the paper for the regressor.
//!
//! Some of the vectors are in `fixtures/`. The full sets are read from a folder beside the checkout.
#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test may panic, and prints what it measured"
)]

#[path = "planar_2r/mod.rs"]
mod planar_2r;
#[path = "planar_2r/rows.rs"]
mod rows;

use planar_2r::{ENTRIES, JOINTS, PARAMETERS, bodies, robot};
use rows::ROW_COLUMNS;
use serde_json::Value;
use sprung_core::drives::State;
use sprung_core::filter::{Discretization, FilterPair, FilterState};
use sprung_core::friction::Shape;
use sprung_core::links::{JointScratch, PairScratch, Step, Workspace, numbers_len};
use sprung_core::robot::{Robot, Values};

/// Largest error relative to the largest number of the same kind: rounding of double precision.
const TOLERANCE: f64 = 1e-12;

/// Parameters of the golden products.
const THETA: [f64; PARAMETERS] = [
    0.207_184, 0.017_58, 0.013_163, 0.216_776, 0.006_842, 0.037_675, 0.002_959, 8.435_283,
    0.135_564, 9.358_73, 4.212_811, 0.015_771, 0.005_018, 1.360_21, 0.162_529,
];

fn fixture(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// A file of the full sets, or `None` and a report that the test is skipped.
fn golden(name: &str) -> Option<Value> {
    let path = sprung_testing::golden(name)?;
    Some(fixture(&std::fs::read_to_string(path).unwrap()))
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
        .map(|error| if error.is_nan() { f64::INFINITY } else { error })
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

const SHAPES: [Shape; JOINTS] = [Shape {
    sharpness: 100.0,
    stribeck_velocity: 0.1,
    presliding_width: 0.5,
    hysteresis_width: 0.05,
    play: 0.0,
    play_centre: 0.0,
}; JOINTS];

fn check_regressor(golden: &Value) {
    let arm = robot(&SHAPES);
    for case in golden["cases"].as_array().unwrap() {
        let [q, dq, phi, dphi] = ["q", "qd", "phi", "phid"].map(|key| pair(&case[key]));
        let state = State {
            q: &q,
            dq: &dq,
            phi: &phi,
            dphi: &dphi,
            excess: &[],
            elements: &[],
        };
        with_workspace(|workspace| {
            let [mut momentum, mut rest] = [[f64::NAN; ENTRIES]; 2];
            arm.regressor(&state, workspace, &mut momentum, &mut rest)
                .unwrap();
            check_matrix(case, "paper_Ya", &momentum);
            check_matrix(case, "paper_Yb", &rest);
            check_against_bodies(&arm, &state, workspace, case);
        });
    }
}

fn with_workspace(step: impl FnOnce(&mut Workspace<'_>)) {
    step(&mut Workspace {
        joints: &mut [JointScratch::default(); JOINTS],
        steps: &mut [Step::default(); JOINTS],
        pairs: &mut [PairScratch::default(); JOINTS * JOINTS],
        numbers: &mut [f64::NAN; numbers_len(JOINTS)],
    });
}

/// Compares a matrix and its product with the parameters.
fn check_matrix(case: &Value, name: &str, entries: &[f64; ENTRIES]) {
    let mut next = entries.iter();
    let mut products = Vec::new();
    for (columns, expected) in ROW_COLUMNS.iter().zip(case[name].as_array().unwrap()) {
        let mut row = [0.0; PARAMETERS];
        for (&column, entry) in columns.iter().zip(&mut next) {
            row[column] = *entry;
        }
        assert_close(name, &row, &numbers(expected));
        products.push(times(&row, &THETA));
    }
    let expected = numbers(&case[format!("{name}_theta")]);
    assert_close("times theta", &products, &expected);
}

fn times(row: &[f64], values: &[f64]) -> f64 {
    row.iter().zip(values).map(|(y, x)| y * x).sum()
}

/// Compares with torque and momentum of Pinocchio for bodies that have the first three parameters.
fn check_against_bodies(
    arm: &Robot<'_>,
    state: &State<'_>,
    workspace: &mut Workspace<'_>,
    case: &Value,
) {
    let values = Values {
        theta: &THETA,
        bodies: &bodies(&THETA),
    };
    let mut torque = [f64::NAN; JOINTS];
    let ddq = pair(&case["qdd"]);
    let steps = &mut [Step::default(); JOINTS];
    arm.link_torque(&values, state.q, state.dq, &ddq, steps, &mut torque)
        .unwrap();
    assert_close("inverse dynamics", &torque, &numbers(&case["pin_tau"]));
    let mut mass = [f64::NAN; 4 * JOINTS * JOINTS];
    arm.mass_matrix(&values, state.q, workspace, &mut mass)
        .unwrap();
    let of_links = mass.chunks(2 * JOINTS).take(JOINTS);
    let momentum: Vec<f64> = of_links.map(|row| times(row, state.dq)).collect();
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
fn filters_are_those_of_numpy_on_the_full_set() {
    let Some(golden) = golden("filters.json") else {
        return;
    };
    check_filters(&golden);
}

#[test]
fn regressor_is_that_of_independent_code_on_the_full_set() {
    let Some(golden) = golden("planar2r.json") else {
        return;
    };
    check_regressor(&golden);
}
