//! The measured quantities of a log, their files and their side of the gearbox.

use std::path::PathBuf;

use super::columns::Columns;
use super::log::Log;
use super::quantities::{Axis, KEYS, Key, Scaling, Signal};
use super::robot::{Robot, Side};

/// The torque sensor of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TorqueSensor {
    /// The joint has none.
    Absent,
    /// The log has its torque and the link position.
    BesideLink,
    /// The log has its torque and no link position.
    Alone,
}

impl Log {
    /// Returns the keys of the measured quantities in the log, with their columns.
    pub(crate) fn given(&self) -> impl Iterator<Item = (&'static Key, &Columns)> {
        KEYS.iter()
            .filter_map(|key| Some((key, (key.columns)(self).as_ref()?)))
    }

    /// Returns what the log has of the torque sensor of a joint.
    pub(crate) fn torque_sensor(&self, robot: &Robot, joint: usize) -> TorqueSensor {
        let has = |signal| Key::gives(signal, joint, self, robot);
        match (has(Signal::Spring), has(Signal::Link)) {
            (false, _) => TorqueSensor::Absent,
            (true, true) => TorqueSensor::BesideLink,
            (true, false) => TorqueSensor::Alone,
        }
    }

    /// Returns whether the log has an axis of a gyroscope on the link of a joint.
    pub(crate) fn has_gyroscope(&self, robot: &Robot, joint: usize) -> bool {
        (Axis::ALL.into_iter()).any(|axis| Key::gives(Signal::Gyroscope(axis), joint, self, robot))
    }

    /// Returns all files that the log names.
    pub fn files(&self) -> impl Iterator<Item = &PathBuf> {
        let of_columns = self.given().flat_map(|(_, columns)| &columns.0);
        (self.file.iter().flatten().map(|file| &file.path))
            .chain((of_columns.chain(&self.time)).filter_map(|column| column.file.as_ref()))
    }

    /// Returns the side of the gearbox on which the quantities with this scaling were recorded, if
    /// the log declares it.
    pub(crate) fn side(&self, scaling: Scaling) -> Option<Side> {
        let declared = match scaling {
            Scaling::PositionSide => self.motor_position_side,
            Scaling::TorqueSide => self.motor_torque_side,
            Scaling::None | Scaling::TorqueConstant | Scaling::AmplifierGain => None,
        };
        declared.or_else(|| {
            (self.given())
                .filter(|(key, _)| key.scaling == scaling)
                .flat_map(|(_, columns)| &columns.0)
                .find_map(|column| column.side)
        })
    }
}
