//! One sample's regressor `[Y_a | Y_b]`, and the same columns as dynamics.
//!
//! Each row of the regressor touches few parameters, so only the entries that
//! can differ from zero are kept, row after row: [`ROW_COLUMNS`] says which
//! parameter each belongs to.

use crate::drives::{link_side, motor_side};
use crate::parameters::{JointParameter, Layout};
use crate::planar_2r::{INERTIAL, JOINTS, LinkColumns, Pose};
use crate::scalar::Jet;

/// Where the parameters of the planar arm stand in theta, \[15\].
pub const LAYOUT: Layout = Layout::new(JOINTS, INERTIAL);

/// Number of parameters.
pub const PARAMETERS: usize = LAYOUT.parameters();

/// Columns of theta that each row touches: two link rows, two motor rows.
pub const ROW_COLUMNS: [&[usize]; 2 * JOINTS] = [
    &[0, 1, 2, 5, 9, 11],
    &[1, 2, 6, 10, 12],
    &[3, 7, 9, 13],
    &[4, 8, 10, 14],
];

/// Number of entries that can differ from zero.
pub const ENTRIES: usize = 19;

/// One entry of the regressor: its part under the time derivative, and the
/// part beside it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Entry {
    /// Entry of `Y_a`.
    pub momentum: f64,
    /// Entry of `Y_b`.
    pub rest: f64,
}

/// Positions and velocities of all joints.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointState {
    /// Link positions, rad.
    pub q: [f64; JOINTS],
    /// Link velocities, rad/s.
    pub dq: [f64; JOINTS],
    /// Rotor positions after the gearbox, rad.
    pub phi: [f64; JOINTS],
    /// Rotor velocities after the gearbox, rad/s.
    pub dphi: [f64; JOINTS],
}

/// Accelerations of all joints, rad/s².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Acceleration {
    /// Link accelerations.
    pub ddq: [f64; JOINTS],
    /// Rotor accelerations.
    pub ddphi: [f64; JOINTS],
}

/// The planar arm with two flexible joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarArm {
    /// beta of `tanh(beta v)` for each joint, s/rad, positive.
    pub coulomb_sharpness: [f64; JOINTS],
}

impl PlanarArm {
    /// Returns one sample's regressor, row after row as in [`ROW_COLUMNS`].
    ///
    /// With the parameters theta, `d/dt(Y_a theta) + Y_b theta = [0; tau]`.
    ///
    /// # Source
    ///
    /// Eqs. (8) and section 3, corrected as said at each column.
    #[must_use]
    pub fn regressor(&self, state: &JointState) -> [Entry; ENTRIES] {
        let pose = Pose::new(&state.q);
        let link_momentum = pose.momentum(&state.dq);
        let link_rest = pose.rest(&state.dq);
        let mut entries = [Entry::default(); ENTRIES];
        let mut next = entries.iter_mut();
        let mut put = |momentum: f64, rest: f64| {
            if let Some(entry) = next.next() {
                *entry = Entry { momentum, rest };
            }
        };
        for joint in 0..JOINTS {
            // Link 1 does not move in the second row: its columns start at 1.
            for column in joint..INERTIAL {
                put(link_momentum[joint][column], link_rest[joint][column]);
            }
            let beta = self.coulomb_sharpness[joint];
            let deflection = state.phi[joint] - state.q[joint];
            for rest in link_side(deflection, state.dq[joint], beta) {
                put(0.0, rest);
            }
        }
        for joint in 0..JOINTS {
            let beta = self.coulomb_sharpness[joint];
            let deflection = state.phi[joint] - state.q[joint];
            let (momentum, rest) = motor_side(deflection, state.dphi[joint], beta);
            for (momentum, rest) in momentum.into_iter().zip(rest) {
                put(momentum, rest);
            }
        }
        entries
    }

    /// Returns the accelerations that the motor torques cause.
    ///
    /// - `theta`: parameters, \[15\].
    /// - `tau`: motor torques, \[2\], N·m.
    ///
    /// The equations of motion are solved with the columns of
    /// [`PlanarArm::regressor`]: the mass matrix is the momentum of unit
    /// velocities, and Coriolis torque is what the time derivative of the
    /// momentum leaves without acceleration.
    ///
    /// # Source
    ///
    /// Eq. (1).
    #[must_use]
    pub fn acceleration(
        &self,
        theta: &[f64; PARAMETERS],
        state: &JointState,
        tau: &[f64; JOINTS],
    ) -> Acceleration {
        let pose = Pose::new(&state.q);
        let mass_1 = times_parameters(&pose.momentum(&[1.0, 0.0]), theta);
        let mass_2 = times_parameters(&pose.momentum(&[0.0, 1.0]), theta);
        let rate = momentum_rate(&state.q, &state.dq, theta);
        let link_rest = times_parameters(&pose.rest(&state.dq), theta);

        let mut link = [0.0; JOINTS];
        let mut ddphi = [0.0; JOINTS];
        for joint in 0..JOINTS {
            let parameter = |kind| theta[LAYOUT.index(kind, joint)];
            let beta = self.coulomb_sharpness[joint];
            let deflection = state.phi[joint] - state.q[joint];

            let columns = link_side(deflection, state.dq[joint], beta);
            let drive: f64 = crate::drives::LINK_SIDE
                .into_iter()
                .zip(columns)
                .map(|(kind, column)| column * parameter(kind))
                .sum();
            link[joint] = -(rate[joint] + link_rest[joint] + drive);

            let (_, columns) = motor_side(deflection, state.dphi[joint], beta);
            let drive: f64 = crate::drives::MOTOR_SIDE
                .into_iter()
                .zip(columns)
                .map(|(kind, column)| column * parameter(kind))
                .sum();
            ddphi[joint] = (tau[joint] - drive) / parameter(JointParameter::RotorInertia);
        }
        let determinant = mass_1[0] * mass_2[1] - mass_2[0] * mass_1[1];
        Acceleration {
            ddq: [
                (mass_2[1] * link[0] - mass_2[0] * link[1]) / determinant,
                (mass_1[0] * link[1] - mass_1[1] * link[0]) / determinant,
            ],
            ddphi,
        }
    }

    /// Returns the link mass matrix `M_1(q)`, \[2 × 2\], kg·m².
    #[must_use]
    pub fn mass_matrix(theta: &[f64; PARAMETERS], q: &[f64; JOINTS]) -> [[f64; JOINTS]; JOINTS] {
        let pose = Pose::new(q);
        let first = times_parameters(&pose.momentum(&[1.0, 0.0]), theta);
        let second = times_parameters(&pose.momentum(&[0.0, 1.0]), theta);
        [[first[0], second[0]], [first[1], second[1]]]
    }
}

/// Returns the Taylor series of the torque that the links need from the
/// springs, without friction: `w = d/dt(momentum) + rest`, \[2\], N·m.
///
/// - `q`: derivatives 0 to 4 of the link positions, \[2\]\[5\].
pub(crate) fn link_torque_series(
    q: &[[f64; 5]; JOINTS],
    theta: &[f64; PARAMETERS],
) -> [Jet<3>; JOINTS] {
    let position = q.map(|d| Jet::from_derivatives([d[0], d[1], d[2], d[3]]));
    let velocity = q.map(|d| Jet::from_derivatives([d[1], d[2], d[3], d[4]]));
    let pose = Pose::<Jet<4>>::new(&position);
    let momentum = pose.momentum(&velocity);
    let rest = pose.rest(&velocity);
    core::array::from_fn(|joint| {
        let mut series = [0.0; 3];
        for column in 0..INERTIAL {
            for (order, value) in series.iter_mut().enumerate() {
                let rate = (order + 1) as f64 * momentum[joint][column].coefficients[order + 1];
                *value += theta[column] * (rate + rest[joint][column].coefficients[order]);
            }
        }
        Jet {
            coefficients: series,
        }
    })
}

fn momentum_rate(
    q: &[f64; JOINTS],
    dq: &[f64; JOINTS],
    theta: &[f64; PARAMETERS],
) -> [f64; JOINTS] {
    let position = [0, 1].map(|i: usize| Jet::from_derivatives([q[i], dq[i]]));
    let velocity = dq.map(|v| Jet::from_derivatives([v, 0.0]));
    let columns = Pose::<Jet<2>>::new(&position).momentum(&velocity);
    times_parameters(
        &columns.map(|row| row.map(|column| column.coefficients[1])),
        theta,
    )
}

fn times_parameters(columns: &LinkColumns<f64>, theta: &[f64; PARAMETERS]) -> [f64; JOINTS] {
    columns.map(|row| {
        row.iter()
            .zip(theta)
            .map(|(column, value)| column * value)
            .sum()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drives::{LINK_SIDE, MOTOR_SIDE};

    #[test]
    fn row_columns_are_those_of_the_layout() {
        let mut entries = 0;
        for joint in 0..JOINTS {
            let drive = |kind| LAYOUT.index(kind, joint);
            let link = ROW_COLUMNS[joint];
            assert!(link[..INERTIAL - joint].iter().copied().eq(joint..INERTIAL));
            assert!(
                link[INERTIAL - joint..]
                    .iter()
                    .copied()
                    .eq(LINK_SIDE.map(drive))
            );
            let motor = ROW_COLUMNS[JOINTS + joint];
            assert!(motor.iter().copied().eq(MOTOR_SIDE.map(drive)));
            entries += link.len() + motor.len();
        }
        assert_eq!(entries, ENTRIES);
    }
}
