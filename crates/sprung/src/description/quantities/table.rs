//! The keys of `[log]` that name columns of measured quantities.

use sprung_core::chain::JointKind::{self, Prismatic, Revolute};

use super::quantity::{Measures, Quantity, Signal};
use crate::description::columns::Columns;
use crate::description::log::Log;
use crate::description::robot::Robot;
use crate::description::units::Dimension;

/// A key of `[log]` and what its columns hold.
#[derive(Debug)]
pub(crate) struct Key {
    /// Its name.
    pub(crate) name: &'static str,
    /// What its columns measure, once they are scaled.
    pub(crate) quantity: Quantity,
    /// The kind of joints of which it speaks; any, if none is named.
    pub(crate) kind: Option<JointKind>,
    /// What its readings are in.
    pub(crate) unit: KeyUnit,
    /// How its readings are brought to the output side.
    pub(crate) scaling: Scaling,
    /// Whether a template shows it.
    pub(crate) template: InTemplate,
    /// The columns that a log names under it.
    pub(crate) columns: fn(&Log) -> &Option<Columns>,
    /// The same, to be replaced.
    pub(crate) columns_mut: fn(&mut Log) -> &mut Option<Columns>,
}

/// What the readings of a key's columns are in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum KeyUnit {
    /// The key ends in its unit, which has this size in SI units.
    InName(f64),
    /// Each column says its unit, which measures this.
    Said {
        /// Of a joint that turns.
        turning: Dimension,
        /// Of a joint that slides.
        sliding: Dimension,
    },
}

/// From readings to quantities on the output side of the gearbox.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scaling {
    /// They were taken there.
    None,
    /// By the gear ratio where motor positions were recorded on the motor's side.
    PositionSide,
    /// By the gear ratio where motor torques were recorded on the motor's side.
    TorqueSide,
    /// By the torque constant, from A.
    TorqueConstant,
    /// By the amplifier's gain and the torque constant, from V.
    AmplifierGain,
}

/// How a template shows a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum InTemplate {
    /// It does not.
    No,
    /// To be filled in, with columns of this stem.
    FillIn(&'static str),
    /// As another that may stand in its place, with columns of this stem.
    Instead(&'static str),
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;
const SI: KeyUnit = KeyUnit::InName(1.0);
const DEGREES: KeyUnit = KeyUnit::InName(DEGREE);
const SAID_POSITION: KeyUnit = KeyUnit::Said {
    turning: Dimension::Angle,
    sliding: Dimension::Length,
};
const SAID_TORQUE: KeyUnit = KeyUnit::Said {
    turning: Dimension::Torque,
    sliding: Dimension::Force,
};
const SAID_CURRENT: KeyUnit = KeyUnit::Said {
    turning: Dimension::Current,
    sliding: Dimension::Current,
};
const SAID_VOLTAGE: KeyUnit = KeyUnit::Said {
    turning: Dimension::Voltage,
    sliding: Dimension::Voltage,
};

/// A row of the table; the key is the name of its field in [`Log`].
macro_rules! key {
    ($name:ident, $quantity:ident, $kind:expr, $unit:expr, $scaling:ident, $template:expr) => {
        Key {
            name: stringify!($name),
            quantity: Quantity::$quantity,
            kind: $kind,
            unit: $unit,
            scaling: Scaling::$scaling,
            template: $template,
            columns: |log| &log.$name,
            columns_mut: |log| &mut log.$name,
        }
    };
}

const NO: InTemplate = InTemplate::No;
const fn fill_in(stem: &'static str) -> InTemplate {
    InTemplate::FillIn(stem)
}
const fn instead(stem: &'static str) -> InTemplate {
    InTemplate::Instead(stem)
}

/// All keys that name columns of measured quantities, those of one signal together.
#[rustfmt::skip]
pub(crate) static KEYS: [Key; 18] = [
    //   key                  measures        joints           unit           scaled by       template
    key!(link_position_rad,   LinkPosition,   Some(Revolute),  SI,            None,           fill_in("q")),
    key!(link_position_deg,   LinkPosition,   Some(Revolute),  DEGREES,       None,           instead("q")),
    key!(link_deflection_rad, LinkDeflection, Some(Revolute),  SI,            None,           instead("defl")),
    key!(link_deflection_deg, LinkDeflection, Some(Revolute),  DEGREES,       None,           NO),
    key!(link_position_m,     LinkPosition,   Some(Prismatic), SI,            None,           fill_in("q")),
    key!(link_position,       LinkPosition,   None,            SAID_POSITION, None,           NO),
    key!(link_deflection,     LinkDeflection, None,            SAID_POSITION, None,           NO),
    key!(motor_position_rad,  MotorPosition,  Some(Revolute),  SI,            PositionSide,   fill_in("phi")),
    key!(motor_position_deg,  MotorPosition,  Some(Revolute),  DEGREES,       PositionSide,   instead("phi")),
    key!(motor_position_m,    MotorPosition,  Some(Prismatic), SI,            PositionSide,   fill_in("phi")),
    key!(motor_position,      MotorPosition,  None,            SAID_POSITION, PositionSide,   NO),
    key!(motor_torque_nm,     MotorTorque,    Some(Revolute),  SI,            TorqueSide,     fill_in("tau")),
    key!(motor_force_n,       MotorTorque,    Some(Prismatic), SI,            TorqueSide,     fill_in("f")),
    key!(motor_torque,        MotorTorque,    None,            SAID_TORQUE,   TorqueSide,     NO),
    key!(motor_current_a,     MotorTorque,    None,            SI,            TorqueConstant, instead("i")),
    key!(motor_current,       MotorTorque,    None,            SAID_CURRENT,  TorqueConstant, NO),
    key!(drive_voltage_v,     MotorTorque,    None,            SI,            AmplifierGain,  NO),
    key!(drive_voltage,       MotorTorque,    None,            SAID_VOLTAGE,  AmplifierGain,  NO),
];

impl Key {
    /// Returns the keys that tell a signal.
    pub(crate) fn of(signal: Signal) -> impl Iterator<Item = &'static Self> {
        KEYS.iter().filter(move |key| key.signal() == signal)
    }

    /// Returns the signal that it tells.
    pub(crate) fn signal(&self) -> Signal {
        self.quantity.signal()
    }

    /// Returns whether a log has columns under it.
    pub(crate) fn is_given(&self, log: &Log) -> bool {
        (self.columns)(log).is_some()
    }

    /// Returns the joints that have a column under it, from 0.
    ///
    /// - `joints`: whether rigid joints count where only flexible ones have the quantity.
    pub(crate) fn joints(&self, joints: Joints, robot: &Robot) -> Vec<usize> {
        let flexible = self.signal().is_of_flexible_joints() && joints == Joints::ThatHaveIt;
        (0..robot.joint.len())
            .filter(|&i| !flexible || robot.joint[i].is_flexible())
            .filter(|&i| self.kind.is_none_or(|kind| robot.kind(i) == kind))
            .collect()
    }

    /// Returns the field of a message that holds it, unless a column says another.
    pub(crate) const fn default_field(&self) -> &'static str {
        if self.quantity.is_position() {
            "position"
        } else {
            "effort"
        }
    }

    /// Returns the key that says on which side of the gearbox it was recorded, if its columns
    /// may say that as well.
    pub(crate) const fn side_key(&self) -> Option<&'static str> {
        match (self.unit, self.scaling) {
            (KeyUnit::Said { .. }, Scaling::PositionSide) => Some("motor_position_side"),
            (KeyUnit::Said { .. }, Scaling::TorqueSide) => Some("motor_torque_side"),
            _ => None,
        }
    }

    /// Returns whether its first reading may be given, rad: that of an absolute angle.
    pub(crate) fn may_start_anywhere(&self) -> bool {
        let in_metres = self.kind == Some(Prismatic);
        match self.quantity.measures() {
            Measures::Position { link, motor } => link + motor != 0.0 && !in_metres,
            Measures::RightHandSide(_) => false,
        }
    }
}

/// Which joints a key speaks of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Joints {
    /// Those that have the quantity.
    ThatHaveIt,
    /// Rigid ones as well: a rigid robot may call its only positions those of its links.
    Rigid,
}
