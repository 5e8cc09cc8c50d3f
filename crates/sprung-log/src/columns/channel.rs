//! One column of a log as a measured quantity in SI units.

use super::origin::Origin;
use crate::description::{Delay, Quantity};

/// One column of a log.
#[expect(
    clippy::struct_excessive_bools,
    reason = "three are independent questions that the description leaves open"
)]
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Name of the column for messages, and as a key of `delay_s`, `sign` and `gain`.
    pub column: String,
    /// Source of its readings.
    pub origin: Origin,
    /// Measured quantity.
    pub quantity: Quantity,
    /// Index of the joint, from 0.
    pub joint: usize,
    /// Factor from the reading to the quantity in SI units.
    pub factor: f64,
    /// Gear ratio of the joint, if the description gives it.
    pub gear_ratio: Option<f64>,
    /// Whether the readings were taken before the gearbox, so that `factor` contains the gear ratio.
    pub before_gear: bool,
    /// Counts of the encoder per turn, if the readings are counts.
    pub counts_per_turn: Option<f64>,
    /// Delay relative to the other channels.
    pub delay: Option<Delay>,
    /// Whether the sign is estimated from the log; `factor` then assumes +1.
    pub open_sign: bool,
    /// Whether the gain is estimated from the log; `factor` then assumes 1.
    pub open_gain: bool,
    /// Whether the side of the gearbox of its torque constant is found from the log; `factor` then assumes the output.
    pub open_side: bool,
}

/// Largest relative difference of two factors that are the same except for rounding and a gain.
const SAME_FACTOR: f64 = 0.5;

impl Channel {
    /// Returns the factor from the reading to the quantity on the side where it was taken, without
    /// sign.
    fn unit(&self) -> f64 {
        let gear = match (self.before_gear, self.gear_ratio) {
            (true, Some(ratio)) => ratio,
            _ => 1.0,
        };
        (self.factor * gear).abs()
    }

    /// Returns whether its readings are declared as radians.
    #[must_use]
    pub fn is_in_radians(&self) -> bool {
        self.counts_per_turn.is_none() && (self.unit() - 1.0).abs() < SAME_FACTOR
    }

    /// Returns whether its readings are declared as degrees.
    #[must_use]
    pub fn is_in_degrees(&self) -> bool {
        let in_degrees = self.unit().to_degrees();
        self.counts_per_turn.is_none() && (in_degrees - 1.0).abs() < SAME_FACTOR
    }
}

/// Information that the description lacks about a log.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ChannelError {
    /// The description names no columns for a quantity.
    #[error("[log] does not say which columns hold {what}; add {keys}")]
    NotSaid {
        /// The quantity.
        what: &'static str,
        /// The keys that name its columns.
        keys: &'static str,
    },
    /// A flexible joint has no link position.
    #[error(
        "[log] has no link position of {joint}; add {line} to [log], or link_deflection for a sensor of the \
         deflection, or joint_torque_nm for a torque sensor in the joint; with motor encoder only write \
         transmission = \"rigid\" in the [[robot.joint]] block of {joint}: motor and link then are one body, and \
         springs_from_motor = true in [identify] finds the spring of a robot without link encoders from its \
         vibrations"
    )]
    NoLink {
        /// Name of the joint.
        joint: String,
        /// A line for its position, in the form of the other lines of the log.
        line: String,
    },
    /// A joint that turns below a sensor of motion has no such sensor on its link.
    #[error(
        "the {sensor} on the link of {joint} also measures the motion of {below}, whose link has no \
         {sensor}; sprung needs one on the link of every joint that turns below"
    )]
    NoSensorBelow {
        /// Name of the sensor.
        sensor: &'static str,
        /// Name of the joint.
        joint: String,
        /// Name of the joint below.
        below: String,
    },
    /// A sensor of motion does not suit the robot.
    #[error("the {sensor} of {joint} {reason}")]
    Unsuited {
        /// Name of the sensor.
        sensor: &'static str,
        /// Name of the joint.
        joint: String,
        /// The fault and its remedy.
        reason: &'static str,
    },
    /// A constant for the conversion of currents or voltages to torques is missing.
    #[error("{joint}: {key} is needed to turn the log's {unit} into motor torque")]
    NoConstant {
        /// Name of the joint.
        joint: String,
        /// The key that is missing.
        key: &'static str,
        /// The logged quantity: currents or voltages.
        unit: &'static str,
    },
    /// The side of the gearbox of a torque constant is open, and no identification determined it.
    #[error(
        "{joint}: the gear ratio is not 1, and the side of torque_constant_nm_per_a is not given; add \
         torque_constant_side = \"output\" if the constant contains the gear ratio, or \"motor\", to [robot.joint_defaults]"
    )]
    OpenSide {
        /// Name of the joint.
        joint: String,
    },
    /// The delays of all channels of a joint are to be estimated.
    #[error(
        "delay_s asks to estimate all channels of {joint}; only delays between channels show in a log, so leave one of \
         them out, or write delay_s = \"estimate\", which keeps the motor positions"
    )]
    NoReference {
        /// Name of the joint.
        joint: String,
    },
}
