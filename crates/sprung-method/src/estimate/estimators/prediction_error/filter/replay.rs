//! The filter with the gains of a run.

use crate::estimate::estimators::prediction_error::state_layout::state_count;
use rayon::prelude::*;

use super::accumulate::whitened;
use super::linearization::{FilterRun, SegmentRun, Trajectory};
use super::measure::innovation;
use super::state::start_state;
use crate::estimate::estimators::prediction_error::dynamics::Dynamics;
use crate::estimate::estimators::prediction_error::levels::Decay;
use crate::estimate::estimators::prediction_error::measurements::{Measurements, Segment};
use crate::estimate::estimators::prediction_error::unknowns::Unknowns;
use crate::estimate::estimators::prediction_error::vector::{add_short, scale};

/// Returns cost and trajectories at other values of the unknowns, with the gains, whitening and
/// integration steps of a run. Returns `None` if a number is not finite.
///
/// ```text
/// e = y − b − H x        x ← x + K e        [q; v] ← Φ(q, v, τ + d, θ)        d ← a d
/// ```
pub(in super::super) fn replay(
    measurements: &Measurements,
    dynamics: &Dynamics,
    unknowns: &Unknowns,
    z: &[f64],
    run: &FilterRun,
) -> Option<(f64, Vec<Trajectory>)> {
    let mut dynamics = dynamics.clone();
    dynamics.set(&unknowns.theta(z), unknowns.scales(z));
    let each: Option<Vec<(f64, Trajectory)>> = (measurements.segments.par_iter())
        .zip(&run.segments)
        .with_max_len(1)
        .map(|(segment, of_segment)| {
            let start = start_state(dynamics.rows(), segment, unknowns, z);
            let mut dynamics = dynamics.clone();
            dynamics.carry(segment.carried.as_deref());
            let mut replay = Replay {
                measurements,
                dynamics,
                unknowns,
                z,
                x: start,
            };
            replay.over(segment, of_segment)
        })
        .collect();
    let (costs, trajectories): (Vec<f64>, Vec<Trajectory>) = each?.into_iter().unzip();
    Some((costs.iter().sum(), trajectories))
}

/// The filter at one instant.
struct Replay<'a> {
    measurements: &'a Measurements,
    dynamics: Dynamics,
    unknowns: &'a Unknowns,
    z: &'a [f64],
    /// x, \[3 rows\].
    x: Vec<f64>,
}

impl Replay<'_> {
    /// Returns cost and trajectory of a segment.
    fn over(&mut self, segment: &Segment, run: &SegmentRun) -> Option<(f64, Trajectory)> {
        let rows = self.dynamics.rows();
        let schedule = &run.schedule;
        let decay = Decay::new(schedule.corner, segment.period);
        let held = schedule
            .gains
            .chunks(state_count(rows))
            .zip(&schedule.whitening);
        let mut held = held.into_iter();
        let mut cost = 0.0;
        let mut torque = vec![0.0; rows];
        let mut trajectory = Trajectory::default();
        let keeps = !run.trajectory.innovations.is_empty();
        let x = &mut self.x;
        for (k, &steps) in schedule.steps.iter().enumerate() {
            for measurement in segment.at(k) {
                let (gains, whitening) = held.next()?;
                let sensor = &self.measurements.sensors[measurement.sensor];
                let observation = sensor.observation(measurement, rows);
                let state = (x.as_slice(), rows);
                let measured = (sensor, measurement);
                let offset = (self.unknowns).beyond_observation(self.z, measured, state);
                let innovation = innovation(x, measurement, offset, observation);
                if segment.counts(k) {
                    cost += whitened(innovation * whitening).powi(2);
                }
                if keeps {
                    trajectory.innovations.push(innovation);
                }
                add_short(x, innovation, gains);
            }
            if !cost.is_finite() || !x.iter().all(|x| x.is_finite()) {
                return None;
            }
            let (moving, disturbance) = x.split_at_mut(2 * rows);
            if keeps {
                trajectory.disturbances.extend_from_slice(disturbance);
            }
            segment.write_torque(k, disturbance, &mut torque);
            self.dynamics.set_known(segment.known(k));
            self.dynamics.set_ramp(segment.ramp(k));
            (self.dynamics).advance(moving, &torque, segment.period, usize::from(steps));
            scale(disturbance, decay.factor);
        }
        Some((cost, trajectory))
    }
}
