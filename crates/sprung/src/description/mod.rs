//! What the user says: the robot, the log, how to identify and validate it.
//!
//! [`read`] turns the text of `experiment.toml` into an [`Experiment`] or an
//! error that names the line and what to do. Everything to the right of this
//! module can rely on the lengths and signs that [`read`] has checked.

mod check;
mod choice;
mod identify;
mod keys;
mod log;
mod read;
mod robot;
mod run;
mod types;

pub use identify::{DiscretizationName, Estimator, Identify};
pub use log::{Delay, Log};
pub use read::{DescriptionError, Experiment, read, schema};
pub use robot::{Joint, Kinematics, Nominal, Robot, Side};
pub use run::{Controller, ControllerKind, Feedforward, Reference, Simulate, Sine, Validate};
