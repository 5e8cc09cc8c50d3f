//! The motion of the robot over one sampling period, and its derivatives.
//!
//! State: the coordinates of all rows, then their velocities, \[2 rows\]. Inputs: one torque per
//! row, held during the period.

mod motion;
mod runge_kutta;
mod step_size;
mod tangent;

pub(super) use motion::Dynamics;
pub(super) use tangent::Tangent;
