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

#[cfg(test)]
mod tests {
    use super::Shown;

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
