//! Measurements of positions, in the order in which the filter processes them.

use super::measurement::Measurement;
use super::sensor::Sensor;
use crate::estimate::prediction_error::reversals::Reversals;

/// Consecutive samples of one log.
#[derive(Clone, Debug)]
pub(in super::super) struct Segment {
    /// Index of the log.
    pub(in super::super) log: usize,
    /// Sampling period, s.
    pub(in super::super) period: f64,
    /// Torque on each row, N·m (N), \[samples × rows\].
    pub(in super::super) torque: Vec<f64>,
    /// Rate of the smoothed torque, N·m/s. Noise of an unsmoothed rate would look like information
    /// about delays.
    pub(in super::super) torque_rate: Vec<f64>,
    pub(in super::super) measurements: Vec<Measurement>,
    /// Index of the first measurement of each sample, then the number of measurements.
    pub(in super::super) first: Vec<usize>,
    /// Positions and velocities of the rows at the first sample, \[2 rows\].
    pub(in super::super) start: Vec<f64>,
    /// Standard deviations of `start`.
    pub(in super::super) start_deviation: Vec<f64>,
    /// Root mean square velocity of each sensor, rad/s (m/s).
    pub(in super::super) speeds: Vec<f64>,
}

impl Segment {
    /// Returns the number of samples.
    pub(in super::super) fn samples(&self) -> usize {
        self.first.len() - 1
    }

    /// Returns the measurements of a sample.
    pub(in super::super) fn at(&self, sample: usize) -> &[Measurement] {
        &self.measurements[self.first[sample]..self.first[sample + 1]]
    }

    /// Writes the torque that acts during a period: the logged torque plus the disturbance,
    /// \[rows\].
    pub(in super::super) fn write_torque(
        &self,
        sample: usize,
        disturbance: &[f64],
        torque: &mut [f64],
    ) {
        let rows = disturbance.len();
        let own = &self.torque[sample * rows..(sample + 1) * rows];
        for (sum, (tau, disturbance)) in torque.iter_mut().zip(own.iter().zip(disturbance)) {
            *sum = tau + disturbance;
        }
    }
}

/// The logs in the form that the filter processes.
#[derive(Clone, Debug)]
pub(in super::super) struct Measurements {
    pub(in super::super) sensors: Vec<Sensor>,
    pub(in super::super) segments: Vec<Segment>,
    /// Standard deviation of the torque of each row's joint, N·m (N).
    pub(in super::super) torque_scale: Vec<f64>,
    /// Velocities at which the Coulomb friction of each row reverses.
    pub(in super::super) reversals: Reversals,
    /// White noise of the logged torque on each row by its fast changes, N·m (N); an upper limit of
    /// the noise of the log.
    pub(in super::super) fast_noise: Vec<f64>,
    /// Whether the logs contain more samples.
    pub(in super::super) left_out: bool,
}

impl Measurements {
    /// Returns the number of samples.
    pub(in super::super) fn samples(&self) -> usize {
        self.segments.iter().map(Segment::samples).sum()
    }

    /// Returns the number of logs.
    pub(in super::super) fn logs(&self) -> usize {
        self.segments.last().map_or(0, |segment| segment.log + 1)
    }

    /// Returns the index of each sample's log.
    pub(in super::super) fn log_of_samples(&self) -> Vec<usize> {
        (self.segments.iter())
            .flat_map(|segment| std::iter::repeat_n(segment.log, segment.samples()))
            .collect()
    }

    /// Returns the time that the samples span, s.
    pub(in super::super) fn duration(&self) -> f64 {
        let span = |segment: &Segment| segment.period * segment.samples() as f64;
        self.segments.iter().map(span).sum()
    }
}
