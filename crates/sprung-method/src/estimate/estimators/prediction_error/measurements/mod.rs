//! Inputs of the filter from the logs: torques, and measurements of positions.
//!
//! An encoder gives little information between two counts and precise information at an encoder
//! edge, where its count changes: the position halfway between two samples, to a twentieth of a
//! count. The error of a raw count is not white noise, so a filter for white noise attributes this
//! error to disturbances.

mod align;
mod build;
mod encoder_edges;
mod measurement;
mod read;
mod segment;
mod segment_ranges;
mod sensor;
mod spring;
mod start_state;
mod torque;

pub(super) use build::{build, with_laws};
pub(super) use measurement::Measurement;
pub(super) use read::{Extent, MAX_SEARCH_WORK, RawSegment, max_samples, read, samples_in};
pub(super) use segment::{Measurements, Segment};
pub(super) use sensor::{Noise, Sensor, observe};
