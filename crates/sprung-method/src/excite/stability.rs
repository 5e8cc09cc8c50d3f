//! Stability of a closed loop about rest.

use faer::Mat;

use super::noise::{MOVING, mean_mass, slopes_at};
use crate::description::Controller;
use crate::model::Model;

/// Growth that counts as instability, part of the largest rate of the loop.
const GROWS: f64 = 1e-6;

/// Returns the rate of growth of the least stable motion of PD control on the motors about a pose, 1/s; `None` if the loop
/// is stable. Coulomb friction, gravity and sampling do not count.
///
/// - `q`: the pose, \[n\], rad (m).
#[must_use]
pub fn growth(model: &Model, theta: &[f64], controller: &Controller, q: &[f64]) -> Option<f64> {
    let rows = model.coordinates();
    let masses = mean_mass(model, theta, &[q.to_vec()]);
    let [mut stiffness, mut damping] = slopes_at(model, theta, MOVING);
    for joint in 0..model.joint_count() {
        let motor = model.torque_row(joint);
        stiffness[(motor, motor)] += controller.kp_nm_per_rad[joint];
        damping[(motor, motor)] += controller.kd_nms_per_rad[joint];
    }
    let inverse = super::objective::inverse(&masses)?;
    let [by_position, by_velocity] = [stiffness, damping].map(|own| &inverse * own);
    let state = Mat::from_fn(2 * rows, 2 * rows, |i, j| match (i < rows, j < rows) {
        (true, _) => f64::from(u8::from(j == i + rows)),
        (false, true) => -by_position[(i - rows, j)],
        (false, false) => -by_velocity[(i - rows, j - rows)],
    });
    let values = state.eigenvalues().ok()?;
    let largest = values
        .iter()
        .fold(0.0, |most: f64, own| most.max(own.norm()));
    let rate = values
        .iter()
        .fold(f64::NEG_INFINITY, |most: f64, own| most.max(own.re));
    (rate > GROWS * largest).then_some(rate)
}
