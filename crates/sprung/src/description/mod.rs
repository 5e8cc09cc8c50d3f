//! What the user says: the robot, the log, how to identify and validate it.
//!
//! [`read`] turns the text of `experiment.toml` into an [`Experiment`] or an
//! error that names the line and what to do. Everything to the right of this
//! module can rely on the lengths and signs that [`read`] has checked.

mod check;
mod choice;
mod keys;
mod read;
mod types;

pub use read::{DescriptionError, Experiment, read, schema};
pub use types::{
    Controller, ControllerKind, Delay, DiscretizationName, Estimator, Feedforward, Identify, Joint,
    Kinematics, Log, Nominal, Reference, Robot, Side, Simulate, Sine, Validate,
};
