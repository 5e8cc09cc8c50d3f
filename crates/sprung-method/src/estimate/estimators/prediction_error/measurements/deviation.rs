//! Standard deviation of a channel's values.

/// Returns the standard deviation of numbers.
pub(super) fn deviation(all: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = all.clone().count().max(1) as f64;
    let mean = all.clone().sum::<f64>() / count;
    (all.map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt()
}
