//! Writes an identified robot for simulators and controllers, and proves the file by reading it back.
//!
//! `export()` takes named values and returns the text of a file. It reads the text again with a reader that shares no
//! code with the writer, and compares its dynamics with those of the identified model at random states.
//!
//! This crate is internal to `sprung`. Its items may change in any version; use the crate `sprung`, which re-exports the
//! public names.

// The compiler names each place that must handle a new law, parameter, quantity or format.
#![warn(clippy::wildcard_enum_match_arm)]

mod code;
mod controller;
mod error;
mod evidence;
mod exactness;
mod format;
mod json;
mod mechanism;
mod mjcf;
mod mujoco;
mod names;
mod principal;
mod provenance;
mod read_json;
mod read_mjcf;
mod read_sdf;
mod read_urdf;
mod reload;
mod robot;
mod sdf;
mod standard;
mod urdf;
mod write;

#[cfg(test)]
mod tests;

use sprung_base::{finding, numbers, sha256};
use sprung_model as model;
use sprung_robot as description;

pub use controller::{ControlCode, ObserverCode};
pub use error::ExportError;
pub use evidence::{JointEvidence, Known};
pub use exactness::{How, Said};
pub use format::Format;
pub use mujoco::{MujocoFields, MujocoNames, mujoco};
pub use provenance::{DrawOrigin, Earlier, LogOrigin, Origin, ValueOrigin, earlier};
pub use reload::Proof;
pub use robot::Form;
pub use write::Exported;
pub use write::{Request, export};
