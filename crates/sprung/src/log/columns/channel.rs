//! One column of a log as a measured quantity in SI units.

use super::origin::Origin;
use crate::description::{Delay, Quantity};

/// One column of a log.
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
    /// Delay relative to the other channels.
    pub delay: Option<Delay>,
    /// Whether the sign is estimated from the log; `factor` then assumes +1.
    pub open_sign: bool,
    /// Whether the gain is estimated from the log; `factor` then assumes 1.
    pub open_gain: bool,
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
}
