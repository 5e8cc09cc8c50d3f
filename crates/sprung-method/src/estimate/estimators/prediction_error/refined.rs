//! Result of a refinement.

use sprung_core::friction::Scale;

use super::channel_updates::ChannelUpdate;
use super::descent::Ending;
use crate::estimate::statistics::CERTAIN_SIGMAS;
use crate::model::Theta;

/// Result of a refinement.
#[derive(Clone, Debug)]
pub(super) struct Refined {
    /// The parameter vector including fixed values, \[p\].
    pub(super) theta: Theta,
    /// Parameters of the likeliest robot, possible or not, \[p\]; `None` without constraints.
    pub(super) unconstrained: Option<Theta>,
    /// Standard error of each parameter, \[p\]: zero for fixed parameters, infinite if the log does
    /// not determine the parameter.
    pub(super) standard_error: Vec<f64>,
    /// Part of each standard error that comes from changes between parts of the logs, \[p\].
    pub(super) between_parts: Vec<f64>,
    /// Indices in theta of the parameters that were refined.
    pub(super) free: Vec<usize>,
    /// Covariance of the refined parameters, \[free × free\].
    pub(super) covariance: Vec<f64>,
    /// How the search went.
    pub(super) search: Search,
    /// What was read of the logs.
    pub(super) read: Read,
    /// Noise and disturbances.
    pub(super) noise: FoundNoise,
    /// Estimates of the scales of friction laws that the description leaves open.
    pub(super) scales: Vec<FrictionScale>,
    /// What the channels do to the quantities.
    pub(super) channels: FoundChannels,
    /// Changes of the refined parameters by the correction for noise of the logged torques,
    /// \[free\].
    pub(super) by_noise: Vec<f64>,
    /// Estimates from parts of the logs.
    pub(super) parts: OfParts,
}

/// How a search went.
#[derive(Clone, Debug)]
pub(super) struct Search {
    /// Reason why it ended.
    pub(super) ending: Ending,
    /// Number of runs of the filter.
    pub(super) runs: usize,
    /// Last change of each refined parameter: index in theta and change in standard errors, the
    /// largest first.
    pub(super) moved: Vec<(usize, f64)>,
    /// Minus the logarithm of the likelihood, without its constant.
    pub(super) loss: f64,
    /// Mean squared whitened innovation.
    pub(super) cost: f64,
}

/// What was read of the logs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Read {
    /// Number of measurements used.
    pub(super) measurements: u64,
    /// Number of samples used.
    pub(super) samples: usize,
    /// Time that the samples span, s.
    pub(super) duration: f64,
    /// Whether the logs contain more samples.
    pub(super) left_out: bool,
}

/// Noise and disturbances.
#[derive(Clone, Debug)]
pub(super) struct FoundNoise {
    /// Levels of noise and disturbance, one entry per row of the regressor.
    pub(super) rows: Vec<RowLevel>,
    /// Corner frequency of the disturbances' spectrum, Hz.
    pub(super) corner: f64,
    /// Noise of sensors beyond the noise that their samples show.
    pub(super) sensors: Vec<SensorLevel>,
    /// Prior levels of presliding friction and hysteresis by joint and side, N·m (N).
    pub(super) presliding: Vec<(usize, &'static str, f64)>,
}

/// What channels do to the quantities.
#[derive(Clone, Debug)]
pub(super) struct FoundChannels {
    /// Offsets of the sensors.
    pub(super) offsets: Vec<SensorOffset>,
    /// Estimates of the delays, one per channel.
    pub(super) delays: Vec<ChannelUpdate>,
    /// Estimate of the common delay of all torques; `None` if the description gives delays of torques.
    pub(super) torques_delay: Option<ChannelUpdate>,
}

/// Estimates from parts of the logs.
#[derive(Clone, Debug)]
pub(super) struct OfParts {
    /// Parameter vectors for growing parts of the log, with the end of each part, s.
    pub(super) trace: Vec<(f64, Theta)>,
    /// Parameter vectors without each of the folds in turn, with the end of each fold as a
    /// fraction of the samples.
    pub(super) without: Vec<(f64, Theta)>,
    /// Estimate from each of several logs alone: value and standard error of each refined
    /// parameter, followed by those of the offsets.
    pub(super) logs: Vec<Vec<(f64, f64)>>,
}

impl Refined {
    /// Returns whether a disturbance ended at its upper bound.
    pub(super) fn at_bound(&self) -> bool {
        self.noise.rows.iter().any(|level| level.at_bound)
    }

    /// Returns whether the correction for noise of the logged torques moves a parameter by far more than its standard error. The
    /// columns of effects that the model lacks have no such correction, so they all seem to be missing then.
    pub(super) fn is_outweighed_by_noise(&self) -> bool {
        let mut moves = self.free.iter().zip(&self.by_noise);
        moves.any(|(&index, moved)| moved.abs() > CERTAIN_SIGMAS * self.standard_error[index])
    }

    /// Returns whether the search converged.
    pub(super) fn converged(&self) -> bool {
        match self.search.ending {
            Ending::Converged => true,
            Ending::AtBound | Ending::GivenUp | Ending::OnlyNoise | Ending::OutOfRuns => false,
        }
    }
}

/// Levels of noise and disturbance of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RowLevel {
    /// Standard deviation of white torque noise, N·m (N).
    pub(super) torque_noise: f64,
    /// Standard deviation of the further white noise while friction reverses, N·m (N).
    pub(super) reversal_noise: f64,
    /// Standard deviation of the disturbance, N·m (N).
    pub(super) disturbance: f64,
    /// Standard deviation of the torque of the row's joint, N·m (N).
    pub(super) torque: f64,
    /// Whether the disturbance ended at its upper bound.
    pub(super) at_bound: bool,
}

/// Noise of a sensor beyond the noise that its samples show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SensorLevel {
    pub(super) channel: usize,
    /// Standard deviation, rad (m).
    pub(super) noise: f64,
    /// Standard deviation of the sensor's readings, rad (m).
    pub(super) scale: f64,
}

/// Offset of a sensor's readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SensorOffset {
    pub(super) joint: usize,
    pub(super) channel: usize,
    /// Value and standard error, rad (m).
    pub(super) value: f64,
    pub(super) standard_error: f64,
}

/// Estimate of a scale of friction laws: a Stribeck velocity, rad/s (m/s), or the sharpness of Coulomb
/// friction, s/rad (s/m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FrictionScale {
    pub(super) joint: usize,
    pub(super) scale: Scale,
    /// Value and standard error.
    pub(super) value: f64,
    pub(super) standard_error: f64,
}
