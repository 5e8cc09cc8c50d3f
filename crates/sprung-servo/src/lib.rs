//! A position servo on a pendulum: its parameters from logs of targets and positions, without any
//! torque.
//!
//! - `bench`: drive law, known loads and unknown parameters of an experiment;
//! - `record`: the samples of its logs;
//! - `window`: simulates short windows of a log, with derivatives;
//! - `start`: first values by linear least squares;
//! - `fit`: minimises the distance between simulated and logged positions;
//! - `identify`: the steps above, standard errors and findings;
//! - `expect`: the same before the fit;
//! - `findings`: findings about a result;
//! - `result`: the contents of `servo.json`;
//! - `twin`: simulates such logs.
//!
//! This crate is internal to `sprung`. Its items may change in any version; use the crate `sprung`, which re-exports the
//! public names.

// The compiler names each place that must handle a new law, parameter, quantity or format.
#![warn(clippy::wildcard_enum_match_arm)]

mod bench;
mod error;
mod findings;
mod fit;
mod identify;
mod information;
mod matrix;
mod record;
mod result;
mod start;
mod twin;
mod window;

use sprung_base::{finding, progress, stopwatch};
use sprung_log as log;
use sprung_method::simulate;
use sprung_robot as description;

pub use bench::Bench;
pub use error::ServoError;
pub use identify::identify;
pub use information::expect;
pub use record::{Records, read};
pub use result::{
    Scale, ServoEstimate, ServoExpectation, ServoFit, ServoIdentification, ServoLog,
    servo_parameters_csv,
};
pub use twin::{ServoTwin, named, record_servo, truth};
