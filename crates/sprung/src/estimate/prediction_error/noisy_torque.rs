//! Bias of the gradient by noise of the logged torque.
//!
//! The filter takes the logged torque for the acting torque up to noise. This noise enters the
//! innovations and, through the accelerations and velocities that it seems to cause, their
//! derivatives. So the gradient is not zero at the true parameters. Without a correction inertias
//! come out too large, by the ratio of the noise's variance to the variance of the torque that
//! accelerates. Coulomb friction of a light rotor is biased in its transition, where the velocity
//! follows the noise within a sampling period. The filter's information gives the expectation of
//! this gradient; it is subtracted. White noise of a link and noise while friction reverses are
//! torques that act, so they cause no such bias.
//!
//! # Source
//!
//! The attenuation by errors in variables; Fuller, Measurement Error Models, section 1.1.

use super::dynamics::{Dynamics, Pulse};
use super::levels::Levels;
use super::likelihood::LevelLikelihood;
use super::unknowns::Unknowns;
use super::vector::scale;

/// Returns the expected gradient of half the cost at the true parameters, \[values\].
///
/// - `logged_noise`: noise of the logged torque, N·m (N), \[rows\]; zero where there is none.
///
/// It is summed over the samples with a linearization and scaled to all samples.
pub(super) fn expected_gradient(
    likelihood: &LevelLikelihood<'_>,
    dynamics: &mut Dynamics,
    unknowns: &Unknowns,
    logged_noise: &[f64],
    levels: &Levels,
) -> Vec<f64> {
    let rows = dynamics.rows();
    let (moving, states) = (2 * rows, 3 * rows);
    let noisy: Vec<usize> = (0..rows).filter(|&row| logged_noise[row] > 0.0).collect();
    let places = unknowns.places(0);
    let mut gradient = vec![0.0; unknowns.values()];
    if noisy.is_empty() {
        return gradient;
    }
    let linearization = &likelihood.run.linearization;
    let mut samples = 0;
    // σ_w² N_k F_τ of each noisy torque, \[rows × 2 rows\].
    let mut weighted = vec![0.0; rows * moving];
    likelihood.information_ahead(levels, |sample, information| {
        samples += 1;
        let transition = &linearization.transitions[sample * moving * states..][..moving * states];
        let by_torque = |row: usize| transition[moving + row..].iter().step_by(states);
        for &row in &noisy {
            let own = weighted[row * moving..].iter_mut();
            for (weighted, own) in own.zip(information.chunks(states).take(moving)) {
                let both = own.iter().zip(by_torque(row)).map(|(n, b)| n * b);
                *weighted = logged_noise[row].powi(2) * both.sum::<f64>();
            }
        }
        let pulse = Pulse {
            state: &linearization.middles[sample * moving..(sample + 1) * moving],
            transition,
            period: linearization.periods[sample],
        };
        dynamics.visit_pulse_torques(pulse, &noisy, |pushed, row, column, torque| {
            if let Some(place) = places[column] {
                let own = weighted[pushed * moving..].iter().zip(by_torque(row));
                gradient[place] -= torque * own.map(|(n, b)| n * b).sum::<f64>();
            }
        });
    });
    let all = likelihood.measurements.samples() as f64 / f64::max(f64::from(samples), 1.0);
    scale(&mut gradient, all);
    gradient
}
