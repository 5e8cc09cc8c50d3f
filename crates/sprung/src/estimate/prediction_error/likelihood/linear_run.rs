//! A run of the filter, linearised about its trajectory, with other levels.

use crate::estimate::prediction_error::filter::FilterRun;
use crate::estimate::prediction_error::levels::{Decay, Levels};
use crate::estimate::prediction_error::measurements::{Measurement, Measurements, Segment, Sensor};

/// The filter linearised about the trajectory of a run.
pub(super) struct LinearRun<'a> {
    pub(super) run: &'a FilterRun,
    pub(super) levels: &'a Levels,
    pub(super) segments: Vec<LinearSegment<'a>>,
    sensors: &'a [Sensor],
    /// Number of rows of the regressor, and number of states of the filter, \[3 rows\].
    pub(super) rows: usize,
    pub(super) states: usize,
}

impl<'a> LinearRun<'a> {
    /// - `samples`: maximum number of samples whose linearization is used.
    pub(super) fn new(
        measurements: &'a Measurements,
        run: &'a FilterRun,
        samples: usize,
        levels: &'a Levels,
    ) -> Self {
        let rows = levels.disturbance.len();
        let size = 6 * rows * rows;
        let mut transitions = run.linearization.transitions.as_slice();
        let mut reversals = run.linearization.reversals.as_slice();
        let mut left = samples.min(transitions.len() / size);
        let mut segments = Vec::new();
        for segment in &measurements.segments {
            let samples = segment.samples().min(left);
            let (own, others) = transitions.split_at(samples * size);
            (transitions, left) = (others, left - samples);
            let (near, further) = reversals.split_at(samples * rows);
            reversals = further;
            segments.push(LinearSegment {
                segment,
                samples,
                transitions: own,
                reversals: near,
                decay: levels.decay(segment.period),
            });
        }
        Self {
            run,
            levels,
            segments,
            sensors: &measurements.sensors,
            rows,
            states: 3 * rows,
        }
    }

    /// Returns the entries of H for a measurement.
    pub(super) fn observation(
        &self,
        measurement: &Measurement,
    ) -> impl Iterator<Item = (usize, f64)> + Clone {
        self.sensors[measurement.sensor].observation(measurement, self.rows)
    }
}

/// A segment with the transitions of its samples.
pub(super) struct LinearSegment<'a> {
    pub(super) segment: &'a Segment,
    pub(super) samples: usize,
    /// \[samples × 2 rows × 3 rows\].
    transitions: &'a [f64],
    /// \[samples × rows\].
    reversals: &'a [f64],
    pub(super) decay: Decay,
}

impl LinearSegment<'_> {
    /// Returns F over the period after a sample without the rows of the disturbances, \[2 rows × 3
    /// rows\].
    pub(super) fn transition(&self, sample: usize, rows: usize) -> &[f64] {
        let size = 6 * rows * rows;
        &self.transitions[sample * size..(sample + 1) * size]
    }
    /// Returns the period after a sample.
    pub(super) fn period(&self, sample: usize, rows: usize) -> Period<'_> {
        Period {
            transition: self.transition(sample, rows),
            reversals: &self.reversals[sample * rows..(sample + 1) * rows],
            decay: self.decay,
        }
    }
}

/// One period of a linearised run.
#[derive(Clone, Copy)]
pub(super) struct Period<'a> {
    /// F without the rows of the disturbances, \[2 rows × 3 rows\].
    pub(super) transition: &'a [f64],
    /// How near each row's friction is to a reversal, \[rows\].
    pub(super) reversals: &'a [f64],
    pub(super) decay: Decay,
}
