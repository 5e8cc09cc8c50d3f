//! The design of experiments: motions within limits that determine the parameters best.

mod bounds;
mod design;
mod followed;
mod fourier;
mod information;
mod kinematics;
mod motion;
mod noise;
mod objective;
mod physics;
mod problem;
mod search;
mod simulated;
#[cfg(test)]
mod tests;

pub use bounds::{Bounds, Interval, JointBounds, Limited};
pub use design::{Designed, Frequencies, NoPose, Task, design, information, scales, value_of};
pub use fourier::Series;
pub use kinematics::{Kinematics, Places};
pub use noise::Errors;
