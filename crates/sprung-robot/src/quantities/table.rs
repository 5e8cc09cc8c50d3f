//! The keys of `[log]` that name columns of measured quantities.

use sprung_core::chain::JointKind::{self, Prismatic, Revolute};
use sprung_core::covariate::Covariate;

use super::quantity::Quantity::{
    self, DriveOn, JointTorque, LinkDeflection, LinkPosition, MotorPosition, MotorTarget,
    MotorTorque,
};
use super::quantity::{IN_COLUMNS, Measures, Signal};
use crate::columns::Columns;
use crate::inertial::{Axis, Inertial};
use crate::log::Log;
use crate::robot::{Robot, Seen};
use crate::units::Dimension;

/// A key of `[log]` and the meaning of its columns.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// Its name.
    pub name: &'static str,
    /// The quantity of its columns after scaling.
    pub quantity: Quantity,
    /// The kind of its joints; `None` for all kinds.
    pub kind: Option<JointKind>,
    /// The unit of its readings.
    pub unit: KeyUnit,
    /// The conversion of its readings to the output side of the gearbox.
    pub scaling: Scaling,
    /// Its place in a template.
    pub(crate) template: InTemplate,
    columns: ColumnsPlace,
}

/// Where a log has the columns of a key.
#[derive(Clone, Copy, Debug)]
enum ColumnsPlace {
    /// In a field: the same columns twice, the second time mutable.
    Field(
        fn(&Log) -> &Option<Columns>,
        fn(&mut Log) -> &mut Option<Columns>,
    ),
    /// Among the covariates.
    Covariate(Covariate),
}

/// The unit of the readings of a key's columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KeyUnit {
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
pub enum Scaling {
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
/// Standard gravity, m/s².
const STANDARD_GRAVITY: KeyUnit = KeyUnit::InName(9.806_65);
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

const GYRO_X: Quantity = Quantity::Inertial(Inertial::Gyroscope, Axis::X);
const GYRO_Y: Quantity = Quantity::Inertial(Inertial::Gyroscope, Axis::Y);
const GYRO_Z: Quantity = Quantity::Inertial(Inertial::Gyroscope, Axis::Z);
const ACCEL_X: Quantity = Quantity::Inertial(Inertial::Accelerometer, Axis::X);
const ACCEL_Y: Quantity = Quantity::Inertial(Inertial::Accelerometer, Axis::Y);
const ACCEL_Z: Quantity = Quantity::Inertial(Inertial::Accelerometer, Axis::Z);

/// A row of the table; the key is the name of its field in [`Log`].
macro_rules! key {
    ($name:ident $(. $axis:ident)?, $quantity:expr, $kind:expr, $unit:expr, $scaling:ident, $template:expr) => {
        Key {
            name: concat!(stringify!($name) $(, ".", stringify!($axis))?),
            quantity: $quantity,
            kind: $kind,
            unit: $unit,
            scaling: Scaling::$scaling,
            template: $template,
            columns: ColumnsPlace::Field(|log| &log.$name$(.$axis)?, |log| &mut log.$name$(.$axis)?),
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
pub(crate) static KEYS: [Key; OF_SENSORS.len() + IN_COLUMNS.len()] = {
    let mut all = [OF_SENSORS[0]; OF_SENSORS.len() + IN_COLUMNS.len()];
    let mut i = 0;
    while i < all.len() {
        all[i] = if i < OF_SENSORS.len() {
            OF_SENSORS[i]
        } else {
            of_covariate(IN_COLUMNS[i - OF_SENSORS.len()])
        };
        i += 1;
    }
    all
};

const fn of_covariate(covariate: Covariate) -> Key {
    Key {
        name: covariate.key(),
        quantity: Quantity::Covariate(covariate),
        kind: None,
        unit: SI,
        scaling: Scaling::None,
        template: NO,
        columns: ColumnsPlace::Covariate(covariate),
    }
}

#[rustfmt::skip]
const OF_SENSORS: [Key; 37] = [
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
    key!(gyroscope_rad_per_s.x, GYRO_X, Some(Revolute), SI, None, NO),
    key!(gyroscope_deg_per_s.x, GYRO_X, Some(Revolute), DEGREES, None, NO),
    key!(gyroscope_rad_per_s.y, GYRO_Y, Some(Revolute), SI, None, NO),
    key!(gyroscope_deg_per_s.y, GYRO_Y, Some(Revolute), DEGREES, None, NO),
    key!(gyroscope_rad_per_s.z, GYRO_Z, Some(Revolute), SI, None, NO),
    key!(gyroscope_deg_per_s.z, GYRO_Z, Some(Revolute), DEGREES, None, NO),
    key!(accelerometer_m_per_s2.x, ACCEL_X, None, SI, None, NO),
    key!(accelerometer_g.x, ACCEL_X, None, STANDARD_GRAVITY, None, NO),
    key!(accelerometer_m_per_s2.y, ACCEL_Y, None, SI, None, NO),
    key!(accelerometer_g.y, ACCEL_Y, None, STANDARD_GRAVITY, None, NO),
    key!(accelerometer_m_per_s2.z, ACCEL_Z, None, SI, None, NO),
    key!(accelerometer_g.z, ACCEL_Z, None, STANDARD_GRAVITY, None, NO),
];

impl Key {
    /// Returns the keys that give a signal.
    pub(crate) fn of(signal: Signal) -> impl Iterator<Item = &'static Self> {
        KEYS.iter().filter(move |key| key.signal() == signal)
    }

    /// Returns the keys of a quantity whose names end in its SI unit.
    pub fn in_si_units(quantity: Quantity) -> impl Iterator<Item = &'static Self> {
        (KEYS.iter()).filter(move |key| {
            key.quantity == quantity && key.unit == SI && key.scaling.keeps_the_unit()
        })
    }

    /// Returns the key of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        KEYS.iter().find(|key| key.name == name)
    }

    /// Returns the signal that it gives.
    #[must_use]
    pub fn signal(&self) -> Signal {
        self.quantity.signal()
    }

    /// Returns its columns in a log.
    pub(crate) fn columns<'a>(&self, log: &'a Log) -> Option<&'a Columns> {
        match self.columns {
            ColumnsPlace::Field(columns, _) => columns(log).as_ref(),
            ColumnsPlace::Covariate(covariate) => log.covariates.of(covariate),
        }
    }

    /// Returns its columns in a log, mutable.
    pub fn columns_mut<'a>(&self, log: &'a mut Log) -> &'a mut Option<Columns> {
        match self.columns {
            ColumnsPlace::Field(_, columns) => columns(log),
            ColumnsPlace::Covariate(covariate) => log.covariates.of_mut(covariate),
        }
    }

    /// Returns whether a log has columns under it.
    pub(crate) fn is_given(&self, log: &Log) -> bool {
        self.columns(log).is_some()
    }

    /// Returns whether a log gives a signal of a joint.
    pub(crate) fn gives(signal: Signal, joint: usize, log: &Log, robot: &Robot) -> bool {
        Self::of(signal)
            .filter(|key| key.is_given(log))
            .any(|key| (key.joints_in(log, Joints::ThatHaveIt, robot)).contains(&joint))
            && !(signal.is_of_flexible_joints() && robot.joint[joint].seen != Seen::AsDescribed)
    }

    /// Returns the indices of the joints that have a column under it.
    ///
    /// - `joints`: whether rigid joints have a column as well if the quantity is that of flexible
    ///   joints.
    #[must_use]
    pub fn joints(&self, joints: Joints, robot: &Robot) -> Vec<usize> {
        let flexible = self.signal().is_of_flexible_joints() && joints == Joints::ThatHaveIt;
        let depends = |joint: usize| match self.signal() {
            Signal::Covariate(covariate) => robot.joint[joint].depends_on(covariate),
            Signal::Link
            | Signal::Motor
            | Signal::Torque
            | Signal::Target
            | Signal::Switch
            | Signal::Spring
            | Signal::Inertial(..) => true,
        };
        (0..robot.joint.len())
            .filter(|&i| depends(i))
            .filter(|&i| !flexible || robot.joint[i].is_described_flexible())
            .filter(|&i| self.kind.is_none_or(|kind| robot.kind(i) == kind))
            .collect()
    }

    /// Returns the indices of the joints that have a column under it in a log. A key for all kinds of joints, such as
    /// `motor_current_a`, leaves out those for whose kind another key gives the signal, such as `motor_force_n`.
    #[must_use]
    pub fn joints_in(&self, log: &Log, joints: Joints, robot: &Robot) -> Vec<usize> {
        let others = || Self::of(self.signal()).filter(|key| key.is_given(log));
        let is_of_other =
            |i: &usize| self.kind.is_none() && others().any(|key| key.kind == Some(robot.kind(*i)));
        let mut all = self.joints(joints, robot);
        all.retain(|i| !is_of_other(i));
        all
    }

    /// Returns the default field of a message for it.
    #[must_use]
    pub const fn default_field(&self) -> &'static str {
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
            | Measures::Motion(..)
            | Measures::Covariate(_) => false,
        }
    }
}

/// The joints of a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Joints {
    /// The joints that have the quantity.
    ThatHaveIt,
    /// Rigid joints as well: the log of a rigid robot may call its only positions link positions.
    Rigid,
}
