//! The observer of torques from outside, one sample at a time.

use sprung_core::observer::ObserverFilters;

use super::learn::{deviation, of_joint};
use super::monitor::Variance;
use super::residual::Residuals;
use super::result::Watch;
use crate::model::{Model, Theta};
use crate::regression::PassError;

/// What an observer was taught by healthy logs, in the form of code.
#[derive(Clone, Debug, PartialEq)]
pub struct ObserverSettings {
    /// Sampling period T, s.
    pub period_s: f64,
    /// Cut-off ω of the three filters of all signals, rad/s.
    pub cutoff_rad_per_s: f64,
    /// Cut-off λ of the last filter, rad/s.
    pub bandwidth_rad_per_s: f64,
    /// One entry per joint.
    pub joints: Vec<ObservedJoint>,
}

/// A joint of an observer.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservedJoint {
    /// Share of the residual of the motor's equation in the torque from outside.
    pub motor_share: f64,
    /// Coefficients of the variance of the torque from outside.
    pub variance: [f64; 5],
    /// Deviation by another zero of an encoder, until the joint has moved in both directions, N·m (N).
    pub zero_nm: f64,
    /// Threshold in standard deviations.
    pub threshold_sigma: f64,
}

impl ObserverSettings {
    /// Returns the settings of a watch; `None` if the threshold of a joint is not known.
    #[must_use]
    pub fn of(watch: &Watch) -> Option<Self> {
        let joint = |joint: &super::result::WatchedJoint| {
            Some(ObservedJoint {
                motor_share: joint.motor_share,
                variance: joint.variance.as_slice().try_into().ok()?,
                zero_nm: joint.zero_nm,
                threshold_sigma: joint.threshold_sigma?,
            })
        };
        Some(Self {
            period_s: watch.period_s,
            cutoff_rad_per_s: watch.cutoff_rad_per_s,
            bandwidth_rad_per_s: watch.bandwidth_rad_per_s,
            joints: watch.joints.iter().map(joint).collect::<Option<_>>()?,
        })
    }
}

/// Observes torques from outside, one sample at a time. The first sample begins at rest.
pub struct TorqueObserver<'a> {
    model: &'a Model,
    settings: &'a ObserverSettings,
    residuals: Residuals<'a>,
}

impl<'a> TorqueObserver<'a> {
    /// - `theta`: \[p\].
    ///
    /// # Errors
    ///
    /// [`PassError`] if a cut-off or the period is not positive.
    pub fn new(
        (model, theta): (&'a Model, &'a Theta),
        settings: &'a ObserverSettings,
    ) -> Result<Self, PassError> {
        let filters = ObserverFilters::new(
            settings.cutoff_rad_per_s,
            settings.bandwidth_rad_per_s,
            settings.period_s,
        )
        .map_err(PassError::FilterPair)?;
        Ok(Self {
            model,
            settings,
            residuals: Residuals::new((model, theta), filters),
        })
    }

    /// Returns the samples after which the observer has settled.
    #[must_use]
    pub fn settle(&self) -> usize {
        self.residuals.settle()
    }

    /// Takes a sample and returns the torque from outside and its threshold of each joint, N·m (N).
    ///
    /// - `q`, `phi`: positions of links and motors, rad (m); `tau`, `sensor`: torques of the motors and readings of the torque
    ///   sensors, zero without one, N·m (N); each \[n\].
    pub fn step(&mut self, q: &[f64], phi: &[f64], [tau, sensor]: [&[f64]; 2]) -> Vec<[f64; 2]> {
        self.residuals.step([q, phi, tau, sensor], Vec::new());
        let joints = self.settings.joints.iter().enumerate();
        joints
            .map(|(joint, of)| {
                let now = &self.residuals.now;
                let torque = of_joint(self.model, joint, now, of.motor_share);
                let deviation = deviation(now, joint, (&Variance(of.variance), of.zero_nm));
                [torque, of.threshold_sigma * deviation]
            })
            .collect()
    }
}
