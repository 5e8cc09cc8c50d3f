//! The instrument of a joint and its properties.

use std::f64::consts::TAU;

use super::super::log::Log;
use super::super::quantities::{Key, Quantity, Row, Signal};
use super::super::robot::{Joint, Robot};
use super::right_hand_side::RightHandSide;
use crate::inertial::{Axis, Inertial};

/// What the log of a joint has beside motor position and motor torque.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Instrument {
    /// Nothing: motor and link of a rigid joint have one position.
    Motor,
    /// Nothing: the drive of a position servo has a target in place of the torque.
    Servo,
    /// A link position; also a flexible joint without log.
    Link,
    /// A deflection.
    Deflection,
    /// A torque of the spring, and a link position or a deflection.
    TorqueAndLink,
    /// A torque of the spring.
    Torque,
    /// A sensor of the link's motion.
    Inertial(Inertial),
}

/// Source of the link position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkPosition {
    /// It is the motor position.
    Motor,
    /// A column of the log, or its sum with the motor position.
    Column,
    /// Motor position minus measured torque over stiffness.
    ByTorque,
    /// Motor position minus the deflection by this sensor, which passes a high-pass filter.
    ByMotion(Inertial),
}

/// The torque of a spring in the rows of the regression.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpringTorque {
    /// From parameters and deflection.
    Modelled,
    /// Measured; the reading contains a constant offset.
    Measured,
}

/// A high-pass filter `(s/(s + w))^order` that the rows of a joint pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowFilter {
    /// w, rad/s.
    pub corner: f64,
    /// Its order.
    pub order: usize,
    /// Time in which it settles after a start, in time constants 1/w.
    pub settling_time_constants: f64,
}

impl Instrument {
    /// Returns the instrument of a joint.
    #[must_use]
    pub fn of(joint: usize, log: &Log, robot: &Robot) -> Self {
        let has = |signal| Key::gives(signal, joint, log, robot);
        let mut keys = Key::of(Signal::Link).filter(|key| key.is_given(log));
        let is_deflection =
            (keys.next()).is_some_and(|key| key.quantity == Quantity::LinkDeflection);
        let inertial = (Inertial::ALL.into_iter())
            .find(|kind| (Axis::ALL.into_iter()).any(|axis| has(Signal::Inertial(*kind, axis))));
        match (inertial, has(Signal::Spring), has(Signal::Link)) {
            (Some(sensor), ..) => Self::Inertial(sensor),
            (None, true, true) => Self::TorqueAndLink,
            (None, true, false) => Self::Torque,
            (None, false, _) if is_deflection && robot.joint[joint].is_flexible() => {
                Self::Deflection
            }
            (None, false, _) => Self::without_log(&robot.joint[joint]),
        }
    }

    /// Returns the instrument of a joint without log, which has the equations of motion as its rows.
    #[must_use]
    pub fn without_log(joint: &Joint) -> Self {
        match (joint.is_flexible(), &joint.servo) {
            (true, _) => Self::Link,
            (false, Some(_)) => Self::Servo,
            (false, None) => Self::Motor,
        }
    }

    /// Returns the source of the link position.
    #[must_use]
    pub const fn link_position(self) -> LinkPosition {
        match self {
            Self::Motor | Self::Servo => LinkPosition::Motor,
            Self::Link | Self::Deflection | Self::TorqueAndLink => LinkPosition::Column,
            Self::Torque => LinkPosition::ByTorque,
            Self::Inertial(sensor) => LinkPosition::ByMotion(sensor),
        }
    }

    /// Returns the rows of the regression.
    #[must_use]
    pub const fn rows(self) -> &'static [Row] {
        match self {
            Self::Motor | Self::Servo => &[Row::Motor],
            Self::Link | Self::Deflection | Self::Torque | Self::Inertial(_) => {
                &[Row::Link, Row::Motor]
            }
            Self::TorqueAndLink => &[Row::Link, Row::Motor, Row::Spring],
        }
    }

    /// Returns the torque of the spring in these rows.
    #[must_use]
    pub const fn spring_torque(self) -> SpringTorque {
        match self {
            Self::Torque | Self::TorqueAndLink => SpringTorque::Measured,
            Self::Motor | Self::Servo | Self::Link | Self::Deflection | Self::Inertial(_) => {
                SpringTorque::Modelled
            }
        }
    }

    /// Returns the right-hand side of a row of a joint.
    #[must_use]
    pub const fn right_hand_side(self, row: Row, joint: usize) -> RightHandSide {
        match (self.spring_torque(), row) {
            (SpringTorque::Modelled, Row::Link) => RightHandSide::Zero,
            (SpringTorque::Modelled, Row::Motor) => RightHandSide::MotorTorque(joint),
            (SpringTorque::Measured, Row::Link) | (_, Row::Spring) => {
                RightHandSide::SpringTorque(joint)
            }
            (SpringTorque::Measured, Row::Motor) => RightHandSide::MotorMinusSpring(joint),
        }
    }

    /// Returns whether it shows constant deflections, and with them preloads of springs.
    #[must_use]
    pub const fn shows_constant_deflections(self) -> bool {
        match self.link_position() {
            LinkPosition::Motor | LinkPosition::Column => true,
            LinkPosition::ByTorque | LinkPosition::ByMotion(_) => false,
        }
    }

    /// Returns whether it gives the acceleration of the joint. The link row then has torques by this acceleration in place
    /// of momenta.
    #[must_use]
    pub const fn gives_acceleration(self) -> bool {
        match self.inertial() {
            Some(sensor) => sensor.gives_acceleration(),
            None => false,
        }
    }

    /// Returns the sensor on the link that gives its position.
    pub(crate) const fn inertial(self) -> Option<Inertial> {
        match self.link_position() {
            LinkPosition::ByMotion(sensor) => Some(sensor),
            LinkPosition::Motor | LinkPosition::Column | LinkPosition::ByTorque => None,
        }
    }
}

/// The instruments of all joints.
#[derive(Clone, Debug, PartialEq)]
pub struct Instrumentation {
    joints: Vec<Instrument>,
    filters: Vec<Option<RowFilter>>,
}

impl Instrumentation {
    /// Returns the instruments of a robot in a log; without log those of the equations of motion.
    pub fn new(robot: &Robot, log: Option<&Log>) -> Self {
        let Some(log) = log else {
            return Self::of(robot.joint.iter().map(Instrument::without_log).collect());
        };
        let joints = 0..robot.joint.len();
        let joints = joints.map(|joint| Instrument::of(joint, log, robot));
        let mut instruments = Self::of(joints.collect());
        for (filter, joint) in instruments.filters.iter_mut().zip(&instruments.joints) {
            *filter = joint.inertial().map(|sensor| {
                let corner = sensor.given_corner_hz(log);
                RowFilter {
                    corner: TAU * corner.unwrap_or(sensor.usual_corner_hz()),
                    order: sensor.order(),
                    settling_time_constants: sensor.settling_time_constants(),
                }
            });
        }
        instruments
    }

    /// Returns instruments without filters.
    #[must_use]
    pub fn of(joints: Vec<Instrument>) -> Self {
        Self {
            filters: vec![None; joints.len()],
            joints,
        }
    }

    /// Returns the number of joints.
    #[must_use]
    pub fn joint_count(&self) -> usize {
        self.joints.len()
    }

    /// Returns the instrument of a joint.
    #[must_use]
    pub fn at(&self, joint: usize) -> Instrument {
        self.joints[joint]
    }

    /// Returns whether the torque of any spring is measured; the regression then has other rows than the
    /// equations of motion.
    #[must_use]
    pub fn has_measured_springs(&self) -> bool {
        self.iter()
            .any(|instrument| instrument.spring_torque() == SpringTorque::Measured)
    }

    /// Returns the instruments, joint by joint.
    pub fn iter(&self) -> impl Iterator<Item = Instrument> {
        self.joints.iter().copied()
    }

    /// Returns the filter that the rows of a joint pass; `None` for rows without filter.
    #[must_use]
    pub fn row_filter(&self, joint: usize) -> Option<RowFilter> {
        self.filters[joint]
    }
}
