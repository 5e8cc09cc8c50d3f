//! The measured quantities of a log: one table for reading, checking and templates.
//!
//! [`quantity`] gives the place of each quantity in the equations of motion; [`table`] gives the keys
//! of `[log]` for its columns.

mod quantity;
mod table;

pub(crate) use quantity::{Axis, Measures, Quantity, Row, Signal};
pub(crate) use table::{InTemplate, Joints, KEYS, Key, KeyUnit, Scaling};
