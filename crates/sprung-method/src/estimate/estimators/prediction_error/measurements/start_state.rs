//! Positions and velocities of the rows at the start of a segment.

use faer::Mat;
use faer::linalg::solvers::SolveLstsq;

use super::sensor::Sensor;

/// Standard deviation of the smoothed velocity at the start of a segment: constant part, rad/s, and part relative to
/// the velocity. Half the value moves an estimate by 0.06 standard errors, twice the value by 0.03.
const START_VELOCITY_DEVIATION: f64 = 0.05;

/// The same relative to the velocity of the joint. Half the value moves an estimate by 0.07 standard errors, twice the
/// value by 0.03.
const START_VELOCITY_RELATIVE_DEVIATION: f64 = 0.2;

/// Standard deviation of a deflection by a torque sensor, whose offset and stiffness are not exact,
/// relative to the deviation of the readings.
const START_SPRING_SHARE: f64 = 0.1;

/// Returns whether no encoder measures the link of a torque sensor.
fn is_alone(spring: &Sensor, sensors: &[Sensor]) -> bool {
    let link = spring
        .coordinates
        .first()
        .map(|(coordinate, _)| *coordinate);
    let sees =
        |s: &&Sensor| s.spring.is_none() && s.coordinates.iter().any(|(c, _)| Some(*c) == link);
    !sensors.iter().any(|s| sees(&s))
}

/// Returns positions and velocities of the rows at the first sample, and their standard deviations.
///
/// - `begins`: position and velocity of each sensor at the first sample.
pub(super) fn start_state(
    rows: usize,
    sensors: &[Sensor],
    begins: &[(f64, f64)],
) -> Option<(Vec<f64>, Vec<f64>)> {
    // A torque sensor places a link without encoder; its offset may exceed the noise of encoders.
    let needed: Vec<usize> = (0..sensors.len())
        .filter(|&i| sensors[i].spring.is_none() || is_alone(&sensors[i], sensors))
        .collect();
    // Each coordinate is measured directly, or in a sum with coordinates that are.
    let count = needed.len();
    if count < rows {
        return None;
    }
    let matrix = Mat::from_fn(count, rows, |i, j| {
        let coordinates = &mut sensors[needed[i]].coordinates.iter();
        let coordinate = coordinates.find(|(coordinate, _)| *coordinate == j);
        coordinate.map_or(0.0, |(_, weight)| *weight)
    });
    let both = Mat::from_fn(count, 2, |i, j| {
        let begin = begins[needed[i]];
        if j == 0 { begin.0 } else { begin.1 }
    });
    let solved = matrix.qr().solve_lstsq(both);
    let mut start = Vec::new();
    let mut deviation = Vec::new();
    for row in 0..rows {
        start.push(solved[(row, 0)]);
        let sees = |s: &&Sensor| s.coordinates.iter().any(|(c, _)| *c == row);
        let variance: f64 = (needed.iter().map(|&i| &sensors[i]).filter(sees))
            .map(|s| match s.spring {
                Some(_) => s.noise.variance() + (START_SPRING_SHARE * s.scale).powi(2),
                None => s.noise.variance(),
            })
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
