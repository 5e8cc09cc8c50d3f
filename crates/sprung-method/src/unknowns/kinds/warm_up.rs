//! Viscous friction of a motor that changes during the log, as it does when a gear warms up.

use super::catalogued::Catalogued;
use super::words::{falls, or_else};
use crate::finding::{Finding, Severity};
use crate::unknowns::found::Telling;
use crate::unknowns::unknown::{Effect, Kind, LawColumn, OfMotor, Place, ShownBy, Unknown};
use sprung_core::friction::Law;
use sprung_core::parameters::{JointParameter, Side};

/// Part of the joint's torque below which the change matters to nobody: half of it to each side of the mean are 1 %.
const LEAST: f64 = 0.006;

pub(super) fn list(of: &Catalogued<'_>) -> Vec<Unknown> {
    if of.experiment.robot.transmission_matrix.is_some() {
        return Vec::new();
    }
    let viscous = JointParameter::Friction(Side::Motor, Law::Viscous);
    (0..of.joints)
        .filter(|&joint| of.speeds[joint] > 0.0)
        .filter_map(|joint| Some((joint, of.model.index(viscous, joint)?)))
        .map(|(joint, index)| {
            let column = OfMotor::new(|sample| sample.velocity * (sample.share - 0.5));
            let id = format!("warm-up {}", of.names[joint]);
            let effect = Effect::Law {
                column: LawColumn::Motor(column),
                added: None,
            };
            Unknown {
                least: LEAST,
                shown_by: ShownBy::Innovations,
                ..Unknown::new(
                    id,
                    Kind::WarmUp,
                    Place::Joint(joint),
                    of.model.parameters()[index].unit,
                    effect,
                )
            }
        })
        .collect()
}

/// Finding: the friction changes during the log.
pub(super) fn finding(of: &Telling<'_>) -> Finding {
    let unit = of.found.unit;
    Finding::new(
        Severity::Warning,
        "friction-drifts",
        format!(
            "{}: the viscous friction of the motor changes by {:+.3} ± {:.3} {unit} from the beginning to the end of the logs, as it does \
             when a gear warms up: {}{}",
            of.joint,
            of.found.value,
            of.found.standard_error,
            falls(of),
            or_else(of)
        ),
        "run the robot warm before the log, or log the temperature and name it in [log] as a covariate",
    )
    .seen(of.file, of.columns.first().copied().unwrap_or_default(), of.found.value, unit)
}
