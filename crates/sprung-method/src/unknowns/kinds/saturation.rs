//! A torque that acts less, or more, than the logged one the larger it is.

use super::catalogued::Catalogued;
use super::words::{falls, or_else};
use crate::finding::{Finding, Severity};
use crate::unknowns::found::Telling;
use crate::unknowns::unknown::{
    Effect, Kind, LawColumn, MotorSample, OfMotor, Place, ShownBy, Unknown,
};

/// Usual part of the torque that is missing at its root mean square. A part of a quarter is no saturation: the friction of a joint
/// that moves little but its friction has this effect.
const USUAL: f64 = 0.02;

/// Part of the torque at its root mean square below which it matters to nobody; laws of friction resemble it.
const LEAST: f64 = 0.01;

fn missing(sample: &MotorSample<'_>) -> f64 {
    sample.torque.powi(3) / sample.scales.torque.powi(2)
}

pub(super) fn list(of: &Catalogued<'_>) -> Vec<Unknown> {
    (of.names.iter().enumerate())
        .map(|(joint, name)| Unknown {
            scale: USUAL,
            least: LEAST,
            shown_by: ShownBy::Both,
            ..Unknown::new(
                format!("saturation {name}"),
                Kind::Saturation,
                Place::Joint(joint),
                "",
                Effect::Law {
                    column: LawColumn::Motor(OfMotor::new(missing)),
                    added: None,
                },
            )
        })
        .collect()
}

/// Finding: the acting torque grows less or more than the logged one.
pub(super) fn finding(of: &Telling<'_>) -> Finding {
    let column = of.columns.first().copied().unwrap_or_default();
    let percent = 100.0 * of.found.value;
    Finding::new(
        Severity::Warning,
        "torque-saturates",
        format!(
            "{}: the acting torque grows {} than \"{column}\", or the spring is not linear: at the root mean square of the torque the \
             difference is {:.2} % (standard error {:.2} %), and it grows with the third power of the torque. With it {}{}. \
             Larger torques are predicted worse than promised",
            of.joint,
            if percent > 0.0 { "less" } else { "more" },
            percent.abs(),
            100.0 * of.found.standard_error,
            falls(of),
            or_else(of)
        ),
        "measure the torque constant at several currents, try spring = [\"linear\", \"cubic\"], or record a motion with smaller \
         torques; the intervals of estimator = \"prediction-error\" contain the effect",
    )
    .seen(of.file, column, of.found.value, "")
}
