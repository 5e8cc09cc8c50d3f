//! What the filter sees of logs: torques, and measurements of positions.
//!
//! An encoder says little between two counts and much at an edge, where its count
//! changes: the position halfway between two samples, to a twentieth of a count. A raw
//! count is not a position with white noise, and a filter that takes it for one finds
//! disturbances that are not there.

mod align;
mod build;
mod deviation;
mod encoder_edges;
mod measurement;
mod read;
mod segment;
mod sensor;
mod start_state;
mod torque;

pub(super) use build::build;
pub(super) use measurement::Measurement;
pub(super) use read::{max_samples, read};
pub(super) use segment::{Measurements, Segment};
pub(super) use sensor::{Noise, Sensor, observe};
