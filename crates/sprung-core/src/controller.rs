//! The two controllers of the paper: PD on the rotors, and feedforward with
//! state feedback.

use crate::drives::State;
use crate::links::{LengthError, Step, lengths};
use crate::parameters::JointParameter;
use crate::robot::{Robot, Values};
use crate::scalar::Jet;

/// Writes the motor torques of PD control, \[n\], N·m (N).
///
/// - `kp`, `kd`: gains, \[n\], N·m/rad (N/m) and N·m·s/rad (N·s/m).
/// - `phi_d`, `dphi_d`: reference positions and velocities of the rotors, \[n\], rad (m) and rad/s
///   (m/s).
/// - `phi`, `dphi`: measured positions and velocities of the rotors, \[n\].
///
/// If another slice is shorter than `tau`, the last entries of `tau` stay unchanged.
///
/// # Source
///
/// Eq. (24).
pub fn pd(
    kp: &[f64],
    kd: &[f64],
    [phi_d, dphi_d]: [&[f64]; 2],
    [phi, dphi]: [&[f64]; 2],
    tau: &mut [f64],
) {
    let gains = kp.iter().zip(kd);
    let wanted = phi_d.iter().zip(dphi_d);
    let found = phi.iter().zip(dphi);
    for (((tau, (kp, kd)), (phi_d, dphi_d)), (phi, dphi)) in
        tau.iter_mut().zip(gains).zip(wanted).zip(found)
    {
        *tau = kp * (phi_d - phi) + kd * (dphi_d - dphi);
    }
}

/// Taylor series of a torque with its first two time derivatives.
pub type TorqueSeries = Jet<3>;

/// Scratch memory of [`Feedforward::fill`]; each slice is \[n\].
#[derive(Debug)]
pub struct FeedforwardScratch<'w> {
    /// Taylor series of positions, velocities, accelerations and torques of the links.
    pub series: [&'w mut [TorqueSeries]; 4],
    /// Scratch memory of the inverse dynamics.
    pub steps: &'w mut [Step<TorqueSeries>],
}

/// Rotor trajectory and motor torques with which a model follows a desired link trajectory; each
/// \[n\].
#[derive(Debug)]
pub struct Feedforward<'o> {
    /// Nominal motor torque `tau_d`, N·m (N).
    pub tau: &'o mut [f64],
    /// Desired rotor positions, rad (m).
    pub phi: &'o mut [f64],
    /// Desired rotor velocities, rad/s (m/s).
    pub dphi: &'o mut [f64],
}

impl Feedforward<'_> {
    /// Computes the nominal rotor trajectory and motor torques of a model without friction.
    ///
    /// - `q_d`: desired link positions and their time derivatives up to the fourth, \[n\]\[5\].
    /// - `values`: parameters of the model; stiffnesses must not be zero.
    ///
    /// The rotor of a rigid joint moves with its link.
    ///
    /// # Errors
    ///
    /// [`LengthError`] if a slice does not fit the robot.
    ///
    /// # Source
    ///
    /// Eq. (32) and the equations before it.
    pub fn fill(
        &mut self,
        robot: &Robot<'_>,
        values: &Values<'_>,
        q_d: &[[f64; 5]],
        scratch: &mut FeedforwardScratch<'_>,
    ) -> Result<(), LengthError> {
        let n = robot.joints();
        let [q, dq, ddq, torque] = &mut scratch.series;
        lengths(
            &[
                ("q_d", q_d.len()),
                ("tau", self.tau.len()),
                ("phi", self.phi.len()),
                ("dphi", self.dphi.len()),
                ("series", q.len()),
                ("series", dq.len()),
                ("series", ddq.len()),
            ],
            n,
        )?;
        for (i, d) in q_d.iter().enumerate() {
            q[i] = Jet::from_derivatives([d[0], d[1], d[2]]);
            dq[i] = Jet::from_derivatives([d[1], d[2], d[3]]);
            ddq[i] = Jet::from_derivatives([d[2], d[3], d[4]]);
        }
        robot.link_torque(values, q, dq, ddq, scratch.steps, torque)?;
        // In a rigid joint the rotor's motion is the link's.
        for (i, d) in q_d.iter().enumerate() {
            let rotor = |order: usize| match stiffness(robot, values, i) {
                Some(k) => d[order] + torque[i].derivative(order) / k,
                None => d[order],
            };
            self.phi[i] = rotor(0);
            self.dphi[i] = rotor(1);
            self.tau[i] = torque[i].derivative(0);
            // From here on `dq` holds the rotor's acceleration.
            dq[i] = Jet::from_derivatives([rotor(2), 0.0, 0.0]);
        }
        for term in robot.terms {
            if term.what == JointParameter::RotorInertia {
                let motor: f64 = (0..n)
                    .map(|k| robot.ratio(term.joint, k) * dq[k].derivative(0))
                    .sum();
                self.tau[robot.joint_of(term.row)] +=
                    values.theta[term.column] * term.momentum(motor);
            }
        }
        Ok(())
    }
}

/// Returns the stiffness of a joint; `None` for a rigid joint.
fn stiffness(robot: &Robot<'_>, values: &Values<'_>, joint: usize) -> Option<f64> {
    let mut terms = robot.terms.iter();
    let term = terms.find(|t| t.what == JointParameter::Stiffness && t.joint == joint)?;
    Some(values.theta[term.column])
}

/// Adds state feedback about the trajectory of a [`Feedforward`] to its torques.
///
/// - `gain`: `F`, \[n\] rows of \[4n\], applied to the errors of link positions, rotor positions,
///   link velocities and rotor velocities, in this order.
/// - `tau`: torques of the feedforward, \[n\], N·m (N).
///
/// # Source
///
/// Eq. (33).
pub fn state_feedback(gain: &[&[f64]], desired: &State<'_>, measured: &State<'_>, tau: &mut [f64]) {
    let wanted = [desired.q, desired.phi, desired.dq, desired.dphi];
    let found = [measured.q, measured.phi, measured.dq, measured.dphi];
    for (tau, row) in tau.iter_mut().zip(gain) {
        let errors = (wanted.iter().zip(&found))
            .flat_map(|(wanted, found)| wanted.iter().zip(*found))
            .map(|(wanted, found)| wanted - found);
        *tau += row
            .iter()
            .zip(errors)
            .map(|(gain, e)| gain * e)
            .sum::<f64>();
    }
}
