//! The digital twin: plant, controller, sensors, amplifier.
//!
//! The plant is integrated by the columns of the regressor, so a simulated log
//! and an identified model speak of the same equations.

mod integrator;
mod reference;
mod sensors;
mod twin;
mod closed_loop;

pub use closed_loop::{ClosedLoop, Diverged, LoopError};
pub use integrator::{Integrator, StepsExhausted};
pub use reference::Trajectory;
pub use twin::{Twin, TwinSample};
