//! The measured quantities of a log: one table for reading, checking and templates.
//!
//! [`quantity`] says what each measures in the equations of motion; [`table`] has the keys of
//! `[log]` that name its columns.

mod quantity;
mod table;

pub(crate) use quantity::{Measures, Quantity, Row, Signal};
pub(crate) use table::{InTemplate, Joints, KEYS, Key, KeyUnit, Scaling};
