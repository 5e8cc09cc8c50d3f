//! One sample: its regressor, the filtered regressor, an acceleration; the link
//! columns of an arm with seven joints.

use divan::{Bencher, black_box};
use sprung::description::DiscretizationName;
use sprung::regression::FilteredRegression;
use sprung_core::chain::{Chain, ChainJoint, DhRow};
use sprung_core::links::{JointScratch, PairScratch, Workspace, regressor};
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

/// Kinematics of the Franka Panda.
fn panda() -> Vec<ChainJoint> {
    let half = std::f64::consts::FRAC_PI_2;
    let rows = [
        (0.0, 0.0, 0.333),
        (-half, 0.0, 0.0),
        (half, 0.0, 0.316),
        (half, 0.0825, 0.0),
        (-half, -0.0825, 0.384),
        (half, 0.0, 0.0),
        (half, 0.088, 0.0),
    ];
    (rows.iter().enumerate())
        .map(|(i, &(alpha, a, d))| {
            let row = DhRow {
                alpha,
                a,
                d,
                theta: 0.0,
            };
            ChainJoint::modified_dh(i.checked_sub(1), &row)
        })
        .collect()
}

#[divan::bench]
fn link_columns_of_seven_joints(bencher: Bencher) {
    let joints = panda();
    let chain = Chain::new(&joints, [0.0, 0.0, -9.81]).expect("a chain");
    let mut scratch = [JointScratch::default(); 7];
    let mut pairs = [PairScratch::default(); 49];
    let mut workspace = Workspace {
        joints: &mut scratch,
        pairs: &mut pairs,
    };
    let (q, dq) = ([0.3, -0.7, 0.2, -1.9, 0.5, 1.7, 0.8], [0.4; 7]);
    let (mut momentum, mut rest) = (vec![0.0; 490], vec![0.0; 490]);
    bencher.bench_local(move || {
        regressor(
            &chain,
            black_box(&q),
            &dq,
            &mut workspace,
            &mut momentum,
            &mut rest,
        )
    });
}
