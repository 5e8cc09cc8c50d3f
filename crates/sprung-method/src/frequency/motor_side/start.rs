//! Start values: the inertias of a rigid robot, divided in many ways.

use faer::Mat;
use faer::Side;
use faer::linalg::solvers::Solve;
use std::f64::consts::TAU;

use super::equations::Places;
use super::lines::{Lines, POWER_LINES, mean_power};

/// Antiresonances that are tried: the lowest, as a line, and the ratio of neighbours.
const LOWEST_LINE: usize = 3;
const RATIO: f64 = 1.5;

/// Parts of the inertia of a joint that its rotor may have.
const ROTOR_SHARES: [f64; 3] = [0.2, 0.5, 0.8];

/// Least inertia relative to the torque over the acceleration of a joint.
const LEAST_INERTIA: f64 = 1e-3;

/// Returns start values of the unknowns.
pub(super) fn starts(lines: &Lines, places: Places) -> Vec<Vec<f64>> {
    let n = lines.joints();
    let (inertia, damping) = rigid(lines);
    let mut starts = Vec::new();
    let mut hz = lines.hz[LOWEST_LINE.min(lines.hz.len() - 1)];
    while lines.hz.last().is_some_and(|last| hz < *last) {
        for share in ROTOR_SHARES {
            let mut x = vec![0.0; places.count()];
            for i in 0..n {
                let link = (1.0 - share) * inertia[i];
                x[Places::inertia(i, i)] = link;
                x[places.rotor(i)] = (share * inertia[i]).ln();
                x[places.stiffness(i)] = ((TAU * hz).powi(2) * link).ln();
                x[places.motor_damping(i)] = damping[i];
            }
            starts.push(x);
        }
        hz *= RATIO;
    }
    starts
}

/// Returns inertia and viscous friction of each joint of a rigid robot whose joints do not act on each
/// other, by least squares of the torques over their sizes.
fn rigid(lines: &Lines) -> (Vec<f64>, Vec<f64>) {
    (0..lines.joints())
        .map(|joint| {
            let (motor, torque) = (&lines.motor[joint], &lines.torque[joint]);
            let (mut normal, mut right) = (Mat::<f64>::zeros(2, 2), Mat::<f64>::zeros(2, 1));
            let (mut acceleration, mut size) = (0.0, 0.0);
            for (line, s) in lines.s.iter().enumerate() {
                let weight = mean_power(torque, line, POWER_LINES)
                    .max(f64::MIN_POSITIVE)
                    .recip();
                let row = [s * s * motor[line], s * motor[line]];
                for i in 0..2 {
                    for j in 0..2 {
                        normal[(i, j)] += weight * (row[i].conj() * row[j]).re;
                    }
                    right[(i, 0)] += weight * (row[i].conj() * torque[line]).re;
                }
                acceleration += weight * row[0].norm_sqr();
                size += weight * torque[line].norm_sqr();
            }
            let scale = (size / acceleration).sqrt();
            let found = normal
                .llt(Side::Lower)
                .ok()
                .map(|factor| factor.solve(&right));
            let found = found.map_or((scale, 0.0), |solution| {
                (solution[(0, 0)], solution[(1, 0)])
            });
            (found.0.abs().max(LEAST_INERTIA * scale), found.1.max(0.0))
        })
        .unzip()
}
