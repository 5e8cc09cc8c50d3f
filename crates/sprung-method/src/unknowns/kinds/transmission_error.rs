//! An error of a gear that repeats with the angle of its motor: the spring is deflected by it, too.

use super::catalogued::Catalogued;
use super::waves::{of_motors, times};
use super::words::{falls, or_else};
use crate::finding::{Finding, Severity};
use crate::numbers::in_ms;
use crate::unknowns::found::Telling;
use crate::unknowns::unknown::{Effect, Kind, LawColumn, OfMotor, Place, ShownBy, Unknown};

/// Periods per turn of the motor: that of the shaft, and that of a strain wave gear.
const PERIODS: [u8; 2] = [1, 2];

/// Usual amplitude, in root mean squares of the deflection.
const USUAL_DEFLECTIONS: f64 = 0.2;

pub(super) fn list(of: &Catalogued<'_>) -> Vec<Unknown> {
    of_motors(of, ("transmission error", &PERIODS), |joint, id, wave| {
        let is_flexible = of.experiment.robot.joint[joint].is_flexible();
        let column = OfMotor::new(move |sample| wave.mean(sample));
        let effect = Effect::Law {
            column: LawColumn::Gear(column),
            added: None,
        };
        Some(Unknown {
            scale: USUAL_DEFLECTIONS * of.deflection_of(joint)?,
            shown_by: ShownBy::Innovations,
            ..Unknown::new(
                id,
                Kind::TransmissionError,
                Place::Joint(joint),
                "rad",
                effect,
            )
        })
        .filter(|_| is_flexible)
    })
}

/// Finding: a gear has an error.
pub(super) fn finding(of: &Telling<'_>) -> Finding {
    Finding::new(
        Severity::Warning,
        "transmission-error",
        format!(
            "{}: the gear has a transmission error of {:.4} ± {:.4} mrad, {}: {}{}",
            of.joint,
            in_ms(of.found.value),
            in_ms(of.found.standard_error),
            times(&of.found.id),
            falls(of),
            or_else(of)
        ),
        "nothing in the log; measure the error of the gear at rest, and correct the motor positions by it",
    )
    .seen(of.file, of.columns.first().copied().unwrap_or_default(), of.found.value, "rad")
}
