//! The filter over all measurements, with derivatives.

use crate::estimate::estimators::prediction_error::state_layout::{state_count, transition_size};
use rayon::prelude::*;

use super::accumulate::Sums;
use super::linearization::{FilterRun, GainSchedule, Linearization, SegmentRun, Trajectory};
use super::state::Filter;
use crate::estimate::estimators::prediction_error::dynamics::Dynamics;
use crate::estimate::estimators::prediction_error::levels::Levels;
use crate::estimate::estimators::prediction_error::measurements::{Measurements, Segment};
use crate::estimate::estimators::prediction_error::unknowns::Unknowns;
use crate::estimate::estimators::prediction_error::vector::{Short, extend_single};

/// Optional results of a run.
#[derive(Clone, Copy, Debug, Default)]
pub(in super::super) struct Keep {
    /// Whether the linearization is kept.
    pub(in super::super) linearization: bool,
    /// Number of samples of a part of the logs, after each of which the gradient is copied; `None`
    /// keeps no copy.
    pub(in super::super) part: Option<usize>,
    /// Number of parts after each of which the normal equations are copied.
    pub(in super::super) parts_of_fold: usize,
}

/// Runs the filter over all measurements: measure, accumulate, predict. Segments run in parallel, and
/// their sums are added in their order, so the result does not depend on the number of threads.
///
/// The derivatives hold the gains, so they are those of [`replay`](super::replay).
///
/// - `dynamics`: of the model; its parameters are replaced.
/// - `z`: values of the unknowns.
/// - `each`: is called with the index and the run of each segment, from several threads. It may
///   drop values that are not needed later.
///
/// Returns the run, and the results of `each` in the order of the segments; `None` if a number is
/// not finite.
pub(in super::super) fn run<T: Send>(
    measurements: &Measurements,
    dynamics: &Dynamics,
    unknowns: &Unknowns,
    (z, levels): (&[f64], &Levels),
    keep: Keep,
    each: impl Fn(usize, &mut SegmentRun) -> T + Sync,
) -> Option<(FilterRun, Vec<T>)> {
    let mut dynamics = dynamics.clone();
    dynamics.set(&unknowns.theta(z), unknowns.scales(z));
    let starts = measurements.starts();
    let found: Option<Vec<(Sums, SegmentRun, T)>> = (measurements.segments.par_iter())
        .zip(&starts)
        .enumerate()
        .with_max_len(1)
        .map(|(index, (segment, start))| {
            let mut dynamics = dynamics.clone();
            dynamics.carry(segment.carried.as_deref());
            let filter = Filter::new(&mut dynamics, unknowns, z, levels, &measurements.reversals);
            let (sums, mut run) = run_segment(measurements, filter, segment, *start, keep)?;
            let result = each(index, &mut run);
            Some((sums, run, result))
        })
        .collect();
    let mut results = Vec::with_capacity(measurements.segments.len());
    let mut run = FilterRun {
        sums: Sums::new(unknowns.columns()),
        segments: Vec::new(),
    };
    for (index, (sums, of_segment, result)) in found?.into_iter().enumerate() {
        run.sums.append(sums);
        run.segments.push(of_segment);
        results.push(result);
        let next = measurements.segments.get(index + 1);
        let log = measurements.segments[index].log;
        if measurements.logs() > 1 && next.is_none_or(|next| next.log != log) {
            run.sums.end_log();
        }
    }
    Some((run, results))
}

/// Runs the filter over one segment. Returns `None` if a number is not finite.
///
/// - `filter`: with any state.
/// - `before`, `begin`: number and time of the samples that count before the segment, s.
fn run_segment(
    measurements: &Measurements,
    mut filter: Filter<'_>,
    segment: &Segment,
    (before, begin): (usize, f64),
    keep: Keep,
) -> Option<(Sums, SegmentRun)> {
    let mut sums = Sums::new(filter.unknowns.columns());
    let rows = filter.torque.len();
    let mut run = SegmentRun::with_room(segment, rows, filter.levels.corner, keep.linearization);
    filter.start(segment);
    for k in 0..segment.samples() {
        for measurement in segment.at(k) {
            let sensor = &measurements.sensors[measurement.sensor];
            let innovation = filter.measure(sensor, measurement);
            if segment.counts(k) {
                sums.accumulate(&innovation);
            }
            let gains = innovation.gains.iter().map(|gain| Short::new(*gain));
            run.schedule.gains.extend(gains);
            run.schedule.whitening.push(1.0 / innovation.deviation);
            run.trajectory.innovations.push(innovation.value);
        }
        filter.correct();
        if !filter.is_finite() || !sums.loss.is_finite() {
            return None;
        }
        if keep.linearization {
            run.keep_state(&filter);
        }
        let steps = filter.predict(segment, k);
        run.schedule.steps.push(steps as u8);
        if keep.linearization {
            run.keep_period(&filter);
        }
        if let (Some(part), true) = (keep.part, segment.counts(k)) {
            let counted = k + 1 - segment.burn_in;
            let parts = (before + counted) / part;
            if (before + counted).is_multiple_of(part) {
                sums.keep_gradient();
                if parts.is_multiple_of(keep.parts_of_fold) {
                    sums.keep(begin + counted as f64 * segment.period);
                }
            }
        }
    }
    sums.complete();
    Some((sums, run))
}

impl SegmentRun {
    /// Returns an empty run of a segment.
    ///
    /// - `linearized`: whether it will contain the linearization.
    fn with_room(segment: &Segment, rows: usize, corner: f64, linearized: bool) -> Self {
        let (samples, count) = (segment.samples(), segment.measurements.len());
        let kept = if linearized { samples } else { 0 };
        Self {
            schedule: GainSchedule {
                gains: Vec::with_capacity(state_count(rows) * count),
                whitening: Vec::with_capacity(count),
                steps: Vec::with_capacity(samples),
                corner,
            },
            trajectory: Trajectory {
                innovations: Vec::with_capacity(count),
                disturbances: Vec::with_capacity(kept * rows),
            },
            linearization: Linearization {
                corner,
                transitions: Vec::with_capacity(transition_size(rows) * kept),
                middles: Vec::with_capacity(2 * rows * kept),
                reversals: Vec::with_capacity(rows * kept),
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
    fn keep_period(&mut self, filter: &Filter<'_>) {
        let moving = 2 * filter.torque.len();
        let linearization = &mut self.linearization;
        let transition = filter.tangent.transition.iter().copied();
        extend_single(&mut linearization.transitions, transition);
        (linearization.reversals).extend_from_slice(&filter.reversals);
        let begin = linearization.middles.len() - moving;
        for (middle, end) in linearization.middles[begin..].iter_mut().zip(&filter.x) {
            *middle = 0.5 * (*middle + end);
        }
    }
}
