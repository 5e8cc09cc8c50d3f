//! Positions and velocities of the rows at the start of a segment.

use faer::Mat;
use faer::linalg::solvers::SolveLstsq;

use super::sensor::Sensor;

/// Standard deviation of the smoothed velocity at the start of a segment: constant part, rad/s, and
/// part relative to the velocity.
const START_VELOCITY_DEVIATION: f64 = 0.05;
const START_VELOCITY_RELATIVE_DEVIATION: f64 = 0.2;

/// Returns positions and velocities of the rows at the first sample, and their standard deviations.
///
/// - `begins`: position and velocity of each sensor at the first sample.
pub(super) fn start_state(
    rows: usize,
    sensors: &[Sensor],
    begins: &[(f64, f64)],
) -> Option<(Vec<f64>, Vec<f64>)> {
    // Each coordinate is measured directly, or in a sum with coordinates that are.
    let count = sensors.len();
    if count < rows {
        return None;
    }
    let matrix = Mat::from_fn(count, rows, |i, j| {
        let coordinates = &mut sensors[i].coordinates.iter();
        let own = coordinates.find(|(coordinate, _)| *coordinate == j);
        own.map_or(0.0, |(_, weight)| *weight)
    });
    let both = Mat::from_fn(
        count,
        2,
        |i, j| if j == 0 { begins[i].0 } else { begins[i].1 },
    );
    let solved = matrix.qr().solve_lstsq(both);
    let mut start = Vec::new();
    let mut deviation = Vec::new();
    for row in 0..rows {
        start.push(solved[(row, 0)]);
        let sees = |s: &&Sensor| s.coordinates.iter().any(|(c, _)| *c == row);
        let variance: f64 = (sensors.iter().filter(sees))
            .map(|s| s.noise.variance())
            .sum();
        deviation.push(variance.sqrt());
    }
    for row in 0..rows {
        let velocity = solved[(row, 1)];
        start.push(velocity);
        deviation
            .push(START_VELOCITY_DEVIATION + START_VELOCITY_RELATIVE_DEVIATION * velocity.abs());
    }
    start
        .iter()
        .all(|x| x.is_finite())
        .then_some((start, deviation))
}
