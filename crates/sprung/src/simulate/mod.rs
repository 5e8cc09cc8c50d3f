//! The digital twin: plant, controller, sensors, amplifier.
//!
//! The plant is integrated with the columns of the regressor, so simulation and identification use
//! the same equations.

mod closed_loop;
mod dynamics;
mod integrator;
mod plant;
mod record;
mod reference;
mod sensors;
mod subsystems;
mod twin;

pub use closed_loop::{ClosedLoop, Diverged, LoopError};
pub use dynamics::{Accelerations, BothTorques, Dynamics, RanAway};
pub use integrator::StepsExhausted;
pub use plant::JointState;
pub use record::{RecordError, record};
pub(crate) use reference::Trajectory;
pub(crate) use sensors::{Disturbance, Encoder};
pub use subsystems::{Measured, Positions, subsystems};
pub use twin::{Twin, TwinSample, TwinSetup};
