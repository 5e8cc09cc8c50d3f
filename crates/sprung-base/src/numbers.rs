//! Numbers in messages.

use std::fmt;

/// A number as the user may have written it: exact, and with an exponent if it is very large or small.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown(pub f64);

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Unlike `Display`, `Debug` writes 1e300 with an exponent instead of 301 digits.
        let text = format!("{:?}", self.0);
        f.write_str(text.strip_suffix(".0").unwrap_or(&text))
    }
}

/// Returns a value and its standard error with two digits of the error, so that neither is written as zero.
#[must_use]
pub fn with_error(value: f64, error: f64) -> [String; 2] {
    let decimals = 1.0 - error.abs().log10().floor();
    if !(0.0..=12.0).contains(&decimals) {
        return [value, error].map(|number| format!("{number:.1e}"));
    }
    let decimals = decimals as usize;
    [value, error].map(|number| format!("{number:.decimals$}"))
}

/// Returns a fraction in percent.
#[must_use]
pub fn in_percent(fraction: f64) -> f64 {
    100.0 * fraction
}

/// Returns seconds in milliseconds.
#[must_use]
pub fn in_ms(seconds: f64) -> f64 {
    1e3 * seconds
}

/// Returns a positive number rounded down to two digits, in groups of three digits: `1 200 000`. A bound stays a bound.
#[must_use]
pub fn rounded_down(value: f64) -> String {
    const MOST_DIGITS: f64 = 1e15;
    if !(1.0..MOST_DIGITS).contains(&value) {
        return format!("{value:.1e}");
    }
    let unit = 10f64.powf(value.log10().floor() - 1.0);
    // The quotient of an exact bound may be slightly below its digits.
    let rounded = unit * (value / unit * (1.0 + 1e-12)).floor();
    if unit < 1.0 {
        return Shown((10.0 * rounded).round() / 10.0).to_string();
    }
    let digits = format!("{rounded:.0}");
    let groups: Vec<&str> = (0..digits.len().div_ceil(3))
        .rev()
        .map(|group| {
            let end = digits.len() - 3 * group;
            &digits[end.saturating_sub(3)..end]
        })
        .collect();
    groups.join(" ")
}

#[cfg(test)]
mod tests {
    use super::{Shown, rounded_down, with_error};

    #[test]
    fn errors_have_two_digits_and_are_never_zero() {
        for (value, error, texts) in [
            (981.25, 6.1, ["981.2", "6.1"]),
            (0.000_123_4, 0.000_004_5, ["0.0001234", "0.0000045"]),
            (2.9, 1.113, ["2.9", "1.1"]),
            (1400.0, 123.0, ["1.4e3", "1.2e2"]),
            (1.0, 0.0, ["1.0e0", "0.0e0"]),
        ] {
            assert_eq!(with_error(value, error), texts);
        }
    }

    #[test]
    fn bounds_are_rounded_down_and_grouped() {
        for (value, text) in [
            (12_999.0, "12 000"),
            (1_250_000.0, "1 200 000"),
            (100_000.0, "100 000"),
            (987.0, "980"),
            (42.0, "42"),
            (4.29, "4.2"),
            (0.0123, "1.2e-2"),
        ] {
            assert_eq!(rounded_down(value), text);
        }
    }

    #[test]
    fn numbers_stay_short() {
        let text = |value: f64| Shown(value).to_string();
        assert_eq!(text(1e300), "1e300");
        assert_eq!(text(-2.5e-12), "-2.5e-12");
        assert_eq!(text(60.0), "60");
        assert_eq!(text(0.001), "0.001");
        assert_eq!(text(f64::INFINITY), "inf");
    }
}
