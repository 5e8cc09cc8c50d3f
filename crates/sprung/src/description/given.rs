//! The measured quantities of a log, their files and their side of the gearbox.

use std::path::PathBuf;

use super::columns::Columns;
use super::log::Log;
use super::quantities::{KEYS, Key, Scaling, Signal};
use super::robot::Side;

impl Log {
    /// Returns the keys of the measured quantities in the log, with their columns.
    pub(crate) fn given(&self) -> impl Iterator<Item = (&'static Key, &Columns)> {
        KEYS.iter()
            .filter_map(|key| Some((key, (key.columns)(self).as_ref()?)))
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

    /// Returns this log with the entries of `over` in place of its own; a signal in `over` replaces
    /// all columns of this signal.
    #[must_use]
    pub fn overlaid(&self, over: &Self) -> Self {
        let mut log = self.clone();
        macro_rules! replace {
            ($($key:ident),+) => {
                if false $(|| over.$key.is_some())+ {
                    $(log.$key.clone_from(&over.$key);)+
                }
            };
        }
        for signal in Signal::ALL {
            if Key::of(signal).any(|key| key.is_given(over)) {
                for key in Key::of(signal) {
                    (key.columns_mut)(&mut log).clone_from((key.columns)(over));
                }
            }
        }
        replace!(time_s, time_ms, time_us, time_ns, time, period_s, sampling);
        log.file = over.file.clone().or(log.file);
        log.csv = over.csv.clone().or(log.csv);
        log.motor_position_side = over.motor_position_side.or(log.motor_position_side);
        log.motor_torque_side = over.motor_torque_side.or(log.motor_torque_side);
        log.motor_torque_exact |= over.motor_torque_exact;
        log.delay_s.extend(over.delay_s.clone());
        log.sign.extend(over.sign.clone());
        log.gain.extend(over.gain.clone());
        log
    }
}
