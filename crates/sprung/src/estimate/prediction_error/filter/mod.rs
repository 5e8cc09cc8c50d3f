//! The extended Kalman filter of a robot whose torques are disturbed, and the
//! derivatives of its innovations. NOTATION.md has its equations.
//!
//! State: coordinates, their velocities, and one disturbance per row, \[3 rows\]. A
//! disturbance is a torque with a first-order spectrum; logged torques are noisy
//! besides. Measurements are taken one by one, which needs no matrix to be
//! inverted.
//!
//! [`run`] is the filter, sample by sample: measure, accumulate, predict. [`replay`] is the
//! same with its gains held.

mod accumulate;
mod linearization;
mod measure;
mod predict;
mod replay;
mod run;
mod state;
#[cfg(test)]
mod tests;

pub(super) use accumulate::{NormalEquations, Sums};
pub(super) use linearization::{FilterRun, Trajectory};
pub(super) use replay::replay;
pub(super) use run::{Keep, run};
