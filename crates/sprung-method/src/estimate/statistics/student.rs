//! The tail of Student's t distribution.

/// Relative accuracy at which the continued fraction ends.
const ACCURACY: f64 = 1e-15;

/// Most terms of the continued fraction; it needs about the root of the degrees of freedom.
const MOST_TERMS: u32 = 10_000;

/// Least magnitude of a denominator in the continued fraction (Lentz's method as modified by Thompson
/// and Barnett).
const TINY: f64 = 1e-300;

/// Returns the probability that Student's t with `freedom` degrees of freedom lies farther from zero
/// than `t`; 1 if `freedom` is zero.
///
/// # Source
///
/// Abramowitz and Stegun, eqs. 26.5.27 and 26.5.8: the incomplete beta function and its continued
/// fraction.
#[must_use]
pub(crate) fn both_tails(t: f64, freedom: usize) -> f64 {
    if freedom == 0 {
        return 1.0;
    }
    let n = freedom as f64;
    let sum = t.mul_add(t, n);
    if !sum.is_finite() {
        return if t.is_nan() { 1.0 } else { 0.0 };
    }
    let (far, near) = (n / sum, t * t / sum);
    let (a, b) = (0.5 * n, 0.5);
    if near == 0.0 {
        return 1.0;
    }
    let scale = libm::lgamma(a + b) - libm::lgamma(a) - libm::lgamma(b);
    let front = (scale + a * far.ln() + b * near.ln()).exp();
    let tails = if far < (a + 1.0) / (a + b + 2.0) {
        front * continued_fraction(far, a, b) / a
    } else {
        1.0 - front * continued_fraction(near, b, a) / b
    };
    tails.clamp(0.0, 1.0)
}

/// Returns the continued fraction of the incomplete beta function.
fn continued_fraction(x: f64, a: f64, b: f64) -> f64 {
    let away = |value: f64| if value.abs() < TINY { TINY } else { value };
    let mut c = 1.0;
    let mut d = away(1.0 - (a + b) * x / (a + 1.0)).recip();
    let mut fraction = d;
    for m in 1..MOST_TERMS {
        let m = f64::from(m);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let mut last = 1.0;
        for term in [even, odd] {
            d = away(1.0 + term * d).recip();
            c = away(1.0 + term / c);
            last = c * d;
            fraction *= last;
        }
        if (last - 1.0).abs() < ACCURACY {
            break;
        }
    }
    fraction
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_the_tables() {
        // Abramowitz and Stegun, table 26.10: both tails.
        for (freedom, t, probability) in [
            (1, 1.0, 0.5),
            (1, 63.657, 0.01),
            (2, 4.303, 0.05),
            (2, 9.925, 0.01),
            (3, 5.841, 0.01),
            (8, 0.706, 0.5),
            (8, 2.306, 0.05),
            (8, 5.041, 0.001),
            (30, 3.646, 0.001),
            (120, 1.980, 0.05),
        ] {
            let found = both_tails(t, freedom);
            // The tables have four digits; the tail has up to four times their relative error.
            assert!(
                (found / probability - 1.0).abs() < 2e-3,
                "{freedom}: {found}"
            );
            assert!((both_tails(-t, freedom) - found).abs() < 1e-15);
        }
    }

    #[test]
    fn two_degrees_of_freedom_have_a_closed_form() {
        // 1 - t/√(2 + t²); for large t it is 1/t² to first order.
        for t in [1e-3_f64, 0.3, 2.0, 7.0] {
            let expected = 1.0 - t / (2.0 + t * t).sqrt();
            assert!((both_tails(t, 2) - expected).abs() < 1e-13, "{t}");
        }
        assert!((both_tails(1e6, 2) * 1e12 - 1.0).abs() < 1e-6);
    }

    #[test]
    fn values_without_a_distribution_are_no_evidence() {
        for (t, freedom, expected) in [
            (5.0, 0, 1.0_f64),
            (0.0, 8, 1.0),
            (f64::NAN, 8, 1.0),
            (f64::INFINITY, 8, 0.0),
        ] {
            let found = both_tails(t, freedom);
            assert_eq!(found.to_bits(), expected.to_bits(), "{t}, {freedom}");
        }
    }
}
