//! The tail of the chi-square distribution.

/// Returns the probability that a chi-square variable with `freedom` degrees of freedom exceeds
/// `x`; 1 if `freedom` is zero.
///
/// # Source
///
/// Abramowitz and Stegun, eqs. 26.4.4 and 26.4.5: finite sums, exact.
#[must_use]
pub(crate) fn upper_tail(x: f64, freedom: usize) -> f64 {
    if freedom == 0 || x <= 0.0 {
        return 1.0;
    }
    let half = x / 2.0;
    // Terms half^a e^(-half) / Γ(a + 1), where a rises by one from 0 or from 1/2.
    let (mut tail, mut term, first) = if freedom.is_multiple_of(2) {
        ((-half).exp(), (-half).exp(), 1.0)
    } else {
        let zero = (-half).exp() / (std::f64::consts::PI * half).sqrt();
        (libm::erfc(half.sqrt()), zero, 0.5)
    };
    for step in 0..(freedom - 1) / 2 {
        term *= half / (first + step as f64);
        tail += term;
    }
    tail.min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_the_tables() {
        // Abramowitz and Stegun, table 26.8.
        for (freedom, x, probability) in [
            (1, 3.841_46, 0.05),
            (1, 10.827_6, 0.001),
            (2, 5.991_47, 0.05),
            (3, 11.344_9, 0.01),
            (4, 13.276_7, 0.01),
            (9, 21.666_0, 0.01),
            (10, 18.307_0, 0.05),
            (30, 59.703, 0.001),
        ] {
            let found = upper_tail(x, freedom);
            // Half of the last digit of 59.703, times the largest rate at which a tail falls, 1/2.
            assert!(
                (found / probability - 1.0).abs() < 0.5 * 0.5e-3,
                "{freedom}: {found}"
            );
        }
        assert!((upper_tail(0.0, 3) - 1.0).abs() < 1e-15);
        assert!((upper_tail(5.0, 0) - 1.0).abs() < 1e-15);
    }
}
