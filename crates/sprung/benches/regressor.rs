//! One sample: its regressor, the filtered regressor, an acceleration.

use divan::{Bencher, black_box};
use sprung::description::DiscretizationName;
use sprung::regression::FilteredRegression;
use sprung_core::regressor::{JointState, PARAMETERS, PlanarArm};

const ARM: PlanarArm = PlanarArm {
    coulomb_sharpness: [100.0, 100.0],
};

const STATE: JointState = JointState {
    q: [0.1, -0.2],
    dq: [0.003, 0.4],
    phi: [0.15, -0.25],
    dphi: [-0.5, 0.006],
};

const THETA: [f64; PARAMETERS] = [
    0.207, 0.0176, 0.0132, 0.217, 0.00684, 0.0377, 0.00296, 8.44, 0.136, 9.36, 4.21, 0.0158,
    0.00502, 1.36, 0.163,
];

fn main() {
    divan::main();
}

#[divan::bench]
fn regressor_of_a_sample(bencher: Bencher) {
    bencher.bench_local(|| ARM.regressor(black_box(&STATE)));
}

#[divan::bench]
fn filtered_regressor_of_a_sample(bencher: Bencher) {
    let mut regression =
        FilteredRegression::new(&ARM, 30.0, 1e-3, DiscretizationName::Matched).expect("settings");
    bencher.bench_local(move || regression.process(0.0, black_box(&STATE), &[1.0, 2.0]));
}

#[divan::bench]
fn acceleration(bencher: Bencher) {
    bencher.bench_local(|| ARM.acceleration(&THETA, black_box(&STATE), &[1.0, 2.0]));
}
