//! The digital twin: plant, controller, sensors, amplifier.
//!
//! The plant is integrated with the columns of the regressor, so simulation and identification use
//! the same equations.

// The compiler names each place that must handle a new law, parameter, quantity or format.
#![warn(clippy::wildcard_enum_match_arm)]

mod closed_loop;
mod dynamics;
mod integrator;
mod plant;
mod record;
mod reference;
mod sensors;
mod twin;

pub(crate) use closed_loop::at_rest_in_springs;
pub use closed_loop::{ClosedLoop, Diverged, LoopError};
pub use dynamics::{Accelerations, BothTorques, Dynamics, RanAway};
pub use integrator::StepsExhausted;
pub use plant::JointState;
pub use record::{RecordError, record};
pub use reference::{Move, Trajectory};
pub use sensors::{Disturbance, Encoder};
pub use twin::{Twin, TwinSample, TwinSetup};
