//! The experiment file: the robot, the log, and the settings of identification and validation.
//!
//! [`read`] turns the text of `experiment.toml` into an [`Experiment`], or into an error that names
//! the line and the remedy. It checks lengths and signs, so all later stages can rely on them.
//!
//! This crate is internal to `sprung`. Its items may change in any version; use the crate `sprung`, which re-exports the
//! public names.

// The compiler names each place that must handle a new law, parameter, quantity or format.
#![warn(clippy::wildcard_enum_match_arm)]

mod capabilities;
mod check;
mod columns;
mod completed;
mod control;
mod covariates;
mod defaults;
mod delays;
mod excite;
mod factor;
mod friction;
mod friction_covariates;
mod identify;
mod inertial;
mod instruments;
mod keys;
mod known_words;
mod limits;
mod log;
mod log_quantities;
mod named_files;
mod nominal;
mod overlay;
mod payload;
mod physical;
mod quantities;
mod read;
mod reference;
mod robot;
mod run;
mod servo;
mod template;
mod torque_hold;
mod tree;
mod types;
mod unfilled;
mod units;
mod urdf;
mod window;

use sprung_base::{ellipsoid, foreign, limits as input_limits, numbers};

pub use capabilities::{Feature, Task, refuse, refuse_task};
pub use capabilities::{Language, NotSupported, OwnCall, refusals, what_works};
pub use columns::{Column, ColumnName, Columns, PerJoint, StartsAt};
pub use control::{Control, Feedback};
pub use covariates::{CovariateColumns, Drifts};
pub use delays::DelaysOfLog;
pub use excite::{Excite, MOST_SAMPLES, Objective};
pub use factor::{Delay, Factor};
pub use friction::FrictionLaw;
pub use friction_covariates::FrictionCovariates;
pub use identify::{
    Constraints, Cutoff, DiscretizationName, EncoderOffset, Estimator, Identify, Laws,
    OnCheckError, StartName, Weights,
};
pub use inertial::{Axis, Inertial, InertialFinding};
pub use instruments::{
    Instrument, Instrumentation, LinkPosition, RightHandSide, RowFilter, SpringTorque,
};
pub use limits::Limits;
pub use log::{CsvForm, Log, MissingValues, SamplingTimes, WrongSamples};
pub use named_files::{NamedFiles, no_files};
pub use nominal::Nominal;
pub use payload::Payload;
pub use physical::{Distance, Physical, Prior};
pub use quantities::Quantity;
pub use quantities::{Joints, Key, KeyUnit, Scaling};
pub use quantities::{Measures, Row, Signal};
pub use read::{DescriptionError, Experiment, read, schema};
pub use reference::read_reference;
pub use robot::{DhJoint, Joint, Kinematics, Robot, Seen, Side, SpringTerm, Transmission, Tree};
pub use run::{Controller, ControllerKind, Feedforward, Reference, Simulate, Sine, Validate};
pub use servo::ServoDrive;
pub use template::{Chosen, ChosenJoint, ChosenLine, JointOfStart, quoted};
pub use template::{Start, StartError, template};
pub use torque_hold::{TorqueHold, TorqueReading};
pub use unfilled::FILL_IN;
pub use units::Dimension;
pub use units::Unit;
pub use urdf::{NoShape, Shape, TreeJoint, Urdf, UrdfError, UrdfJoint};
pub use window::{FilePart, Window};
