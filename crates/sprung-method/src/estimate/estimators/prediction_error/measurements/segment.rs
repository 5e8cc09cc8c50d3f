//! Measurements of positions, in the order in which the filter processes them.

use std::sync::Arc;

use super::measurement::Measurement;
use super::sensor::Sensor;
use crate::estimate::estimators::prediction_error::reversals::Reversals;

/// Consecutive samples of one log, which the filter processes without the samples before: a segment
/// without a gap, or a part of it.
#[derive(Clone, Debug)]
pub(in super::super) struct Segment {
    /// Index of the log.
    pub(in super::super) log: usize,
    /// Change of the parameters by the known payload of the log, \[p\].
    pub(in super::super) carried: Option<Arc<[f64]>>,
    /// Number of samples at the beginning that only bring the filter to its state. The segment before counts their
    /// measurements.
    pub(in super::super) burn_in: usize,
    /// Sampling period, s.
    pub(in super::super) period: f64,
    /// Place of the first sample that counts among all samples that count, from 0 to 1, and that of the end.
    pub(in super::super) span: [f64; 2],
    /// Torque on each row, N·m (N), \[samples × rows\].
    pub(in super::super) torque: Vec<f64>,
    /// Rate of the smoothed torque, N·m/s. Noise of an unsmoothed rate would act as information
    /// about delays.
    pub(in super::super) torque_rate: Vec<f64>,
    /// Share of each row's torque rate that acts within a period, \[rows\]; empty if the torques are held.
    pub(in super::super) moving: Arc<[f64]>,
    /// Covariates of the joints minus their references, \[samples × n × covariates\]; empty if no
    /// friction depends on any.
    pub(in super::super) excess: Vec<f64>,
    /// Elements of presliding friction and hysteresis in the middle of each period, \[samples × n × elements\]; empty if no
    /// joint has any.
    pub(in super::super) elements: Vec<f64>,
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

    /// Returns the place of a sample among all samples that count, from 0 to 1.
    pub(in super::super) fn share(&self, sample: usize) -> f64 {
        let [begin, end] = self.span;
        let share = (sample as f64 - self.burn_in as f64) / self.counted().max(1) as f64;
        begin + share * (end - begin)
    }

    /// Returns whether the measurements of a sample count.
    pub(in super::super) fn counts(&self, sample: usize) -> bool {
        sample >= self.burn_in
    }

    /// Returns the number of samples whose measurements count.
    pub(in super::super) fn counted(&self) -> usize {
        self.samples() - self.burn_in
    }

    /// Returns the measurements of a sample.
    pub(in super::super) fn at(&self, sample: usize) -> &[Measurement] {
        &self.measurements[self.first[sample]..self.first[sample + 1]]
    }

    /// Returns the first samples, all of which count.
    pub(in super::super) fn beginning(&self, samples: usize) -> Self {
        let samples = samples.min(self.samples());
        let rows = self.torque.len() / self.samples().max(1);
        Self {
            burn_in: 0,
            carried: self.carried.clone(),
            moving: self.moving.clone(),
            torque: self.torque[..samples * rows].to_vec(),
            torque_rate: self.torque_rate[..samples * rows].to_vec(),
            excess: self.excess[..samples * self.per_sample(&self.excess)].to_vec(),
            elements: self.elements[..samples * self.per_sample(&self.elements)].to_vec(),
            measurements: self.measurements[..self.first[samples]].to_vec(),
            first: self.first[..=samples].to_vec(),
            start: self.start.clone(),
            start_deviation: self.start_deviation.clone(),
            speeds: self.speeds.clone(),
            ..*self
        }
    }

    fn per_sample(&self, all: &[f64]) -> usize {
        all.len() / self.samples().max(1)
    }

    /// Returns the covariates of a sample minus their references, and the elements of presliding friction and hysteresis; both are
    /// empty if nothing depends on any.
    pub(in super::super) fn known(&self, sample: usize) -> [&[f64]; 2] {
        [&self.excess, &self.elements].map(|all| {
            let width = self.per_sample(all);
            &all[sample * width..(sample + 1) * width]
        })
    }

    /// Returns the rate of the torque within a period, N·m/s (N/s), \[rows\]; empty if the torques are held.
    pub(in super::super) fn ramp(&self, sample: usize) -> impl Iterator<Item = f64> {
        let rates = self.torque_rate[sample * self.moving.len()..].iter();
        (self.moving.iter().zip(rates)).map(|(share, rate)| share * rate)
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
        let logged = &self.torque[sample * rows..(sample + 1) * rows];
        for (sum, (tau, disturbance)) in torque.iter_mut().zip(logged.iter().zip(disturbance)) {
            *sum = tau + disturbance;
        }
    }
}

/// The logs in the form that the filter processes.
#[derive(Clone, Debug)]
pub(in super::super) struct Measurements {
    pub(in super::super) sensors: Vec<Sensor>,
    pub(in super::super) segments: Arc<Vec<Segment>>,
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
    /// Returns the same sensors and scales without samples.
    pub(in super::super) fn without_segments(&self) -> Self {
        Self {
            sensors: self.sensors.clone(),
            segments: Arc::default(),
            torque_scale: self.torque_scale.clone(),
            reversals: self.reversals.clone(),
            fast_noise: self.fast_noise.clone(),
            left_out: self.left_out,
        }
    }

    /// Returns the number of samples whose measurements count.
    pub(in super::super) fn samples(&self) -> usize {
        self.segments.iter().map(Segment::counted).sum()
    }

    /// Returns for each segment the samples that count before it: their number and their time, s.
    pub(in super::super) fn starts(&self) -> Vec<(usize, f64)> {
        let starts = self.segments.iter().scan((0, 0.0), |next, segment| {
            let start = *next;
            next.0 += segment.counted();
            next.1 += segment.counted() as f64 * segment.period;
            Some(start)
        });
        starts.collect()
    }

    /// Returns the number of logs.
    pub(in super::super) fn logs(&self) -> usize {
        self.segments.last().map_or(0, |segment| segment.log + 1)
    }

    /// Returns the time that the samples span whose measurements count, s.
    pub(in super::super) fn duration(&self) -> f64 {
        let span = |segment: &Segment| segment.period * segment.counted() as f64;
        self.segments.iter().map(span).sum()
    }
}
