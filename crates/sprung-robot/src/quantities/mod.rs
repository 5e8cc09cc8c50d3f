//! The measured quantities of a log: one table for reading, checking and templates.
//!
//! [`quantity`] gives the place of each quantity in the equations of motion; [`table`] gives the keys
//! of `[log]` for its columns.

mod quantity;
mod table;

pub use quantity::{Measures, Quantity, Row, Signal};
pub(crate) use table::{InTemplate, KEYS};
pub use table::{Joints, Key, KeyUnit, Scaling};
