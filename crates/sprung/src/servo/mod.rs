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
//! - `findings`: what the user must know about a result;
//! - `result`: the contents of `servo.json`;
//! - `twin`: simulates such logs.

mod bench;
mod error;
mod expect;
mod findings;
mod fit;
mod identify;
mod matrix;
mod record;
mod result;
mod start;
mod twin;
mod window;

pub(crate) use bench::Bench;
pub use error::ServoError;
pub(crate) use expect::expect;
pub(crate) use identify::identify;
pub(crate) use record::read;
pub use result::{
    Scale, ServoEstimate, ServoExpectation, ServoFit, ServoIdentification, ServoLog,
    servo_parameters_csv,
};
pub(crate) use twin::{ServoTwin, record_servo, truth};
