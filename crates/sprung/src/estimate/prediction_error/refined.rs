//! What a refinement finds.

use super::delay_updates::DelayUpdate;
use super::descent::Ending;
use crate::model::Theta;

/// What a refinement finds.
#[derive(Clone, Debug)]
pub(super) struct Refined {
    /// The parameter vector, known values included, \[p\].
    pub(super) theta: Theta,
    /// Standard error of each parameter; zero for known ones, infinite where the
    /// log says nothing.
    pub(super) standard_error: Vec<f64>,
    /// Indices in theta of the parameters that were refined.
    pub(super) free: Vec<usize>,
    /// Covariance of these, \[free × free\].
    pub(super) covariance: Vec<f64>,
    /// Why the search ended.
    pub(super) ending: Ending,
    /// Runs of the filter.
    pub(super) runs: usize,
    /// The parameters, index in theta, that moved last, and by how many standard
    /// errors, the largest first.
    pub(super) moved: Vec<(usize, f64)>,
    /// Minus the logarithm of the likelihood, without its constant.
    pub(super) loss: f64,
    /// Measurements that were used.
    pub(super) measurements: u64,
    /// Samples that were used.
    pub(super) samples: usize,
    /// Time that they span, s.
    pub(super) duration: f64,
    /// Whether the logs hold more.
    pub(super) left_out: bool,
    /// Levels of noise and disturbances, one per row of the regressor.
    pub(super) levels: Vec<RowLevel>,
    /// Corner of the disturbances' spectrum, Hz.
    pub(super) corner: f64,
    /// Noise of sensors beyond what their samples show.
    pub(super) sensors: Vec<SensorLevel>,
    /// Whitened innovations squared, mean.
    pub(super) cost: f64,
    /// By how much sensors read too much.
    pub(super) offsets: Vec<SensorOffset>,
    /// What the log says of delays, one per channel.
    pub(super) delays: Vec<DelayUpdate>,
    /// Parameter vectors of growing parts of the log, by their end in s.
    pub(super) trace: Vec<(f64, Theta)>,
    /// What each of several logs says alone: value and standard error of each
    /// refined parameter.
    pub(super) logs: Vec<Vec<(f64, f64)>>,
}

impl Refined {
    /// Returns whether the search ended by itself.
    pub(super) fn converged(&self) -> bool {
        match self.ending {
            Ending::Converged => true,
            Ending::AtBound | Ending::OutOfRuns => false,
        }
    }
}

/// Noise and disturbance of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RowLevel {
    /// Standard deviation of white torque noise, N·m (N); zero in link rows.
    pub(super) torque_noise: f64,
    /// Standard deviation of the disturbance, N·m (N).
    pub(super) disturbance: f64,
    /// Standard deviation of the torque of the row's joint, N·m (N).
    pub(super) torque: f64,
    /// Whether the disturbance ended at its upper bound.
    pub(super) at_bound: bool,
}

/// Noise of a sensor beyond what its samples show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SensorLevel {
    pub(super) channel: usize,
    /// Standard deviation, rad (m).
    pub(super) noise: f64,
    /// Standard deviation of what it shows, rad (m).
    pub(super) scale: f64,
}

/// By how much a sensor reads too much.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SensorOffset {
    pub(super) joint: usize,
    pub(super) channel: usize,
    /// Value and standard error, rad (m).
    pub(super) value: f64,
    pub(super) standard_error: f64,
}
