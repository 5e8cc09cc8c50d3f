//! One column of a log as a measured quantity in SI units.

use super::origin::Origin;
use crate::description::{Delay, Quantity};

/// One column of a log.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Name of the column for messages, and as a key of `delay_s`, `sign` and `gain`.
    pub column: String,
    /// Where its readings come from.
    pub origin: Origin,
    /// What it measures.
    pub quantity: Quantity,
    /// Joint, from 0.
    pub joint: usize,
    /// The reading times this is the quantity in SI units.
    pub factor: f64,
    /// How much later than the others it was recorded.
    pub delay: Option<Delay>,
    /// Whether its sign is to be found from the log; `factor` has it positive.
    pub open_sign: bool,
    /// Whether its gain is to be found from the log; `factor` has it 1.
    pub open_gain: bool,
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
