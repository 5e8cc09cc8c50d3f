//! Chooses the weights of the samples from the beginning of a log.

use super::excerpt::Excerpt;
use super::noise::velocity_noise;
use crate::fit::fit_values;
use crate::model::Model;
use crate::regression::{Reading, Reduction, System, TransitionWeights};

/// Number of successive estimates; each estimate gives the weights for the next estimate.
const WEIGHT_ITERATIONS: usize = 3;

/// Ratio of a normal variable's standard deviation to the median of its absolute value.
const MEDIAN_TO_DEVIATION: f64 = 1.4826;

/// Returns the weights for the beginning of a log; `None` if it is too short for the filters.
///
/// The Coulomb friction comes from the previous estimate; the first estimate has equal weights. The
/// scale of a row is that of its residual in the half of the samples with the least variance from
/// transitions.
#[must_use]
pub(crate) fn find_weights(reading: &Reading, excerpt: &Excerpt) -> Option<TransitionWeights> {
    let model = reading.model();
    let noise = velocity_noise(
        model,
        reading.channels(),
        excerpt,
        reading.position_cutoff_hz(),
    );
    let signals = excerpt.smoothed(reading)?.thinned(reading);
    let mut weights = TransitionWeights::unknown(model, &noise);
    for _ in 0..WEIGHT_ITERATIONS {
        let empty = Reduction::new(model);
        let system = signals.reduce_by(empty, &reading.with_weights(weights))?;
        let theta = fit_values(model, &system)?;
        let slip: Vec<f64> = (0..model.rows())
            .map(|row| slip_scale(model, &system, &theta, row))
            .collect();
        weights = TransitionWeights::new(model, &noise, &theta, &slip);
    }
    Some(weights)
}

/// Returns the scale of a row's residual in sliding, N·m (N).
fn slip_scale(model: &Model, system: &System, theta: &[f64], row: usize) -> f64 {
    let kept = system.kept();
    let columns = model.row_columns(row);
    let mut samples: Vec<(f64, f64)> = (kept.rows[row].iter().zip(&kept.variance[row]))
        .map(|(sample, variance)| {
            let fitted: f64 = (columns.iter().zip(sample))
                .map(|(&column, entry)| theta[column] * entry)
                .sum();
            let measured = sample.last().copied().unwrap_or_default();
            (*variance, (fitted - measured).abs())
        })
        .collect();
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut slipping: Vec<f64> = samples[..samples.len().div_ceil(2)]
        .iter()
        .map(|(_, residual)| *residual)
        .collect();
    slipping.sort_by(f64::total_cmp);
    let median = slipping.get(slipping.len() / 2).copied().unwrap_or(0.0);
    MEDIAN_TO_DEVIATION * median
}
