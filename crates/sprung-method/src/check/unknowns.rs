//! Decides between unknowns of a log and other meanings of its columns.

use super::joints::{Tested, joints};
use crate::finding::Severity;
use crate::log::Signal;
use crate::prepare::{PrepareError, Prepared};
use crate::progress::Listener;
use crate::unknowns::{AboutUnknowns, Settled, settled};

/// Part of the torques that sizes of unknowns leave at most. Friction of real gears leaves 11 %, a wrong meaning of columns 17 % and
/// more.
const LEFT_BY_SIZES: f64 = 0.15;

/// Finds the unknowns of the first log and applies them, unless they leave much unexplained and the columns have another meaning.
///
/// # Errors
///
/// As of [`prepare`](crate::prepare::prepare), but for those of reading.
pub(crate) fn settled_or_other_meaning(
    prepared: Prepared,
    progress: &mut dyn Listener,
) -> Result<Settled, PrepareError> {
    let settled = settled(prepared.clone(), progress)?;
    let channels = prepared.reading().channels();
    let has_sensors =
        (0..channels.turns.len()).any(|joint| channels.telling(Signal::Spring, joint).is_some());
    let is_explained = are_torques_explained(&settled.about);
    let is_doubtful = !settled.unknowns.is_empty() && (!is_explained || has_sensors);
    let settled = if is_doubtful && has_other_meaning(&prepared, is_explained) {
        Settled::without(prepared)
    } else {
        settled
    };
    // A check names the unit of time first.
    if settled.prepared.wrong_time_unit().is_none() {
        settled.prepared.require_gains()?;
    }
    Ok(settled)
}

/// Returns whether sizes of unknowns explain a log.
pub(super) fn are_torques_explained(about: &AboutUnknowns) -> bool {
    about.unexplained.is_some_and(|left| left <= LEFT_BY_SIZES)
}

/// Returns whether the equations show another meaning of the columns, or another scale of a joint torque sensor, which the
/// search does not know.
///
/// - `is_explained`: whether the sizes of unknowns explain the log, so that only sensors count.
fn has_other_meaning(prepared: &Prepared, is_explained: bool) -> bool {
    let (reading, excerpt) = (prepared.examined(), prepared.excerpt());
    let is_moving = |joint: &usize| {
        (reading.channels().all.iter().enumerate())
            .filter(|(_, channel)| channel.joint == *joint && channel.quantity.is_position())
            .any(|(i, _)| {
                let mut values = excerpt.blocks().iter().flat_map(|block| &block.values[i]);
                let first = values.next();
                values.any(|value| Some(value) != first)
            })
    };
    let tested = Tested {
        moving: (0..reading.model().joint_count())
            .filter(is_moving)
            .collect(),
        unequal: Vec::new(),
    };
    let experiment = prepared.experiment();
    let examined = joints(experiment, &reading, excerpt, "", &tested, true);
    examined.is_some_and(|examined| {
        (examined.findings.iter()).any(|finding| {
            let is_sensor = matches!(&*finding.code, "joint-torque-sign" | "joint-torque-scale");
            is_sensor || !is_explained && finding.severity == Severity::Error
        })
    })
}
