//! Largest differences between correct estimates and the truth that chance explains.

/// Probability with which a correct result may exceed a limit of this module.
pub const FALSE_ALARM: f64 = 1e-4;

/// Returns the absolute value that none of `count` standard normal variables exceeds, but for a probability of
/// [`FALSE_ALARM`] (Bonferroni: each has its share of it, so the variables may depend on each other).
#[must_use]
pub fn largest_of_normals(count: usize) -> f64 {
    let share = FALSE_ALARM / count.max(1) as f64;
    let (mut low, mut high) = (3.0, 40.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if 2.0 * upper_tail(middle) > share {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

/// Returns the least number of `count` intervals that hold the truth, but for a probability of [`FALSE_ALARM`], if
/// each holds it with probability `share` and they are independent.
#[must_use]
pub fn least_inside(count: usize, share: f64) -> usize {
    let odds = (share / (1.0 - share)).ln();
    let mut logarithm = count as f64 * (1.0 - share).ln();
    let mut below = 0.0;
    for inside in 0..count {
        below += logarithm.exp();
        if below > FALSE_ALARM {
            return inside;
        }
        logarithm += ((count - inside) as f64 / (inside + 1) as f64).ln() + odds;
    }
    count
}

/// Returns the probability that a standard normal variable exceeds `z`, by Laplace's continued fraction.
///
/// - `z`: at least 3, where [`TERMS`] of the fraction reach the accuracy of the numbers.
fn upper_tail(z: f64) -> f64 {
    const TERMS: u32 = 60;
    let fraction = (1..=TERMS)
        .rev()
        .fold(z, |below, term| z + f64::from(term) / below);
    (-0.5 * z * z).exp() / (std::f64::consts::TAU.sqrt() * fraction)
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUANTILES: [(usize, f64); 4] = [
        (1, 3.890_591_886_413),
        (4, 4.214_799_669_993),
        (15, 4.504_062_242_311),
        (100, 4.891_638_475_699),
    ];

    const LEAST: [(usize, f64, usize); 6] = [
        (1, 0.95, 0),
        (10, 0.95, 6),
        (15, 0.95, 10),
        (16, 0.95, 11),
        (60, 0.95, 49),
        (1000, 0.95, 923),
    ];

    /// Quantiles of Python's `statistics.NormalDist`.
    #[test]
    fn quantiles_are_those_of_python() {
        for (count, expected) in QUANTILES {
            let found = largest_of_normals(count);
            assert!((found - expected).abs() < 1e-9, "{count}: {found}");
        }
    }

    /// Sums of Python's `math.comb`.
    #[test]
    fn least_numbers_are_those_of_python() {
        for (count, share, expected) in LEAST {
            assert_eq!(least_inside(count, share), expected, "{count}, {share}");
        }
    }
}
