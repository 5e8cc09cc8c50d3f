//! The design of experiments: motions within limits that determine the parameters best.

mod approach;
mod assemble;
mod bounds;
mod certify;
mod checked_loop;
mod design;
mod enclosure;
mod followed;
mod follows;
mod fourier;
mod information;
mod information_matrix;
mod kept;
mod kinematics;
mod motion;
mod noise;
mod objective;
mod physics;
mod plan;
mod problem;
mod promise;
mod result;
mod search;
mod simulated;
mod starts;
mod task;
#[cfg(test)]
mod tests;

pub use approach::Approach;
pub use bounds::{Bounds, Interval, JointBounds, Limited};
pub use checked_loop::Simulation;
pub use design::{Designed, information, value_of};
pub use fourier::Series;
pub use information_matrix::Information;
pub use kept::{Broken, Kept};
pub use kinematics::{Kinematics, Places};
pub use noise::Errors;
pub use plan::{Certificate, Loop, Plan, Refused, certify, missing_limit, plan};
pub use promise::{add_cures, more, promise};
pub use result::{
    EXCITATION_FORMAT, Excitation, Excited, JointMotion, LimitUsed, More, MotionResult, Promised,
    SearchResult, Skeleton, Trajectory,
};
pub use starts::{NoPose, random};
pub use task::{Frequencies, Task, scales};
