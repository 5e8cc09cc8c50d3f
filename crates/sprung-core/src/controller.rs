//! The two controllers of the paper: PD on the rotors, and feedforward with
//! state feedback.

use crate::parameters::JointParameter;
use crate::planar_2r::JOINTS;
use crate::regressor::{JointState, LAYOUT, PARAMETERS, link_torque_series};

/// Number of states that state feedback uses.
pub const STATES: usize = 4 * JOINTS;

/// PD control of the rotor positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pd {
    /// `K_p`, \[2\], N·m/rad.
    pub kp: [f64; JOINTS],
    /// `K_v`, \[2\], N·m·s/rad.
    pub kd: [f64; JOINTS],
}

impl Pd {
    /// Returns the motor torque, \[2\], N·m.
    ///
    /// - `phi_d`, `dphi_d`: reference of the rotors, \[2\], rad and rad/s.
    /// - `phi`, `dphi`: rotor positions and velocities, \[2\].
    ///
    /// # Source
    ///
    /// Eq. (24).
    #[must_use]
    pub fn torque(
        &self,
        phi_d: &[f64; JOINTS],
        dphi_d: &[f64; JOINTS],
        phi: &[f64; JOINTS],
        dphi: &[f64; JOINTS],
    ) -> [f64; JOINTS] {
        core::array::from_fn(|i| {
            self.kp[i] * (phi_d[i] - phi[i]) + self.kd[i] * (dphi_d[i] - dphi[i])
        })
    }
}

/// Where a model puts the robot on a desired link trajectory, and the torque
/// that it needs there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Feedforward {
    /// Nominal motor torque `tau_d`, \[2\], N·m.
    pub tau: [f64; JOINTS],
    /// Desired state.
    pub state: JointState,
}

impl Feedforward {
    /// Returns the nominal rotor trajectory and torque of a model without
    /// friction.
    ///
    /// - `q_d`: derivatives 0 to 4 of the desired link positions, \[2\]\[5\].
    /// - `theta`: parameters of the model, \[15\]; stiffnesses not zero.
    ///
    /// # Source
    ///
    /// Eq. (32) and the equations before it.
    #[must_use]
    pub fn new(q_d: &[[f64; 5]; JOINTS], theta: &[f64; PARAMETERS]) -> Self {
        let link_torque = link_torque_series(q_d, theta);
        let mut nominal = Self::default();
        for i in 0..JOINTS {
            let stiffness = theta[LAYOUT.index(JointParameter::Stiffness, i)];
            let inertia = theta[LAYOUT.index(JointParameter::RotorInertia, i)];
            let rotor = |order: usize| q_d[i][order] + link_torque[i].derivative(order) / stiffness;
            nominal.state.q[i] = q_d[i][0];
            nominal.state.dq[i] = q_d[i][1];
            nominal.state.phi[i] = rotor(0);
            nominal.state.dphi[i] = rotor(1);
            nominal.tau[i] = inertia * rotor(2) + stiffness * (rotor(0) - q_d[i][0]);
        }
        nominal
    }
}

/// State feedback around a [`Feedforward`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateFeedback {
    /// `F`, \[2 × 8\], on the errors of link positions, rotor positions, link
    /// velocities and rotor velocities.
    pub gain: [[f64; STATES]; JOINTS],
}

impl StateFeedback {
    /// Returns the motor torque, \[2\], N·m.
    ///
    /// # Source
    ///
    /// Eq. (33).
    #[must_use]
    pub fn torque(&self, desired: &Feedforward, state: &JointState) -> [f64; JOINTS] {
        let of = |s: &JointState| [s.q, s.phi, s.dq, s.dphi];
        let (wanted, found) = (of(&desired.state), of(state));
        core::array::from_fn(|row| {
            let mut tau = desired.tau[row];
            for group in 0..4 {
                for joint in 0..JOINTS {
                    tau += self.gain[row][group * JOINTS + joint]
                        * (wanted[group][joint] - found[group][joint]);
                }
            }
            tau
        })
    }
}
