//! Input of the design of a controller.

use crate::description::{
    Control, Controller, ControllerKind, Feedback, Feedforward, Reference, Simulate,
};
use crate::model::{Model, Theta};

/// Input of the design of a controller.
#[derive(Clone, Copy, Debug)]
pub struct ControlTask<'a> {
    /// The robot's equations and limits.
    pub model: &'a Model,
    /// Identified values, \[p\].
    pub theta: &'a Theta,
    /// Values of robots from the posterior, \[draws\]\[p\].
    pub draws: &'a [Theta],
    /// Settings.
    pub settings: &'a Control,
    /// The controller of the experiment.
    pub declared: Option<&'a Controller>,
    /// Period of the controller, s.
    pub period: f64,
    /// Windows of the velocity estimator, samples.
    pub window: [usize; 2],
    /// Poses, link positions, \[poses\]\[n\], rad (m).
    pub poses: &'a [Vec<f64>],
    /// Ranges of the link positions, \[n\], rad (m).
    pub ranges: &'a [[f64; 2]],
    /// Largest torques of the motors, \[n\], N·m (N); infinite without limit.
    pub torque_limits: &'a [f64],
    /// Sensors and errors of the simulations.
    pub twin: &'a Simulate,
    /// Reference that the links follow in the simulations.
    pub reference: Option<&'a Reference>,
}

impl ControlTask<'_> {
    /// Returns a state feedback with the torques of the model.
    pub(super) fn feedback(&self, gain: Vec<Vec<f64>>, speed: Option<f64>) -> Controller {
        Controller {
            kind: ControllerKind::StateFeedback,
            kp_nm_per_rad: Vec::new(),
            kd_nms_per_rad: Vec::new(),
            gain,
            feedforward: Feedforward::Identified,
            friction_compensation_speed_rad_per_s: speed,
            velocity_window: self.window,
            shaper: Vec::new(),
            reference: Reference::default(),
        }
    }

    /// Returns whether the controller of the experiment is examined as it is.
    pub(super) fn is_declared(&self) -> bool {
        self.settings.feedback == Feedback::Declared
    }
}

/// Returns the gains of a controller on the errors of link positions, motor positions, link velocities and motor velocities,
/// \[n\]\[4n\].
pub(super) fn whole_gain(controller: &Controller, n: usize) -> Vec<Vec<f64>> {
    match controller.kind {
        ControllerKind::StateFeedback => controller.gain.clone(),
        ControllerKind::Pd => (0..n)
            .map(|i| {
                let mut row = vec![0.0; 4 * n];
                row[n + i] = controller.kp_nm_per_rad[i];
                row[3 * n + i] = controller.kd_nms_per_rad[i];
                row
            })
            .collect(),
    }
}
