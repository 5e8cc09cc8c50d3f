//! The equations of a robot at rest in a pose.

use sprung_core::parameters::{JointParameter, Side};

use super::linear::{Linear, Pose};
use crate::model::{Model, Theta};
use crate::simulate::{JointState, at_rest_in_springs};

/// Velocity at which friction is linearised, rad/s (m/s). It is beyond the transition of Coulomb friction, so Coulomb
/// friction adds no damping.
const MOVING: f64 = 1.0;

/// Returns the equations about rest in a pose; `None` if no robot can have the values.
///
/// - `q`: link positions, \[n\], rad (m).
#[must_use]
pub(super) fn linear(model: &Model, theta: &[f64], q: &[f64]) -> Option<Linear> {
    let rest = at_rest_in_springs(model, &Theta::from(theta), q).ok()?;
    let pose = Pose {
        q: rest.q,
        phi: rest.phi,
    };
    Linear::new(model, theta, &viscous(model), &pose)
}

/// Returns the viscous friction of each term per unit of its parameter; zero for other terms. \[terms\]
fn viscous(model: &Model) -> Vec<f64> {
    let (n, robot) = (model.joint_count(), model.robot());
    let (still, moving) = (vec![0.0; n], vec![MOVING; n]);
    let state = JointState {
        q: still.clone(),
        dq: moving.clone(),
        phi: still,
        dphi: moving,
    };
    let slope = |term: &sprung_core::drives::Term| {
        let drive = robot.drive(&state.view(), term.joint);
        let slopes = term.slopes(&drive, &robot.shapes[term.joint]);
        let JointParameter::Friction(side, _) = term.what else {
            return 0.0;
        };
        match side {
            Side::Link => slopes.link_velocity,
            Side::Motor => slopes.motor_velocity,
        }
    };
    robot.terms.iter().map(slope).collect()
}
