//! Numbers as text for reports, with rounding.

/// Returns a number with `digits` significant digits, in plain notation from 1e-5 to 1e7 and in
/// scientific notation outside.
#[must_use]
pub fn significant(value: f64, digits: usize) -> String {
    let digits = digits.max(1);
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 {
            "0".to_owned()
        } else {
            value.to_string()
        };
    }
    // Rounding comes first, because it may change the exponent: 9.996 with 3 digits is 10.0.
    let scientific = format!("{value:.*e}", digits - 1);
    let exponent: i32 = scientific
        .split_once('e')
        .and_then(|(_, exponent)| exponent.parse().ok())
        .unwrap_or(0);
    if (-5..=6).contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        format!("{value:.decimals$}")
    } else {
        scientific
    }
}

/// Returns a rounded number without zeros at its end.
pub(super) fn short(value: f64, digits: usize) -> String {
    let rounded: f64 = (significant(value, digits).parse()).unwrap_or(value);
    rounded.to_string()
}

/// Returns a text, or a dash if there is none.
pub(super) fn dash_if_none(text: Option<String>) -> String {
    text.unwrap_or_else(|| "–".to_owned())
}

/// Returns a rounded value, or a dash if there is no value.
pub(super) fn or_dash(value: Option<f64>, digits: usize) -> String {
    dash_if_none(value.map(|value| significant(value, digits)))
}

/// Returns a rounded value with its standard error.
pub(super) fn with_error(value: f64, digits: usize, error: f64) -> String {
    format!("{} ± {}", significant(value, digits), significant(error, 2))
}

/// Returns a share in percent.
pub(super) fn percent(share: f64, digits: usize) -> String {
    format!("{} %", significant(100.0 * share, digits))
}

/// Returns a share in percent with one decimal and without unit, or a dash.
pub(super) fn percent_or_dash(share: Option<f64>) -> String {
    dash_if_none(share.map(|share| format!("{:.1}", 100.0 * share)))
}

/// Returns a rounded value, or a dash if there is no finite value.
pub(super) fn finite_or_dash(value: Option<f64>, digits: usize) -> String {
    or_dash(value.filter(|value| value.is_finite()), digits)
}

/// Returns a value exactly as given if it has at most 8 characters, otherwise rounded.
pub(super) fn given(value: Option<f64>) -> String {
    match value.map(|value| value.to_string()) {
        Some(text) if text.len() <= 8 => text,
        _ => or_dash(value, 5),
    }
}

/// Returns the deviation of `value` from `reference` in percent, with sign.
#[must_use]
pub(super) fn deviation(value: Option<f64>, reference: Option<f64>) -> String {
    match (value, reference) {
        (Some(value), Some(reference)) if reference != 0.0 => {
            let percent = 100.0 * (value / reference - 1.0);
            let decimals = usize::from(percent.abs() < 100.0);
            format!("{percent:+.decimals$}")
        }
        _ => dash_if_none(None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_significant_ones() {
        for (value, digits, expected) in [
            (0.0, 3, "0"),
            (9.996, 3, "10.0"),
            (-0.002_959_1, 4, "-0.002959"),
            (312_345.6, 4, "312346"),
            (1.5e-9, 2, "1.5e-9"),
            (f64::INFINITY, 3, "inf"),
        ] {
            assert_eq!(significant(value, digits), expected);
        }
    }
}
