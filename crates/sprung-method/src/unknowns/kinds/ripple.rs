//! A torque of the motor that repeats with its angle, by its poles and slots or by the teeth of its gear.

use super::catalogued::Catalogued;
use super::waves::{of_motors, times};
use super::words::{falls, or_else};
use crate::finding::{Finding, Severity};
use crate::unknowns::found::Telling;
use crate::unknowns::unknown::{Effect, Kind, LawColumn, OfMotor, Place, ShownBy, Unknown};

/// Periods per turn of the motor.
const PERIODS: [u8; 5] = [1, 2, 4, 6, 12];

/// Usual part of the torque, and the part below which it matters to nobody.
const USUAL: f64 = 0.05;
const LEAST: f64 = 0.01;

pub(super) fn list(of: &Catalogued<'_>) -> Vec<Unknown> {
    of_motors(of, ("torque ripple", &PERIODS), |joint, id, wave| {
        let column = OfMotor::new(move |sample| -sample.scales.torque * wave.mean(sample));
        let effect = Effect::Law {
            column: LawColumn::Motor(column),
            added: None,
        };
        Some(Unknown {
            scale: USUAL,
            least: LEAST,
            shown_by: ShownBy::Innovations,
            ..Unknown::new(id, Kind::Ripple, Place::Joint(joint), "", effect)
        })
    })
}

/// Finding: the torque of a motor has a ripple.
pub(super) fn finding(of: &Telling<'_>) -> Finding {
    Finding::new(
        Severity::Warning,
        "torque-ripple",
        format!(
            "{}: the motor torque has a ripple of {:.2} ± {:.2} % of its standard deviation, {}: {}{}",
            of.joint,
            100.0 * of.found.value,
            100.0 * of.found.standard_error,
            times(&of.found.id),
            falls(of),
            or_else(of)
        ),
        "nothing in the log; compensate the ripple in the drive, or move faster, so that the spring does not follow it",
    )
    .seen(of.file, of.columns.first().copied().unwrap_or_default(), of.found.value, "")
}
