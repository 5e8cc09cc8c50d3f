//! The measured quantities, and their place in the equations of motion.

use sprung_core::chain::JointKind;
use sprung_core::covariate::{Covariate, Source};

use crate::inertial::{Axis, Inertial};
use crate::robot::Joint;

/// The covariates that logs have in columns.
pub(super) const IN_COLUMNS: [Covariate; count_in_columns()] = {
    let mut found = [Covariate::ALL[0]; count_in_columns()];
    let (mut i, mut count) = (0, 0);
    while i < Covariate::COUNT {
        if matches!(Covariate::ALL[i].source(), Source::Columns) {
            found[count] = Covariate::ALL[i];
            count += 1;
        }
        i += 1;
    }
    found
};

const fn count_in_columns() -> usize {
    let (mut i, mut count) = (0, 0);
    while i < Covariate::COUNT {
        if matches!(Covariate::ALL[i].source(), Source::Columns) {
            count += 1;
        }
        i += 1;
    }
    count
}

/// The quantity that a channel measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Link position q, rad (m).
    LinkPosition,
    /// Deflection q - phi, rad (m).
    LinkDeflection,
    /// Motor position phi after the gearbox, rad (m).
    MotorPosition,
    /// Motor torque tau after the gearbox, N·m (N).
    MotorTorque,
    /// Target of a position servo, rad (m).
    MotorTarget,
    /// Whether the drive of a position servo is on, 1 or 0.
    DriveOn,
    /// Torque of the spring on the link, measured by a sensor in the joint, N·m (N).
    JointTorque,
    /// Reading of an axis of a sensor on the link of a joint, in the unit of [`Inertial::unit`].
    Inertial(Inertial, Axis),
    /// A quantity on which friction depends, in the unit of [`Covariate::unit`].
    Covariate(Covariate),
}

/// The place of a quantity in the equations of motion of its joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measures {
    /// The position `link · q + motor · phi`, rad (m). A quantity that measures the link has
    /// `link` = 1.
    Position {
        /// Factor of the link position.
        link: f64,
        /// Factor of the motor position.
        motor: f64,
    },
    /// The right-hand side of a row, N·m (N).
    RightHandSide(Row),
    /// The target of the motor position, rad (m).
    Target,
    /// Whether the drive is on.
    Switch,
    /// The motion of the link.
    Motion(Inertial, Axis),
    /// A quantity on which friction depends.
    Covariate(Covariate),
}

/// A row of the equations of motion of one joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Row {
    /// The link row of a flexible joint.
    Link,
    /// The row with the motor torque: the motor row of a flexible joint, the only row of a rigid
    /// joint.
    Motor,
    /// The row of a joint torque sensor: the torque of the spring.
    Spring,
}

/// A signal that samples have of a joint; one of several quantities gives it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// The link position, of flexible joints only; that of a rigid joint is the motor position.
    Link,
    /// The motor position.
    Motor,
    /// The motor torque.
    Torque,
    /// The target of the motor position; only a position servo has it.
    Target,
    /// Whether the drive is on; only a position servo has it.
    Switch,
    /// The torque of the spring, of flexible joints only.
    Spring,
    /// The reading of an axis of a sensor on the link, of flexible joints only.
    Inertial(Inertial, Axis),
    /// A covariate, of joints with friction that depends on it only.
    Covariate(Covariate),
}

/// Properties of a quantity for messages and equations.
struct Meaning {
    /// Its key in `[log]`, without unit.
    key: &'static str,
    measures: Measures,
    /// Likely cause if it never changes, as the beginning of a question.
    suspicion: &'static str,
}

impl Quantity {
    /// Returns all quantities, torques first.
    pub fn all() -> impl Iterator<Item = Self> {
        let of_joints = [
            Self::MotorTorque,
            Self::JointTorque,
            Self::LinkPosition,
            Self::MotorPosition,
            Self::LinkDeflection,
            Self::MotorTarget,
            Self::DriveOn,
        ];
        let of_links = (Inertial::ALL.into_iter())
            .flat_map(|sensor| Axis::ALL.map(|axis| Self::Inertial(sensor, axis)));
        let covariates = IN_COLUMNS.map(Self::Covariate);
        (of_joints.into_iter()).chain(of_links).chain(covariates)
    }

    /// Returns the quantity's row of the table.
    const fn meaning(self) -> Meaning {
        match self {
            Self::LinkPosition => Meaning {
                key: "link_position",
                measures: Measures::Position {
                    link: 1.0,
                    motor: 0.0,
                },
                suspicion: "is the link encoder connected",
            },
            Self::LinkDeflection => Meaning {
                key: "link_deflection",
                measures: Measures::Position {
                    link: 1.0,
                    motor: -1.0,
                },
                suspicion: "is the deflection sensor connected",
            },
            Self::MotorPosition => Meaning {
                key: "motor_position",
                measures: Measures::Position {
                    link: 0.0,
                    motor: 1.0,
                },
                suspicion: "is the motor encoder connected",
            },
            Self::MotorTorque => Meaning {
                key: "motor_torque",
                measures: Measures::RightHandSide(Row::Motor),
                suspicion: "is the current or torque recorded",
            },
            Self::MotorTarget => Meaning {
                key: "motor_target",
                measures: Measures::Target,
                suspicion: "is the target recorded",
            },
            Self::DriveOn => Meaning {
                key: "drive_on",
                measures: Measures::Switch,
                suspicion: "is the drive switched",
            },
            Self::JointTorque => Meaning {
                key: "joint_torque",
                measures: Measures::RightHandSide(Row::Spring),
                suspicion: "is the joint torque sensor connected",
            },
            Self::Inertial(sensor, axis) => Meaning {
                key: sensor.key(axis),
                measures: Measures::Motion(sensor, axis),
                suspicion: sensor.suspicion(),
            },
            Self::Covariate(covariate) => Meaning {
                key: covariate.word(),
                measures: Measures::Covariate(covariate),
                suspicion: "is it recorded",
            },
        }
    }

    /// Returns the name of its key in `[log]`, without unit.
    #[must_use]
    pub const fn key(self) -> &'static str {
        self.meaning().key
    }

    /// Returns its name in words.
    pub(crate) fn words(self) -> String {
        self.key().replace('_', " ")
    }

    /// Returns its place in the equations of motion.
    #[must_use]
    pub const fn measures(self) -> Measures {
        self.meaning().measures
    }

    /// Returns the likely cause if it never changes, as the beginning of a question.
    #[must_use]
    pub const fn suspicion(self) -> &'static str {
        self.meaning().suspicion
    }

    /// Returns whether it is a position or a difference of positions.
    #[must_use]
    pub const fn is_position(self) -> bool {
        matches!(self.measures(), Measures::Position { .. })
    }

    /// Returns whether it is a reading of a sensor of the link's motion.
    #[must_use]
    pub const fn is_inertial(self) -> bool {
        matches!(self, Self::Inertial(..))
    }

    /// Returns whether friction depends on it.
    #[must_use]
    pub const fn is_covariate(self) -> bool {
        matches!(self, Self::Covariate(_))
    }

    /// Returns the signal that it gives.
    #[must_use]
    pub fn signal(self) -> Signal {
        match self.measures() {
            Measures::Position { link, .. } if link != 0.0 => Signal::Link,
            Measures::Position { .. } => Signal::Motor,
            Measures::RightHandSide(Row::Spring) => Signal::Spring,
            Measures::RightHandSide(_) => Signal::Torque,
            Measures::Target => Signal::Target,
            Measures::Switch => Signal::Switch,
            Measures::Motion(sensor, axis) => Signal::Inertial(sensor, axis),
            Measures::Covariate(covariate) => Signal::Covariate(covariate),
        }
    }

    /// Returns its unit.
    ///
    /// - `turns`: whether the joint turns; otherwise it slides.
    #[must_use]
    pub const fn unit(self, turns: bool) -> &'static str {
        match self.measures() {
            Measures::Switch => return "",
            Measures::Motion(sensor, _) => return sensor.unit(),
            Measures::Covariate(covariate) => return covariate.unit(),
            Measures::Position { .. } | Measures::RightHandSide(_) | Measures::Target => {}
        }
        let is_position = !matches!(self.measures(), Measures::RightHandSide(_));
        match (is_position, turns) {
            (true, true) => "rad",
            (true, false) => "m",
            (false, true) => "N·m",
            (false, false) => "N",
        }
    }

    /// Returns the reading of an exact sensor, rad or N·m (m or N).
    ///
    /// - `q`, `phi`: link position and motor position of the joint.
    /// - `tau`, `spring`: torque of its motor, and of its spring on the link.
    /// - `motion`: reading of each axis of the sensor on the link, in its unit.
    /// - `covariate`: value of each covariate of the joint.
    #[must_use]
    pub fn shown(
        self,
        [q, phi]: [f64; 2],
        [tau, spring]: [f64; 2],
        motion: [f64; 3],
        covariate: impl Fn(Covariate) -> f64,
    ) -> f64 {
        match self.measures() {
            Measures::Position { link, motor } => link * q + motor * phi,
            Measures::RightHandSide(Row::Motor) => tau,
            Measures::RightHandSide(Row::Spring) => spring,
            Measures::RightHandSide(Row::Link) | Measures::Target | Measures::Switch => 0.0,
            Measures::Motion(_, axis) => motion[axis as usize],
            Measures::Covariate(measured) => covariate(measured),
        }
    }
}

impl Signal {
    /// Returns the signals of robots, in the order of their columns.
    pub fn all() -> impl Iterator<Item = Self> {
        let of_joints = [Self::Link, Self::Motor, Self::Torque, Self::Spring];
        let of_links = (Inertial::ALL.into_iter())
            .flat_map(|sensor| Axis::ALL.map(|axis| Self::Inertial(sensor, axis)));
        let covariates = IN_COLUMNS.map(Self::Covariate);
        (of_joints.into_iter()).chain(of_links).chain(covariates)
    }

    /// The signals of position servos, in the order of their columns.
    pub const OF_SERVO: [Self; 3] = [Self::Motor, Self::Target, Self::Switch];

    /// Returns whether only flexible joints have it.
    #[must_use]
    pub const fn is_of_flexible_joints(self) -> bool {
        matches!(self, Self::Link | Self::Spring | Self::Inertial(..))
    }

    /// Returns whether a joint cannot be identified without it.
    #[must_use]
    pub fn is_needed_by(self, joint: &Joint) -> bool {
        match self {
            Self::Link => joint.is_flexible(),
            Self::Motor | Self::Torque => true,
            Self::Target => joint.servo.is_some(),
            Self::Switch | Self::Spring | Self::Inertial(..) => false,
            Self::Covariate(covariate) => joint.depends_on(covariate),
        }
    }

    /// Returns its name for messages.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Link => "the link positions",
            Self::Motor => "the motor positions",
            Self::Torque => "the motor torques",
            Self::Target => "the targets",
            Self::Switch => "the states of the drives",
            Self::Spring => "the joint torques",
            Self::Inertial(sensor, axis) => sensor.reading(axis),
            Self::Covariate(covariate) => covariate.values(),
        }
    }

    /// Returns the keys that an error proposes if the log does not give the signal.
    #[must_use]
    pub const fn usual_keys(self, kind: JointKind) -> &'static str {
        match (self, kind) {
            (Self::Link, JointKind::Revolute) => "link_position_rad or link_deflection_rad",
            (Self::Link, JointKind::Prismatic) => "link_position_m",
            (Self::Motor, JointKind::Revolute) => "motor_position_rad",
            (Self::Motor, JointKind::Prismatic) => "motor_position_m",
            (Self::Torque, JointKind::Revolute) => {
                "motor_torque_nm, motor_current_a or drive_voltage_v"
            }
            (Self::Torque, JointKind::Prismatic) => "motor_force_n",
            (Self::Target, JointKind::Revolute) => "motor_target_rad",
            (Self::Target, JointKind::Prismatic) => "motor_target",
            (Self::Switch, _) => "drive_on",
            (Self::Spring, JointKind::Revolute) => "joint_torque_nm",
            (Self::Spring, JointKind::Prismatic) => "joint_force_n",
            (Self::Inertial(sensor, axis), _) => sensor.key_in_si(axis),
            (Self::Covariate(covariate), _) => covariate.key(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::table::KEYS;
    use super::*;

    #[test]
    fn every_quantity_and_every_signal_stands_in_its_list() {
        // A new variant has its place in this match, and then in the list.
        let place = |quantity: Quantity| match quantity {
            Quantity::MotorTorque => 0,
            Quantity::JointTorque => 1,
            Quantity::LinkPosition => 2,
            Quantity::MotorPosition => 3,
            Quantity::LinkDeflection => 4,
            Quantity::MotorTarget => 5,
            Quantity::DriveOn => 6,
            Quantity::Inertial(sensor, axis) => 7 + 3 * sensor as usize + axis as usize,
            Quantity::Covariate(covariate) => {
                let at = IN_COLUMNS.iter().position(|one| *one == covariate);
                7 + 3 * Inertial::ALL.len() + at.unwrap()
            }
        };
        for (i, quantity) in Quantity::all().enumerate() {
            assert_eq!(place(quantity), i);
        }
        let place = |signal: Signal| match signal {
            Signal::Link => 0,
            Signal::Motor => 1,
            Signal::Torque => 2,
            Signal::Spring => 3,
            Signal::Inertial(sensor, axis) => 4 + 3 * sensor as usize + axis as usize,
            Signal::Covariate(covariate) => {
                let at = IN_COLUMNS.iter().position(|one| *one == covariate);
                4 + 3 * Inertial::ALL.len() + at.unwrap()
            }
            // The signals of servos alone.
            Signal::Target | Signal::Switch => {
                assert!(Signal::OF_SERVO.contains(&signal));
                usize::MAX
            }
        };
        for (i, signal) in Signal::all().enumerate() {
            assert_eq!(place(signal), i);
        }
        // Each quantity gives a signal of one of the lists, under a key.
        for quantity in Quantity::all() {
            let signal = quantity.signal();
            assert!(
                Signal::all().any(|other| other == signal) || Signal::OF_SERVO.contains(&signal)
            );
            assert!(
                KEYS.iter().any(|key| key.quantity == quantity),
                "{quantity:?}"
            );
        }
    }

    #[test]
    fn readings_equal_the_measured_quantity_bit_for_bit() {
        let (q, phi, tau, spring) = (0.3, 0.1, 7.0, 5.0);
        let shown = |quantity: Quantity| {
            quantity
                .shown([q, phi], [tau, spring], [0.0; 3], |_| 30.0)
                .to_bits()
        };
        assert_eq!(shown(Quantity::LinkPosition), q.to_bits());
        assert_eq!(shown(Quantity::LinkDeflection), (q - phi).to_bits());
        assert_eq!(shown(Quantity::MotorPosition), phi.to_bits());
        assert_eq!(shown(Quantity::MotorTorque), tau.to_bits());
        assert_eq!(shown(Quantity::JointTorque), spring.to_bits());
    }
}
