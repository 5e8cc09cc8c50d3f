//! High-pass filter of the rows of joints whose deflection comes from a gyroscope.

use std::f64::consts::TAU;

use sprung_core::parameters::JointParameter;

use super::Model;
use crate::description::{Experiment, GYROSCOPE_CORNER_HZ};

/// Joints whose rows pass the filter, and its corner.
#[derive(Clone, Debug)]
pub(super) struct HighPassRows {
    joints: Vec<bool>,
    corner: f64,
}

impl HighPassRows {
    /// Returns `None` if the log has no gyroscopes.
    pub(super) fn new(experiment: &Experiment) -> Option<Self> {
        let (log, robot) = (experiment.log.as_ref()?, &experiment.robot);
        let joints: Vec<bool> = (0..robot.joint.len())
            .map(|joint| log.has_gyroscope(robot, joint))
            .collect();
        let corner = TAU * log.gyroscope_corner_hz.unwrap_or(GYROSCOPE_CORNER_HZ);
        joints.contains(&true).then_some(Self { joints, corner })
    }
}

impl Model {
    /// Returns whether the deflection of a joint comes from a gyroscope.
    #[must_use]
    pub(crate) fn has_gyroscope(&self, joint: usize) -> bool {
        let own = self.fixed.high_pass.as_ref();
        own.is_some_and(|own| own.joints[joint])
    }

    /// Returns the corner of the high-pass filter of a row, rad/s, and the places of the row's entries that
    /// have passed it already: that of the deflection. `None` for a row without filter.
    #[must_use]
    pub(crate) fn high_pass(&self, row: usize) -> Option<(f64, Vec<usize>)> {
        let own = self.fixed.high_pass.as_ref()?;
        let joint = self.joint_of(row);
        let is_of_deflection = |column: &usize| {
            self.parameters()[*column].joint == Some((JointParameter::Stiffness, joint))
        };
        let columns = self.row_columns(row).iter().enumerate();
        own.joints[joint].then(|| {
            let places = columns.filter(|(_, column)| is_of_deflection(column));
            (own.corner, places.map(|(place, _)| place).collect())
        })
    }
}
