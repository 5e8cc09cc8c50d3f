//! The extended Kalman filter of a robot with disturbed torques, and the derivatives of its
//! innovations. NOTATION.md contains the equations.
//!
//! State: coordinates, their velocities, and one disturbance per row, \[3 rows\]. A disturbance is
//! a torque with a first-order spectrum. In addition the logged torques have white noise. The
//! filter processes measurements one by one, so it inverts no matrix.
//!
//! [`run`] processes the samples in order: measure, accumulate, predict. [`replay`] does the same
//! with the gains of a run.

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
pub(super) use linearization::{FilterRun, SegmentRun, Trajectory};
pub(super) use replay::replay;
pub(super) use run::{Keep, run};
