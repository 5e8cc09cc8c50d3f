//! The measured quantities of a log, their files and their side of the gearbox.

use std::path::PathBuf;

use super::columns::Columns;
use super::log::Log;
use super::quantities::{KEYS, Key, Scaling};
use super::robot::Side;

impl Log {
    /// Returns the keys of the measured quantities in the log, with their columns.
    pub fn given(&self) -> impl Iterator<Item = (&'static Key, &Columns)> {
        KEYS.iter()
            .filter_map(|key| Some((key, key.columns(self)?)))
    }

    /// Returns all files that the log names.
    pub fn files(&self) -> impl Iterator<Item = &PathBuf> {
        let of_columns = self.given().flat_map(|(_, columns)| &columns.0);
        (self.file.iter().flatten().map(|file| &file.path))
            .chain((of_columns.chain(&self.time)).filter_map(|column| column.file.as_ref()))
    }

    /// Returns the side of the gearbox on which the quantities with this scaling were recorded, if
    /// the log declares it.
    #[must_use]
    pub fn side(&self, scaling: Scaling) -> Option<Side> {
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
