//! A run of the filter over a segment, linearised about its trajectory, with other levels.

use crate::estimate::estimators::prediction_error::filter::SegmentRun;
use crate::estimate::estimators::prediction_error::levels::{Decay, Levels};
use crate::estimate::estimators::prediction_error::measurements::{Measurement, Segment, Sensor};
use crate::estimate::estimators::prediction_error::state_layout::{state_count, transition_size};
use crate::estimate::estimators::prediction_error::vector::widen;

/// The filter over a segment, linearised about the trajectory of a run.
pub(super) struct LinearRun<'a> {
    pub(super) run: &'a SegmentRun,
    pub(super) levels: &'a Levels,
    pub(super) segment: &'a Segment,
    /// Number of samples that are used, from the first one.
    pub(super) samples: usize,
    sensors: &'a [Sensor],
    pub(super) decay: Decay,
    /// Number of rows of the regressor, and number of states of the filter, \[3 rows\].
    pub(super) rows: usize,
    pub(super) states: usize,
}

impl<'a> LinearRun<'a> {
    pub(super) fn new(
        sensors: &'a [Sensor],
        segment: &'a Segment,
        run: &'a SegmentRun,
        levels: &'a Levels,
    ) -> Self {
        let rows = levels.disturbance.len();
        Self {
            run,
            levels,
            segment,
            samples: segment.samples(),
            sensors,
            decay: levels.decay(segment.period),
            rows,
            states: state_count(rows),
        }
    }

    /// Leaves out the end of the segment.
    ///
    /// - `share`: fraction of the samples that are used.
    pub(super) fn beginning(self, share: f64) -> Self {
        Self {
            samples: (share * self.segment.samples() as f64).ceil() as usize,
            ..self
        }
    }

    /// Returns the entries of H for a measurement.
    pub(super) fn observation(
        &self,
        measurement: &Measurement,
    ) -> impl Iterator<Item = (usize, f64)> + Clone {
        self.sensors[measurement.sensor].observation(measurement, self.rows)
    }

    /// Returns the period after a sample.
    ///
    /// - `memory`: for its transition.
    pub(super) fn period<'p>(&'p self, sample: usize, memory: &'p mut Vec<f64>) -> Period<'p> {
        let (rows, size) = (self.rows, transition_size(self.rows));
        let linearization = &self.run.linearization;
        let single = &linearization.transitions[sample * size..(sample + 1) * size];
        widen(memory, single);
        Period {
            transition: memory,
            reversals: &linearization.reversals[sample * rows..(sample + 1) * rows],
            decay: self.decay,
        }
    }
}

/// One period of a linearised run.
#[derive(Clone, Copy)]
pub(super) struct Period<'a> {
    /// F without the rows of the disturbances, \[2 rows × 3 rows\].
    pub(super) transition: &'a [f64],
    /// Nearness of each row's friction to a reversal, \[rows\].
    pub(super) reversals: &'a [f64],
    pub(super) decay: Decay,
}
