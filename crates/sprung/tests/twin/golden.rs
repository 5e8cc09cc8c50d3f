//! Numbers from independent code: SciPy for the zero-phase filter, NumPy for
//! the simulated loop and for least squares on it.
use serde_json::Value;
use sprung_method::preprocess::{Butterworth, ZeroPhase};
use sprung_robot::DiscretizationName;

use crate::support::{Twin, step};

/// Samples between two rows of the full file of the simulation.
const FULL_STRIDE: usize = 100;

/// Samples between two rows of the fixture.
const FIXTURE_STRIDE: usize = 1000;

/// A file of the full sets, or `None` and a report that the test is skipped.
fn golden(name: &str) -> Option<String> {
    let path = sprung_testing::golden(name)?;
    Some(std::fs::read_to_string(path).unwrap())
}

fn fixture(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().unwrap();
    list.iter().map(|x| x.as_f64().unwrap()).collect()
}

#[test]
fn zero_phase_filter_is_that_of_scipy() {
    let golden = fixture(include_str!("../fixtures/zero_phase.json"));
    let mut worst: f64 = 0.0;
    for case in golden["cases"].as_array().unwrap() {
        let count = |name: &str| usize::try_from(case[name].as_u64().unwrap()).unwrap();
        let number = |name: &str| case[name].as_f64().unwrap();
        let (order, cutoff) = (count("order"), number("cutoff_hz"));
        // The formula of zero_phase.py.
        let x: Vec<f64> = (0..count("samples"))
            .map(|k| {
                let t = 1e-3 * k as f64;
                0.4 + (7.0 * t).sin() + 0.2 * (200.0 * t).cos() + 0.01 * (k * k % 17) as f64
            })
            .collect();
        let rate = number("rate_hz");
        let filter = Butterworth::new(order, cutoff, 1.0 / rate).unwrap();
        // A section of order two amplifies the rounding of its states by this square, and roundings of random sign in
        // all samples and orders add up; four deviations for each of both programs.
        let amplified = (rate / (std::f64::consts::TAU * cutoff)).powi(2).max(1.0);
        let limit = 8.0 * f64::EPSILON * amplified * (x.len() as f64 * order as f64).sqrt();
        let mut zero_phase = ZeroPhase::new(filter);
        let mut y = Vec::new();
        for part in x.chunks(257) {
            zero_phase.push(part, &mut y);
        }
        assert!(zero_phase.finish(&mut y) && y.len() == x.len());
        let index = case["index"].as_array().unwrap();
        for (k, expected) in index.iter().zip(numbers(&case["value"])) {
            let k = usize::try_from(k.as_u64().unwrap()).unwrap();
            let error = (y[k] - expected).abs();
            assert!(
                error < limit,
                "order {order}, {cutoff} Hz, sample {k}: {error:e}"
            );
            worst = worst.max(error);
        }
    }
    println!("zero-phase filter: {worst:.1e}");
}

/// Compares the simulated loop with rows of time, state and torque.
fn check_simulation(rows: &[Vec<f64>], stride: usize) {
    let mut plant = Twin::new().closed_loop();
    let mut worst: f64 = 0.0;
    for row in rows {
        let (state, time) = (plant.state(), plant.time());
        let tau = step(&mut plant);
        let parts = [vec![time], state.q, state.phi, state.dq, state.dphi, tau];
        for (found, expected) in parts.concat().iter().zip(row) {
            worst = worst.max((found - expected).abs());
        }
        for _ in 1..stride {
            step(&mut plant);
        }
    }
    println!("simulation, {} rows: {worst:.1e}", rows.len());
    // The tolerance of the integrator.
    assert!(worst < 1e-7, "{worst:e}");
}

#[test]
fn noise_free_loop_is_that_of_independent_code() {
    let golden = fixture(include_str!("../fixtures/noise_free.json"));
    let rows: Vec<Vec<f64>> = (golden["rows"].as_array().unwrap().iter())
        .map(numbers)
        .collect();
    assert_eq!(rows.len(), 11);
    check_simulation(&rows, FIXTURE_STRIDE);
}

#[test]
fn noise_free_loop_is_that_of_independent_code_at_all_rows() {
    let Some(text) = golden("sim2r_paper_noisefree.csv") else {
        return;
    };
    let rows: Vec<Vec<f64>> = (text.lines())
        .filter(|line| !line.starts_with('#'))
        .map(|line| line.split(',').map(|x| x.parse().unwrap()).collect())
        .collect();
    assert_eq!(rows.len(), 101);
    check_simulation(&rows, FULL_STRIDE);
}

fn check_least_squares(expected: &[f64]) {
    let twin = Twin::new();
    // The default tolerance of the simulation changes parameters by 2e-6.
    let plant = twin.closed_loop().with_tolerance(1e-10);
    let theta = twin.fit_exact_states(plant, DiscretizationName::Matched);
    let worst = (theta.iter().zip(expected))
        .map(|(found, expected)| (found / expected - 1.0).abs())
        .fold(0.0, f64::max);
    println!("least squares: {worst:.1e}");
    // A tolerance of 1e-7 changes parameters by 2e-6 (above). The independent code has Runge-Kutta steps of 0.05 ms;
    // where friction reverses, in about 2 % of the samples, its rate is 2400/s.
    let by_tolerance = 2e-6 * 1e-10 / 1e-7;
    let by_steps = 0.02 * (2400.0_f64 * 0.05e-3).powi(4) / 120.0;
    assert!(worst < by_tolerance + by_steps, "{worst:e}");
}

#[test]
fn least_squares_on_exact_states_is_that_of_independent_code() {
    let embedded = fixture(include_str!("../fixtures/noise_free.json"));
    let expected = numbers(&embedded["least_squares_matched"]);
    check_least_squares(&expected);
}

#[test]
fn embedded_least_squares_are_those_of_the_full_set() {
    let Some(text) = golden("sim2r_ls.json") else {
        return;
    };
    let embedded = fixture(include_str!("../fixtures/noise_free.json"));
    let expected = numbers(&embedded["least_squares_matched"]);
    let full = numbers(&fixture(&text)["ls_tustin_rest_tauzoh"]);
    assert_eq!(full.len(), expected.len());
    let worst = (full.iter().zip(&expected))
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    // The fixture has 15 decimals.
    assert!(
        worst < 1e-15,
        "the fixture is not the full set's: {worst:e}"
    );
}
