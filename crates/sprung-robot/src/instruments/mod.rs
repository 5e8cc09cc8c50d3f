//! The instruments of each joint: the signals of its log, and their consequences.
//!
//! [`Instrument`] is one value per joint. The stages ask it for properties: where the link position comes
//! from, which rows the regression has and their right-hand sides, and the filter of the rows. [`Inertial`](crate::Inertial)
//! has the properties of the sensors on links: their columns, settings, errors and units.

mod instrument;
mod right_hand_side;

pub use instrument::{Instrument, Instrumentation, LinkPosition, RowFilter, SpringTorque};
pub use right_hand_side::RightHandSide;
