//! The experiment file: the robot, the log, and the settings of identification and validation.
//!
//! [`read`] turns the text of `experiment.toml` into an [`Experiment`], or into an error that names
//! the line and the remedy. It checks lengths and signs, so all later stages can rely on them.

mod check;
mod choice;
mod columns;
mod factor;
mod friction;
mod given;
mod identify;
mod keys;
mod log;
mod nominal;
mod overlay;
mod payload;
mod physical;
mod quantities;
mod read;
mod robot;
mod run;
mod servo;
mod template;
mod tree;
mod types;
mod unfilled;
mod units;
mod urdf;
mod window;

pub use columns::{Column, ColumnName, Columns, PerJoint, StartsAt};
pub use factor::{Delay, Factor};
pub use friction::FrictionLaw;
pub(crate) use given::TorqueSensor;
pub use identify::{
    Cutoff, DiscretizationName, EncoderOffset, Estimator, Identify, InitialMomentum, Instruments,
    Laws, OnCheckError, StartName, Weights,
};
pub(crate) use log::GYROSCOPE_CORNER_HZ;
pub use log::{CsvForm, Log, MissingValues, SamplingTimes};
pub use nominal::Nominal;
pub use payload::Payload;
pub use physical::{Distance, Physical, Prior};
pub(crate) use quantities::{Axis, Quantity};
pub(crate) use quantities::{Joints, Key, KeyUnit, Scaling};
pub(crate) use quantities::{Measures, Row, Signal};
pub use read::{DescriptionError, Experiment, no_files, read, schema};
pub use robot::{
    DhJoint, FrictionCovariates, Joint, Kinematics, Robot, Side, SpringTerm, Transmission, Tree,
};
pub use run::{Controller, ControllerKind, Feedforward, Reference, Simulate, Sine, Validate};
pub use servo::ServoDrive;
pub(crate) use template::{Chosen, ChosenJoint, ChosenLine, JointOfStart, quoted};
pub use template::{Start, StartError, template};
pub use unfilled::FILL_IN;
pub(crate) use units::Dimension;
pub use units::Unit;
pub use urdf::{TreeJoint, Urdf, UrdfError, UrdfJoint};
pub use window::{FilePart, Window};
