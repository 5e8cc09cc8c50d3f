//! What noise of the logged torque does to the gradient.
//!
//! The filter takes the logged torque for the one that acted, up to noise. Its
//! noise is in the innovations, and through the accelerations that it seems to cause
//! in their derivatives, too: the gradient is not zero at the true parameters, and
//! inertias come out too large by the variance of the noise over that of the torque
//! that accelerates. The expectation follows from the filter and is taken off.
//!
//! # Source
//!
//! The attenuation by errors in variables; Fuller, Measurement Error Models,
//! section 1.1.

use super::dynamics::Dynamics;
use super::levels::Levels;
use super::likelihood::LevelLikelihood;
use super::unknowns::Unknowns;
use super::vector::scale;

/// Returns the expected gradient of half the cost at the true parameters, \[values\].
///
/// Samples whose linearization is kept stand for all.
pub(super) fn expected_gradient(
    likelihood: &LevelLikelihood<'_>,
    dynamics: &mut Dynamics<'_>,
    unknowns: &Unknowns,
    levels: &Levels,
) -> Vec<f64> {
    let rows = dynamics.rows();
    let (moving, states) = (2 * rows, 3 * rows);
    let noisy: Vec<usize> = (0..rows)
        .filter(|&row| levels.torque_noise[row] > 0.0)
        .collect();
    let places = unknowns.places(0);
    let mut gradient = vec![0.0; unknowns.values()];
    if noisy.is_empty() {
        return gradient;
    }
    let linearization = &likelihood.run.linearization;
    let mut seen = 0;
    // What measurements say of the state behind a sample, as each noisy torque moves it.
    let mut told = vec![0.0; rows * moving];
    likelihood.information_ahead(levels, |sample, information| {
        seen += 1;
        let transition = &linearization.transitions[sample * moving * states..][..moving * states];
        let by_torque = |row: usize| transition[moving + row..].iter().step_by(states);
        for &row in &noisy {
            let own = told[row * moving..].iter_mut();
            for (told, own) in own.zip(information.chunks(states).take(moving)) {
                let both = own.iter().zip(by_torque(row)).map(|(n, b)| n * b);
                *told = levels.torque_noise[row].powi(2) * both.sum::<f64>();
            }
        }
        let positions = &linearization.positions[sample * rows..(sample + 1) * rows];
        dynamics.visit_acceleration_torques(positions, &noisy, |pushed, row, column, torque| {
            if let Some(place) = places[column] {
                let own = told[pushed * moving..].iter().zip(by_torque(row));
                gradient[place] -= torque * own.map(|(n, b)| n * b).sum::<f64>();
            }
        });
    });
    let all = likelihood.measurements.samples() as f64 / f64::max(f64::from(seen), 1.0);
    scale(&mut gradient, all);
    gradient
}
