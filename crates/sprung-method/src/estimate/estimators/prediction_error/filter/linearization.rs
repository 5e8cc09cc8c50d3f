//! Results of a filter run for a replay and for the likelihood of the levels.

use super::accumulate::Sums;
use crate::estimate::estimators::prediction_error::vector::Short;
#[cfg(test)]
use crate::estimate::estimators::prediction_error::vector::scale;

/// Results of a filter run.
#[derive(Clone, Debug)]
pub(crate) struct FilterRun {
    pub(in super::super) sums: Sums,
    /// One per segment.
    pub(in super::super) segments: Vec<SegmentRun>,
}

impl FilterRun {
    /// Replaces the trajectories of all segments.
    pub(in super::super) fn set_trajectories(&mut self, all: Vec<Trajectory>) {
        for (of_segment, trajectory) in self.segments.iter_mut().zip(all) {
            of_segment.trajectory = trajectory;
        }
    }

    /// Returns the results of a run with scaled data: innovations and disturbances times a factor.
    #[cfg(test)]
    pub(in super::super) fn scaled(&self, factor: f64) -> Self {
        let mut other = self.clone();
        for of_segment in &mut other.segments {
            scale(&mut of_segment.trajectory.innovations, factor);
            scale(&mut of_segment.trajectory.disturbances, factor);
        }
        other
    }
}

/// Results of a filter run over one segment.
#[derive(Clone, Debug, Default)]
pub(crate) struct SegmentRun {
    pub(super) schedule: GainSchedule,
    pub(in super::super) trajectory: Trajectory,
    pub(in super::super) linearization: Linearization,
}

impl SegmentRun {
    /// Drops linearization and trajectory; cost and gains stay.
    pub(in super::super) fn drop_linearization(&mut self) {
        self.linearization = Linearization::default();
        self.trajectory = Trajectory::default();
    }

    /// Returns gains and innovation of each measurement.
    ///
    /// - `states`: number of states, \[3 rows\].
    pub(in super::super) fn corrections(
        &self,
        states: usize,
    ) -> impl Iterator<Item = (&[Short], f64)> {
        (self.schedule.gains.chunks(states)).zip(self.trajectory.innovations.iter().copied())
    }

    /// Returns K and 1/S of a measurement.
    pub(in super::super) fn gain(&self, index: usize, states: usize) -> (&[Short], f64) {
        let gains = &self.schedule.gains[index * states..(index + 1) * states];
        (gains, self.schedule.whitening[index].powi(2))
    }
}

/// Quantities that a replay holds.
#[derive(Clone, Debug, Default)]
pub(super) struct GainSchedule {
    /// K of each measurement, \[measurements × 3 rows\].
    pub(super) gains: Vec<Short>,
    /// One over the square root of S of each measurement.
    pub(super) whitening: Vec<f64>,
    /// Steps of the integration in each period.
    pub(super) steps: Vec<u8>,
    /// Corner of the disturbances, Hz.
    pub(super) corner: f64,
}

/// Innovations and disturbances along a trajectory.
#[derive(Clone, Debug, Default)]
pub(crate) struct Trajectory {
    /// e of each measurement.
    pub(super) innovations: Vec<f64>,
    /// d after the measurements of each sample, \[samples × rows\].
    pub(in super::super) disturbances: Vec<f64>,
}

/// Derivatives about the trajectory of a run over one segment.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Linearization {
    /// Corner frequency of the disturbances in the run, Hz.
    pub(in super::super) corner: f64,
    /// F over the period after each sample, without the rows of the disturbances, \[samples × 2
    /// rows × 3 rows\], in single precision to save memory.
    pub(in super::super) transitions: Vec<f32>,
    /// Coordinates and their velocities in the middle of the period after each sample, \[samples ×
    /// 2 rows\].
    pub(in super::super) middles: Vec<f64>,
    /// Nearness of each row's friction to a reversal in the period after each sample, \[samples ×
    /// rows\].
    pub(in super::super) reversals: Vec<f64>,
}
