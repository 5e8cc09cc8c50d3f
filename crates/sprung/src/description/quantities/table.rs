//! The keys of `[log]` that name columns of measured quantities.

use sprung_core::chain::JointKind::{self, Prismatic, Revolute};
use sprung_core::covariate::Covariate;

use super::quantity::Quantity::{
    self, DriveOn, JointTorque, LinkDeflection, LinkPosition, MotorPosition, MotorTarget,
    MotorTorque,
};
use super::quantity::{Axis, Measures, Signal};
use crate::description::columns::Columns;
use crate::description::log::Log;
use crate::description::robot::Robot;
use crate::description::units::Dimension;

/// A key of `[log]` and the meaning of its columns.
#[derive(Debug)]
pub(crate) struct Key {
    /// Its name.
    pub(crate) name: &'static str,
    /// The quantity of its columns after scaling.
    pub(crate) quantity: Quantity,
    /// The kind of its joints; `None` for all kinds.
    pub(crate) kind: Option<JointKind>,
    /// The unit of its readings.
    pub(crate) unit: KeyUnit,
    /// The conversion of its readings to the output side of the gearbox.
    pub(crate) scaling: Scaling,
    /// Its place in a template.
    pub(crate) template: InTemplate,
    /// The columns under this key in a log.
    pub(crate) columns: fn(&Log) -> &Option<Columns>,
    /// The same columns, mutable.
    pub(crate) columns_mut: fn(&mut Log) -> &mut Option<Columns>,
}

/// The unit of the readings of a key's columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum KeyUnit {
    /// The key ends in its unit, which has this size in SI units.
    InName(f64),
    /// Each column declares a unit of this dimension.
    Said {
        /// For a revolute joint.
        turning: Dimension,
        /// For a prismatic joint.
        sliding: Dimension,
    },
}

/// The conversion of readings to quantities on the output side of the gearbox.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scaling {
    /// No conversion: the readings were taken on the output side.
    None,
    /// By the gear ratio, if motor positions were recorded on the motor side.
    PositionSide,
    /// By the gear ratio, if motor torques were recorded on the motor side.
    TorqueSide,
    /// By the torque constant, from A.
    TorqueConstant,
    /// By the amplifier gain, or the resistance of the winding, and the torque constant, from V.
    AmplifierGain,
}

impl Scaling {
    fn keeps_the_unit(self) -> bool {
        !matches!(self, Self::TorqueConstant | Self::AmplifierGain)
    }
}

/// The place of a key in a template.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum InTemplate {
    /// The template does not contain it.
    No,
    /// A line to be filled in; column names have this stem.
    FillIn(&'static str),
    /// A commented alternative to another line; column names have this stem.
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

const GYRO_X: Quantity = Quantity::Gyroscope(Axis::X);
const GYRO_Y: Quantity = Quantity::Gyroscope(Axis::Y);
const GYRO_Z: Quantity = Quantity::Gyroscope(Axis::Z);
const TEMPERATURE: Quantity = Quantity::Covariate(Covariate::Temperature);
const OPERATION: Quantity = Quantity::Covariate(Covariate::Operation);
const AGE: Quantity = Quantity::Covariate(Covariate::Age);
const CYCLES: Quantity = Quantity::Covariate(Covariate::Cycles);
const OTHER: Quantity = Quantity::Covariate(Covariate::Other);

/// A row of the table; the key is the name of its field in [`Log`].
macro_rules! key {
    ($name:ident, $quantity:expr, $kind:expr, $unit:expr, $scaling:ident, $template:expr) => {
        Key {
            name: stringify!($name),
            quantity: $quantity,
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

/// All keys for columns of measured quantities, grouped by signal.
#[rustfmt::skip]
pub(crate) static KEYS: [Key; 36] = [
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
    key!(motor_target_rad,    MotorTarget,    Some(Revolute),  SI,            PositionSide,   NO),
    key!(motor_target_deg,    MotorTarget,    Some(Revolute),  DEGREES,       PositionSide,   NO),
    key!(motor_target,        MotorTarget,    None,            SAID_POSITION, PositionSide,   NO),
    key!(drive_on,            DriveOn,        None,            SI,            None,           NO),
    key!(joint_torque_nm,     JointTorque,    Some(Revolute),  SI,            None,           NO),
    key!(joint_force_n,       JointTorque,    Some(Prismatic), SI,            None,           NO),
    key!(joint_torque,        JointTorque,    None,            SAID_TORQUE,   None,           NO),
    key!(gyroscope_x_rad_per_s, GYRO_X,       Some(Revolute),  SI,            None,           NO),
    key!(gyroscope_x_deg_per_s, GYRO_X,       Some(Revolute),  DEGREES,       None,           NO),
    key!(gyroscope_y_rad_per_s, GYRO_Y,       Some(Revolute),  SI,            None,           NO),
    key!(gyroscope_y_deg_per_s, GYRO_Y,       Some(Revolute),  DEGREES,       None,           NO),
    key!(gyroscope_z_rad_per_s, GYRO_Z,       Some(Revolute),  SI,            None,           NO),
    key!(gyroscope_z_deg_per_s, GYRO_Z,       Some(Revolute),  DEGREES,       None,           NO),
    key!(temperature_c,       TEMPERATURE,    None,            SI,            None,           NO),
    key!(operation_h,         OPERATION,      None,            SI,            None,           NO),
    key!(age_d,               AGE,            None,            SI,            None,           NO),
    key!(cycles,              CYCLES,         None,            SI,            None,           NO),
    key!(covariate,           OTHER,          None,            SI,            None,           NO),
];

impl Key {
    /// Returns the keys that give a signal.
    pub(crate) fn of(signal: Signal) -> impl Iterator<Item = &'static Self> {
        KEYS.iter().filter(move |key| key.signal() == signal)
    }

    /// Returns the keys of a quantity whose names end in its SI unit.
    pub(crate) fn in_si_units(quantity: Quantity) -> impl Iterator<Item = &'static Self> {
        (KEYS.iter()).filter(move |key| {
            key.quantity == quantity && key.unit == SI && key.scaling.keeps_the_unit()
        })
    }

    /// Returns the key of this name.
    pub(crate) fn named(name: &str) -> Option<&'static Self> {
        KEYS.iter().find(|key| key.name == name)
    }

    /// Returns the signal that it gives.
    pub(crate) fn signal(&self) -> Signal {
        self.quantity.signal()
    }

    /// Returns whether a log has columns under it.
    pub(crate) fn is_given(&self, log: &Log) -> bool {
        (self.columns)(log).is_some()
    }

    /// Returns whether a log gives a signal of a joint.
    pub(crate) fn gives(signal: Signal, joint: usize, log: &Log, robot: &Robot) -> bool {
        Self::of(signal)
            .filter(|key| key.is_given(log))
            .any(|key| key.joints(Joints::ThatHaveIt, robot).contains(&joint))
    }

    /// Returns the indices of the joints that have a column under it.
    ///
    /// - `joints`: whether rigid joints have a column as well if the quantity is that of flexible
    ///   joints.
    pub(crate) fn joints(&self, joints: Joints, robot: &Robot) -> Vec<usize> {
        let flexible = self.signal().is_of_flexible_joints() && joints == Joints::ThatHaveIt;
        let depends = |joint: usize| match self.signal() {
            Signal::Covariate(covariate) => robot.joint[joint].depends_on(covariate),
            _ => true,
        };
        (0..robot.joint.len())
            .filter(|&i| depends(i))
            .filter(|&i| !flexible || robot.joint[i].is_flexible())
            .filter(|&i| self.kind.is_none_or(|kind| robot.kind(i) == kind))
            .collect()
    }

    /// Returns the default field of a message for it.
    pub(crate) const fn default_field(&self) -> &'static str {
        if self.quantity.is_position() {
            "position"
        } else {
            "effort"
        }
    }

    /// Returns the key that gives the side of the gearbox for all its columns, if each column may
    /// also give the side.
    pub(crate) const fn side_key(&self) -> Option<&'static str> {
        match (self.unit, self.scaling) {
            (KeyUnit::Said { .. }, Scaling::PositionSide) => Some("motor_position_side"),
            (KeyUnit::Said { .. }, Scaling::TorqueSide) => Some("motor_torque_side"),
            _ => None,
        }
    }

    /// Returns whether `starts_at_rad` may give its first value: only for absolute angles.
    pub(crate) fn may_start_anywhere(&self) -> bool {
        let in_metres = self.kind == Some(Prismatic);
        match self.quantity.measures() {
            Measures::Position { link, motor } => link + motor != 0.0 && !in_metres,
            Measures::RightHandSide(_)
            | Measures::Target
            | Measures::Switch
            | Measures::AngularVelocity(_)
            | Measures::Covariate(_) => false,
        }
    }
}

/// The joints of a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Joints {
    /// The joints that have the quantity.
    ThatHaveIt,
    /// Rigid joints as well: the log of a rigid robot may call its only positions link positions.
    Rigid,
}
