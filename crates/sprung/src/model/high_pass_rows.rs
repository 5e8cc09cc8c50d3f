//! Joints whose deflection comes from a gyroscope.

use std::f64::consts::TAU;

use crate::description::{Experiment, GYROSCOPE_CORNER_HZ};

/// Joints whose rows pass the filter, and its corner.
#[derive(Clone, Debug)]
pub(super) struct HighPassRows {
    pub(super) joints: Vec<bool>,
    /// rad/s.
    pub(super) corner: f64,
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
