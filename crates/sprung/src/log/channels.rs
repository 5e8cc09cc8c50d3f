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
    /// Name of the column of the time, s.
    pub time: String,
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
    /// - `overlay`: a log whose keys, where given, replace those of `log`.
    ///
    /// # Errors
    ///
    /// [`ChannelError`] if a quantity is not named or not convertible.
    ///
    /// # Source
    ///
    /// Eqs. (3) to (5) for currents and voltages; the paper's `K_m` does not
    /// say its side of the gearbox, `torque_constant_side` does.
    pub fn new(robot: &Robot, log: &Log, overlay: Option<&Log>) -> Result<Self, ChannelError> {
        let pick = |get: fn(&Log) -> &Option<Vec<String>>| {
            overlay.and_then(|o| get(o).as_ref()).or(get(log).as_ref())
        };
        let degree = std::f64::consts::PI / 180.0;
        let drive = |unit, with_voltage: bool| {
            robot
                .joint
                .iter()
                .map(|joint| {
                    let missing = |key| ChannelError::NoConstant {
                        joint: joint.name.clone(),
                        key,
                        unit,
                    };
                    let constant = joint
                        .torque_constant_nm_per_a
                        .ok_or_else(|| missing("torque_constant_nm_per_a"))?;
                    let ratio = match joint.torque_constant_side {
                        Side::Output => 1.0,
                        Side::Motor => joint.gear_ratio,
                    };
                    let gain = if with_voltage {
                        joint
                            .amplifier_gain_a_per_v
                            .ok_or_else(|| missing("amplifier_gain_a_per_v"))?
                    } else {
                        1.0
                    };
                    Ok(ratio * constant * gain)
                })
                .collect::<Result<Vec<f64>, ChannelError>>()
        };
        let same = |factor: f64| vec![factor; robot.joint.len()];
        let motor_side = overlay
            .and_then(|o| o.motor_position_side)
            .or(log.motor_position_side)
            .unwrap_or_default();
        let motor_factors = |unit: f64| -> Vec<f64> {
            let ratio = |joint: &Joint| match motor_side {
                Side::Output => 1.0,
                Side::Motor => joint.gear_ratio,
            };
            robot
                .joint
                .iter()
                .map(|joint| unit / ratio(joint))
                .collect()
        };

        let link = first([
            (pick(|l| &l.link_position_rad), Quantity::LinkPosition, 1.0),
            (
                pick(|l| &l.link_position_deg),
                Quantity::LinkPosition,
                degree,
            ),
            (
                pick(|l| &l.link_deflection_rad),
                Quantity::LinkDeflection,
                1.0,
            ),
            (
                pick(|l| &l.link_deflection_deg),
                Quantity::LinkDeflection,
                degree,
            ),
        ])
        .ok_or(ChannelError::NotSaid {
            what: "the link positions",
            keys: "link_position_rad or link_deflection_rad",
        })?;
        let motor = first([
            (
                pick(|l| &l.motor_position_rad),
                Quantity::MotorPosition,
                1.0,
            ),
            (
                pick(|l| &l.motor_position_deg),
                Quantity::MotorPosition,
                degree,
            ),
        ])
        .ok_or(ChannelError::NotSaid {
            what: "the motor positions",
            keys: "motor_position_rad",
        })?;
        let (torque, torque_factors) = if let Some(columns) = pick(|l| &l.motor_torque_nm) {
            (columns, same(1.0))
        } else if let Some(columns) = pick(|l| &l.motor_current_a) {
            (columns, drive("currents", false)?)
        } else if let Some(columns) = pick(|l| &l.drive_voltage_v) {
            (columns, drive("voltages", true)?)
        } else {
            return Err(ChannelError::NotSaid {
                what: "the motor torques",
                keys: "motor_torque_nm, motor_current_a or drive_voltage_v",
            });
        };

        let setting = |column: &str| {
            let find = |l: &Log| (l.sign.get(column).copied(), l.delay_s.get(column).copied());
            let (sign, delay) = find(log);
            let (over_sign, over_delay) = overlay.map_or((None, None), find);
            (over_sign.or(sign).unwrap_or(1.0), over_delay.or(delay))
        };
        let mut all = Vec::new();
        for (columns, quantity, factors) in [
            (link.0, link.1, same(link.2)),
            (motor.0, motor.1, motor_factors(motor.2)),
            (torque, Quantity::MotorTorque, torque_factors),
        ] {
            for (joint, (column, factor)) in columns.iter().zip(factors).enumerate() {
                let (sign, delay) = setting(column);
                all.push(Channel {
                    column: column.clone(),
                    quantity,
                    joint,
                    factor: factor * sign,
                    delay,
                });
            }
        }
        let time = overlay
            .and_then(|o| o.time_s.clone())
            .or_else(|| log.time_s.clone())
            .ok_or(ChannelError::NotSaid {
                what: "the time",
                keys: "time_s",
            })?;
        Ok(Self { time, all })
    }

    /// Returns the index in [`Channels::all`] of a joint's channel.
    #[must_use]
    pub fn index(&self, quantity: Quantity, joint: usize) -> Option<usize> {
        self.all
            .iter()
            .position(|c| c.quantity == quantity && c.joint == joint)
    }

    /// Returns the channels with link and motor columns of a joint exchanged,
    /// for testing that suspicion; nothing if the link is logged as deflection.
    #[must_use]
    pub fn swapped(&self, joint: usize) -> Option<Self> {
        let link = self.index(Quantity::LinkPosition, joint)?;
        let motor = self.index(Quantity::MotorPosition, joint)?;
        let mut swapped = self.clone();
        let (a, b) = (self.all[link].clone(), self.all[motor].clone());
        swapped.all[link] = Channel {
            quantity: Quantity::LinkPosition,
            ..b
        };
        swapped.all[motor] = Channel {
            quantity: Quantity::MotorPosition,
            ..a
        };
        Some(swapped)
    }
}

type Choice<'a> = (Option<&'a Vec<String>>, Quantity, f64);

fn first<const N: usize>(choices: [Choice<'_>; N]) -> Option<(&Vec<String>, Quantity, f64)> {
    choices
        .into_iter()
        .find_map(|(columns, quantity, factor)| Some((columns?, quantity, factor)))
}
