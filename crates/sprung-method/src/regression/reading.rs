//! Settings for reading a log.

use std::sync::Arc;

use sprung_core::parameters::JointParameter;

use super::weights::TransitionWeights;
use crate::description::{Estimator, Identify, SpringTorque};
use crate::log::Channels;
use crate::model::Model;

/// Settings for reading a log; the `with_...` methods return variants.
///
/// Copies share their contents, so a search can make many of them cheaply.
#[derive(Clone, Debug)]
pub struct Reading {
    model: Arc<Model>,
    settings: Arc<Identify>,
    channels: Arc<Channels>,
    filter_cutoff: f64,
    position_cutoff_hz: f64,
    delays: Arc<[f64]>,
    compliances: Arc<[f64]>,
    weights: Option<Arc<TransitionWeights>>,
}

impl Reading {
    /// Returns the settings for a log without delays and with equal weights.
    ///
    /// - `model`: the equations; `settings`: the filters; `channels`: meaning of the columns.
    /// - `position_cutoff_hz`: cut-off of the position filter, Hz.
    #[must_use]
    pub fn new(
        model: &Model,
        settings: &Identify,
        channels: &Channels,
        position_cutoff_hz: f64,
    ) -> Self {
        Self {
            model: Arc::new(model.clone()),
            settings: Arc::new(settings.clone()),
            delays: vec![0.0; channels.all.len()].into(),
            compliances: vec![0.0; model.joint_count()].into(),
            channels: Arc::new(channels.clone()),
            filter_cutoff: settings.filter_cutoff(0.0),
            position_cutoff_hz,
            weights: None,
        }
    }

    /// Returns a copy for logs of a sampling period, s, on which the corner of the filter pair depends.
    #[must_use]
    pub fn at_period(self, period: f64) -> Self {
        Self {
            filter_cutoff: self.settings.filter_cutoff(period),
            ..self
        }
    }

    /// Returns the corner λ of the filter pair, rad/s.
    #[must_use]
    pub fn filter_cutoff(&self) -> f64 {
        self.filter_cutoff
    }

    /// Returns the equations.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Returns the settings of the identification, including those of the filters.
    #[must_use]
    pub fn settings(&self) -> &Identify {
        &self.settings
    }

    /// Returns whether a refinement follows: the settings name it, or a joint has a spring. That of rigid joints by default
    /// depends on the fit.
    #[must_use]
    pub fn is_refined(&self) -> bool {
        let estimators = self
            .settings
            .estimators(self.can_refine() && self.model.has_springs());
        estimators.contains(&Estimator::PredictionError)
    }

    /// Returns whether a refinement works with the sensors of the links.
    pub(crate) fn can_refine(&self) -> bool {
        self.channels.inertial.is_none()
    }

    /// Returns the meaning of the columns.
    #[must_use]
    pub fn channels(&self) -> &Channels {
        &self.channels
    }

    /// Returns the cut-off of the position filter, Hz.
    #[must_use]
    pub fn position_cutoff_hz(&self) -> f64 {
        self.position_cutoff_hz
    }

    /// Returns the time over which the filters correlate neighbouring samples, s: one period of the
    /// cut-off of the positions, or twice the time constant of the filter pair.
    #[must_use]
    pub fn memory(&self) -> f64 {
        let of_pair = 2.0 / self.filter_cutoff;
        of_pair.max(self.position_cutoff_hz.recip())
    }

    /// Returns the delays to undo, one per channel, s.
    #[must_use]
    pub fn delays(&self) -> &[f64] {
        &self.delays
    }

    /// Returns the compliances of the joints with torque sensor, \[n\], rad/(N·m) (m/N); zero if
    /// unknown.
    #[must_use]
    pub(crate) fn compliances(&self) -> &[f64] {
        &self.compliances
    }

    /// Returns a copy in which link positions without encoder follow from motor positions, torques of
    /// springs and the stiffnesses in `theta`, \[p\]. The regression is linear about `theta` in these
    /// stiffnesses.
    #[must_use]
    pub(crate) fn with_springs(&self, theta: &[f64]) -> Self {
        let model = &self.model;
        let compliance = |joint| -> f64 {
            let is_measured =
                self.channels.instruments.at(joint).spring_torque() == SpringTorque::Measured;
            let of_sensor = (model.index(JointParameter::Stiffness, joint)).filter(|_| is_measured);
            let stiffness = of_sensor.map(|index| theta[index]);
            stiffness.filter(|k| *k > 0.0).map_or(0.0, f64::recip)
        };
        Self {
            compliances: (0..model.joint_count()).map(compliance).collect(),
            model: Arc::new(model.with_springs(theta)),
            ..self.clone()
        }
    }

    /// Returns the weights of the samples; `None` if all weights are equal.
    #[must_use]
    pub fn weights(&self) -> Option<&TransitionWeights> {
        self.weights.as_deref()
    }

    /// Returns a copy with other equations.
    #[must_use]
    pub fn with_model(&self, model: Model) -> Self {
        Self {
            model: Arc::new(model),
            ..self.clone()
        }
    }

    /// Returns a copy with other meanings of the columns; their number must not change.
    #[must_use]
    pub fn with_channels(&self, channels: Channels) -> Self {
        debug_assert_eq!(channels.all.len(), self.delays.len());
        Self {
            channels: Arc::new(channels),
            ..self.clone()
        }
    }

    /// Returns a copy with another cut-off of the position filter, Hz.
    #[must_use]
    pub fn with_position_cutoff(&self, position_cutoff_hz: f64) -> Self {
        Self {
            position_cutoff_hz,
            ..self.clone()
        }
    }

    /// Returns a copy with other delays, one per channel, s.
    #[must_use]
    pub fn with_delays(&self, delays: &[f64]) -> Self {
        debug_assert_eq!(delays.len(), self.channels.all.len());
        Self {
            delays: delays.into(),
            ..self.clone()
        }
    }

    /// Returns a copy for samples of a longer period, whose torques are means of those of a log: they act with the delay of
    /// the log's torques.
    ///
    /// - `of_log`, `period`: of the log and of the samples, s.
    #[must_use]
    pub fn thinned(&self, of_log: f64, period: f64) -> Self {
        let acting = |period| self.channels.acting_delays(&self.delays, period);
        let changes = acting(of_log).into_iter().zip(acting(period));
        let delays: Vec<f64> = (self.delays.iter().zip(changes))
            .map(|(delay, (shorter, longer))| delay + (shorter - longer))
            .collect();
        self.with_delays(&delays)
    }

    /// Returns a copy with weights of the samples.
    #[must_use]
    pub fn with_weights(&self, weights: TransitionWeights) -> Self {
        Self {
            weights: Some(Arc::new(weights)),
            ..self.clone()
        }
    }

    /// Returns a copy with equal weights.
    #[must_use]
    pub fn without_weights(&self) -> Self {
        Self {
            weights: None,
            ..self.clone()
        }
    }
}
