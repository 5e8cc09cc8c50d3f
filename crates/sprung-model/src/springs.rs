//! Springs: their torques, and the regression of stiffnesses without link encoder.
//!
//! Without link encoder the link position of a joint with torque sensor is `q = phi - tau_s / k`. The
//! link rows are linear in all other parameters, and they are linearised in `k` about values from an
//! earlier estimate: the column of `k` is the derivative of the row's torque by `k`, and the column
//! times the earlier `k` is added to the right-hand side. So theta still contains the stiffness
//! itself.

use std::sync::Arc;

use sprung_core::drives::{State, Term};
use sprung_core::parameters::JointParameter;

use super::Model;
use super::deflection_entry::DeflectionEntry;

impl Model {
    /// Returns the torques of the springs on the links, \[n\], N·m (N); zero for a rigid joint.
    ///
    /// - `theta`: \[p\].
    #[must_use]
    pub fn spring_torques(&self, theta: &[f64], state: &State<'_>) -> Vec<f64> {
        let robot = self.robot();
        let mut torques = vec![0.0; self.joint_count()];
        let of_motor = |term: &&Term| term.what.is_of_spring() && term.row >= torques.len();
        let terms: Vec<&Term> = robot.terms.iter().filter(of_motor).collect();
        for term in terms {
            let drive = robot.drive(state, term.joint);
            torques[term.joint] += theta[term.column] * term.rest(&drive, self.shape(term.joint));
        }
        torques
    }

    /// Returns a copy whose regression is linear about `theta`, \[p\], in the stiffnesses of joints
    /// without link encoder.
    #[must_use]
    pub fn with_springs(&self, theta: &[f64]) -> Self {
        Self {
            springs: Some(theta.into()),
            ..self.clone()
        }
    }

    /// Returns the parameter vector about which the regression is linear, \[p\]; `None` before it
    /// is known.
    #[must_use]
    pub fn springs(&self) -> Option<&Arc<[f64]>> {
        self.springs.as_ref()
    }

    /// Returns the entries of stiffnesses in link rows.
    #[must_use]
    pub fn deflection_entries(&self) -> &[DeflectionEntry] {
        &self.rows_in_use().deflections
    }

    /// Returns the joints whose link position follows from the torque of the spring.
    #[must_use]
    pub fn joints_without_link(&self) -> Vec<usize> {
        let entries = self.deflection_entries().iter();
        let mut joints: Vec<usize> = entries.map(|deflection| deflection.joint).collect();
        joints.sort_unstable();
        joints.dedup();
        joints
    }

    /// Returns the places of the stiffnesses in a link row, with the values whose torque is on the
    /// right-hand side.
    #[must_use]
    pub fn known_deflections(&self, row: usize) -> Vec<(usize, f64)> {
        let Some(theta) = &self.springs else {
            return Vec::new();
        };
        let first = self.row_entries(row).start;
        (self.deflection_entries().iter())
            .filter(|deflection| deflection.row == row)
            .map(|deflection| (deflection.entry - first, theta[deflection.column]))
            .collect()
    }

    /// Returns the stiffness of a joint about which the regression is linear, N·m/rad (N/m); `None`
    /// if it is unknown.
    #[must_use]
    pub fn known_stiffness(&self, joint: usize) -> Option<f64> {
        let index = self.index(JointParameter::Stiffness, joint)?;
        Some(self.springs.as_ref()?[index]).filter(|k| *k > 0.0)
    }
}
