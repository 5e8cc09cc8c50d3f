//! The lines of the experiment file that correct the ratio of two encoders of one joint.

use crate::columns::channel::Channel;
use crate::numbers::Shown;

/// A slope that differs from the given gear ratio by less than this fraction is the gear ratio.
const SAME_RATIO: f64 = 0.1;

/// Corrections of a motor position that moves too far compared with the link position.
pub struct SlopeRemedy {
    /// Table of the experiment file.
    pub table: &'static str,
    /// Line that corrects the ratio.
    pub line: String,
    /// Remedy, with the alternatives to the line.
    pub words: String,
}

/// Returns the corrections if the motor position moves `slope` rad for each rad of the link position.
#[must_use]
pub fn slope_remedy(motor: &Channel, link: &Channel, slope: f64) -> SlopeRemedy {
    let slope = slope.abs();
    let mut others = Vec::new();
    if let Some(counts) = motor.counts_per_turn {
        others.push(format!(
            "counts_per_turn = {} of \"{}\"",
            rounded(counts * slope),
            motor.column
        ));
    }
    if let Some(counts) = link.counts_per_turn {
        others.push(format!(
            "counts_per_turn = {} of \"{}\"",
            rounded(counts / slope),
            link.column
        ));
    }
    let given = motor.gear_ratio;
    let is_given = given.is_some_and(|ratio| (slope / ratio.abs() - 1.0).abs() < SAME_RATIO);
    let (table, line, first) = if motor.before_gear {
        let ratio = given.unwrap_or(1.0);
        let line = format!("gear_ratio = {}", rounded(ratio * slope));
        let first = format!("set {line} instead of {ratio} if the gear ratio is wrong");
        ("[[robot.joint]]", line, first)
    } else if is_given {
        let line = "motor_position_side = \"motor\"".to_owned();
        let first = format!("set {line} in [log], because the factor is the gear ratio");
        ("[log]", line, first)
    } else {
        let line = format!(
            "gear_ratio = {}\n[log] motor_position_side = \"motor\"",
            rounded(slope)
        );
        let first = format!(
            "set gear_ratio = {} and motor_position_side = \"motor\" if \"{}\" was recorded before \
             the gearbox",
            rounded(slope),
            motor.column
        );
        ("[[robot.joint]]", line, first)
    };
    let words = if others.is_empty() {
        format!("{first}; check the unit and the side of each encoder")
    } else {
        format!(
            "{first}, or {} if the counts of an encoder are wrong; check the unit and the side of each \
             encoder",
            others.join(", or ")
        )
    };
    SlopeRemedy { table, line, words }
}

/// Larger numbers are written with an exponent.
const LARGEST_PLAIN: f64 = 1e15;

/// Formats a positive number with four significant digits, without trailing zeros.
#[must_use]
pub fn rounded(value: f64) -> String {
    if !(value.is_finite() && value > 0.0 && value < LARGEST_PLAIN) {
        return Shown(value).to_string();
    }
    let decimals = 3 - value.log10().floor() as i32;
    if decimals <= 0 {
        let unit = 10_f64.powi(-decimals);
        return format!("{:.0}", (value / unit).round() * unit);
    }
    let text = format!("{value:.0$}", decimals as usize);
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::rounded;

    #[test]
    fn four_digits_are_kept() {
        for (value, text) in [
            (100.674, "100.7"),
            (51.0, "51"),
            (0.012_345, "0.01235"),
            (16_777_216.0, "16780000"),
            (1.0, "1"),
        ] {
            assert_eq!(rounded(value), text);
        }
    }
}
