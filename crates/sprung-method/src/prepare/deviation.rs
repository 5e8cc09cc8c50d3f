//! Standard deviation of values.

/// Returns the standard deviation of values about their mean; zero without values.
///
/// # Source
///
/// Welford's recursion.
pub(crate) fn deviation(values: impl Iterator<Item = f64>) -> f64 {
    let (mut n, mut mean, mut squares) = (0.0, 0.0, 0.0);
    for value in values {
        n += 1.0;
        let from = value - mean;
        mean += from / n;
        squares += from * (value - mean);
    }
    (squares / f64::max(n, 1.0)).sqrt()
}
