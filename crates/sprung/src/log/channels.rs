//! Which columns hold what, and how they become SI units on the output side.

use crate::description::{Delay, Joint, Log, Robot, Side};

/// What a channel measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Link position q, rad.
    LinkPosition,
    /// Deflection q - phi, rad.
    LinkDeflection,
    /// Motor position phi after the gearbox, rad.
    MotorPosition,
    /// Motor torque tau after the gearbox, N·m.
    MotorTorque,
}

/// One column of a log.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Name of the column.
    pub column: String,
    /// What it measures.
    pub quantity: Quantity,
    /// Joint, from 0.
    pub joint: usize,
    /// The cell times this is the quantity in SI units.
    pub factor: f64,
    /// How much later than the others it was recorded.
    pub delay: Option<Delay>,
}

/// The channels of a log: links, motors and torques, joint by joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Channels {
    /// Name of the column of the time.
    pub time: String,
    /// The cell times this is the time in s.
    pub time_factor: f64,
    /// Link, motor and torque channels, n each.
    pub all: Vec<Channel>,
}

/// What a description leaves open about a log.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ChannelError {
    /// A quantity has no columns.
    #[error("[log] does not say which columns hold {what}; add {keys}")]
    NotSaid {
        /// The quantity.
        what: &'static str,
        /// The keys that say it.
        keys: &'static str,
    },
    /// Currents or voltages cannot become torques.
    #[error("{joint}: {key} is needed to turn the log's {unit} into motor torque")]
    NoConstant {
        /// Name of the joint.
        joint: String,
        /// The key that is missing.
        key: &'static str,
        /// What the log holds.
        unit: &'static str,
    },
}

impl Channels {
    /// Returns the channels that a description names.
    ///
    /// # Errors
    ///
    /// [`ChannelError`] if a quantity is not named or not convertible.
    pub fn new(robot: &Robot, log: &Log) -> Result<Self, ChannelError> {
        let (time, time_factor) = match (&log.time_s, &log.time_ms) {
            (Some(column), _) => (column.clone(), 1.0),
            (None, Some(column)) => (column.clone(), 1e-3),
            (None, None) => {
                return Err(ChannelError::NotSaid {
                    what: "the time",
                    keys: "time_s or time_ms",
                });
            }
        };
        let mut all = Vec::new();
        for (columns, quantity, factors) in
            [link(robot, log)?, motor(robot, log)?, torque(robot, log)?]
        {
            for (joint, (column, factor)) in columns.iter().zip(factors).enumerate() {
                let sign = log.sign.get(column).copied().unwrap_or(1.0);
                all.push(Channel {
                    column: column.clone(),
                    quantity,
                    joint,
                    factor: factor * sign,
                    delay: log.delay_s.get(column).copied(),
                });
            }
        }
        Ok(Self {
            time,
            time_factor,
            all,
        })
    }

    /// Returns the index in [`Channels::all`] of a joint's channel.
    #[must_use]
    pub fn index(&self, quantity: Quantity, joint: usize) -> Option<usize> {
        self.all
            .iter()
            .position(|c| c.quantity == quantity && c.joint == joint)
    }

    /// Returns the channels with the meanings of a joint's link and motor
    /// columns exchanged, for testing that suspicion; nothing if the link is
    /// logged as deflection. Blocks keep their order.
    #[must_use]
    pub fn exchanged(&self, joint: usize) -> Option<Self> {
        let link = self.index(Quantity::LinkPosition, joint)?;
        let motor = self.index(Quantity::MotorPosition, joint)?;
        let mut exchanged = self.clone();
        exchanged.all[link].quantity = Quantity::MotorPosition;
        exchanged.all[motor].quantity = Quantity::LinkPosition;
        Some(exchanged)
    }
}

/// Columns of a quantity, and the factor of each to SI units.
type Columns<'a> = (&'a [String], Quantity, Vec<f64>);

const DEGREE: f64 = std::f64::consts::PI / 180.0;

fn link<'a>(robot: &Robot, log: &'a Log) -> Result<Columns<'a>, ChannelError> {
    [
        (&log.link_position_rad, Quantity::LinkPosition, 1.0),
        (&log.link_position_deg, Quantity::LinkPosition, DEGREE),
        (&log.link_deflection_rad, Quantity::LinkDeflection, 1.0),
        (&log.link_deflection_deg, Quantity::LinkDeflection, DEGREE),
    ]
    .into_iter()
    .find_map(|(columns, quantity, unit)| {
        Some((columns.as_deref()?, quantity, vec![unit; robot.joint.len()]))
    })
    .ok_or(ChannelError::NotSaid {
        what: "the link positions",
        keys: "link_position_rad or link_deflection_rad",
    })
}

fn motor<'a>(robot: &Robot, log: &'a Log) -> Result<Columns<'a>, ChannelError> {
    let ratio = |joint: &Joint| match log.motor_position_side.unwrap_or_default() {
        Side::Output => 1.0,
        Side::Motor => joint.gear_ratio,
    };
    [
        (&log.motor_position_rad, 1.0),
        (&log.motor_position_deg, DEGREE),
    ]
    .into_iter()
    .find_map(|(columns, unit)| {
        let factors = robot
            .joint
            .iter()
            .map(|joint| unit / ratio(joint))
            .collect();
        Some((columns.as_deref()?, Quantity::MotorPosition, factors))
    })
    .ok_or(ChannelError::NotSaid {
        what: "the motor positions",
        keys: "motor_position_rad",
    })
}

fn torque<'a>(robot: &Robot, log: &'a Log) -> Result<Columns<'a>, ChannelError> {
    let converted = |unit, factor: fn(&Joint) -> Option<f64>| {
        (robot.joint.iter())
            .map(|joint| {
                factor(joint).ok_or_else(|| ChannelError::NoConstant {
                    joint: joint.name.clone(),
                    key: match joint.torque_constant_nm_per_a {
                        None => "torque_constant_nm_per_a",
                        Some(_) => "amplifier_gain_a_per_v",
                    },
                    unit,
                })
            })
            .collect::<Result<Vec<f64>, ChannelError>>()
    };
    let (columns, factors) = if let Some(columns) = &log.motor_torque_nm {
        (columns, vec![1.0; robot.joint.len()])
    } else if let Some(columns) = &log.motor_current_a {
        (columns, converted("currents", Joint::torque_per_ampere)?)
    } else if let Some(columns) = &log.drive_voltage_v {
        (columns, converted("voltages", Joint::torque_per_volt)?)
    } else {
        return Err(ChannelError::NotSaid {
            what: "the motor torques",
            keys: "motor_torque_nm, motor_current_a or drive_voltage_v",
        });
    };
    Ok((columns, Quantity::MotorTorque, factors))
}
