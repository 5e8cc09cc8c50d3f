//! Springs that a log does not determine: lower bounds of their stiffness, and the model without them.
//!
//! The estimate of such a stiffness is the ratio of a torque and a deflection with only noise, so it is arbitrary. If
//! the link rows have no right-hand side, the link parameters shrink with it. The compliance is not biased: noise of
//! the deflection is on its right-hand side. If it is not significant, the joint is taken as rigid.
//!
//! If a log has joint torques and no motor torques, the springs follow from deflections and joint torques alone (`sensed`).

mod compliance;
mod rigid;
mod rigid_finding;
mod sensed;
mod undetermined;

pub use rigid::with_rigid_joints;
pub(super) use rigid::{RigidByLog, with_joints_rigid_by_log};
pub(super) use rigid_finding::finding;
pub(super) use sensed::Sensed;
pub(super) use undetermined::Undetermined;
