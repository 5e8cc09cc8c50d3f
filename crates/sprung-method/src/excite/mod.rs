//! The design of experiments: motions within limits that determine the parameters best.

mod approach;
mod bounds;
mod certify;
mod design;
mod enclosure;
mod followed;
mod fourier;
mod information;
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
mod stability;
#[cfg(test)]
mod tests;

pub use approach::Approach;
pub use bounds::{Bounds, Interval, JointBounds, Limited};
pub use certify::{Broken, Kept, Simulation};
pub use design::{Designed, Frequencies, NoPose, Task, information, random, scales, value_of};
pub use fourier::Series;
pub use kinematics::{Kinematics, Places};
pub use noise::Errors;
pub use plan::{Loop, Plan, Refused, certify, missing_limit, plan};
pub use promise::{Information, add_cures, more, promise};
pub use stability::growth;
pub use result::{
    EXCITATION_FORMAT, Excitation, Excited, JointMotion, LimitUsed, More, MotionResult, Promised,
    SearchResult, Skeleton, Trajectory,
};
