//! The filter over all measurements, with derivatives.

use super::accumulate::Sums;
use super::linearization::{FilterRun, GainSchedule, Linearization, Trajectory};
use super::state::Filter;
use crate::estimate::prediction_error::dynamics::Dynamics;
use crate::estimate::prediction_error::levels::Levels;
use crate::estimate::prediction_error::measurements::Measurements;
use crate::estimate::prediction_error::unknowns::Unknowns;

/// Optional results of a run.
#[derive(Clone, Copy, Debug, Default)]
pub(in super::super) struct Keep {
    /// Number of samples whose linearization is kept, from the first one.
    pub(in super::super) linearized_samples: usize,
    /// Number of samples of a part of the logs, after each of which the gradient is copied; `None`
    /// keeps no copy.
    pub(in super::super) part: Option<usize>,
    /// Number of parts after each of which the normal equations are copied.
    pub(in super::super) parts_of_block: usize,
}

/// Runs the filter over all measurements: measure, accumulate, predict.
///
/// The derivatives hold the gains, so they are the exact derivatives of [`replay`](super::replay).
///
/// - `z`: values of the unknowns.
///
/// Returns `None` if a number is not finite.
pub(in super::super) fn run(
    measurements: &Measurements,
    dynamics: &mut Dynamics,
    unknowns: &Unknowns,
    z: &[f64],
    levels: &Levels,
    keep: Keep,
) -> Option<FilterRun> {
    dynamics.set(&unknowns.theta(z), unknowns.stribeck_velocities(z));
    let mut filter = Filter::new(dynamics, unknowns, z, levels, &measurements.reversals);
    let mut run = FilterRun::new(unknowns.columns(), levels.corner);
    let mut samples = 0;
    let mut begin = 0.0;
    for (index, segment) in measurements.segments.iter().enumerate() {
        filter.start(segment);
        for k in 0..segment.samples() {
            for measurement in segment.at(k) {
                let sensor = &measurements.sensors[measurement.sensor];
                let innovation = filter.measure(sensor, measurement);
                run.sums.accumulate(&innovation);
                run.schedule.gains.extend_from_slice(innovation.gains);
                run.schedule.whitening.push(1.0 / innovation.deviation);
                run.trajectory.innovations.push(innovation.value);
            }
            if !filter.is_finite() || !run.sums.loss.is_finite() {
                return None;
            }
            let linearized = samples < keep.linearized_samples;
            if linearized {
                run.keep_state(&filter);
            }
            let steps = filter.predict(segment, k);
            run.schedule.steps.push(steps as u8);
            if linearized {
                run.keep_period(&filter, segment.period);
                (run.linearization.reversals).extend_from_slice(&filter.reversals);
            }
            samples += 1;
            let Some(part) = keep.part.filter(|part| samples.is_multiple_of(*part)) else {
                continue;
            };
            run.sums.keep_gradient();
            if (samples / part).is_multiple_of(keep.parts_of_block) {
                run.sums.keep(begin + (k + 1) as f64 * segment.period);
            }
        }
        let next = measurements.segments.get(index + 1);
        if measurements.logs() > 1 && next.is_none_or(|next| next.log != segment.log) {
            run.sums.end_log();
        }
        begin += segment.period * segment.samples() as f64;
    }
    Some(run)
}

impl FilterRun {
    fn new(unknowns: usize, corner: f64) -> Self {
        Self {
            sums: Sums::new(unknowns),
            schedule: GainSchedule {
                corner,
                ..GainSchedule::default()
            },
            trajectory: Trajectory::default(),
            linearization: Linearization {
                corner,
                ..Linearization::default()
            },
        }
    }

    /// Keeps the state after the measurements of a sample.
    fn keep_state(&mut self, filter: &Filter<'_>) {
        let (moving, disturbances) = filter.x.split_at(2 * filter.torque.len());
        (self.trajectory.disturbances).extend_from_slice(disturbances);
        self.linearization.middles.extend_from_slice(moving);
    }

    /// Keeps the linearization of the period that follows the kept state.
    fn keep_period(&mut self, filter: &Filter<'_>, period: f64) {
        self.linearization.periods.push(period);
        let moving = 2 * filter.torque.len();
        (self.linearization.transitions).extend_from_slice(&filter.tangent.transition);
        let middles = &mut self.linearization.middles;
        let begin = middles.len() - moving;
        for (middle, end) in middles[begin..].iter_mut().zip(&filter.x) {
            *middle = 0.5 * (*middle + end);
        }
    }
}
