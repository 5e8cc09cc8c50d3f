//! Watches a running robot with its identified model: torques from outside, changes, and sensors that show nothing.
//!
//! The residuals of the equations of motion along a log are torques from outside ([`sprung_core::observer`]). Healthy logs
//! show how far they scatter in each state, and how often they exceed a threshold.

mod blind;
mod changes;
mod contact;
mod events;
mod learn;
mod monitor;
mod observer;
mod residual;
mod result;
mod run;
mod squares;
mod walk;

pub use observer::{ObservedJoint, ObserverSettings, TorqueObserver};
pub use result::{Watch, WatchEvent, WatchedJoint, WatchedLog};
pub use run::{WatchTask, Watched, watch};
