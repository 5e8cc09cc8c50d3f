//! The motion of the robot over one sampling period, and its derivatives.
//!
//! State: the coordinates of all rows, then their velocities, \[2 rows\]. Inputs: one torque per
//! row, held during the period.

mod motion;
mod runge_kutta;
mod step_size;
mod tangent;
mod torque_pulse;

pub(super) use motion::{Dynamics, ScaleOfJoint};
#[cfg(test)]
pub(super) use step_size::Steps;
pub(super) use tangent::{ScalePlace, Tangent};
pub(super) use torque_pulse::Pulse;
