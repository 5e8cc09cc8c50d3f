//! The filter with the gains of a run.

use super::accumulate::whitened;
use super::linearization::{FilterRun, Trajectory};
use super::measure::innovation;
use super::state::start_state;
use crate::estimate::prediction_error::dynamics::Dynamics;
use crate::estimate::prediction_error::levels::Decay;
use crate::estimate::prediction_error::measurements::Measurements;
use crate::estimate::prediction_error::unknowns::Unknowns;
use crate::estimate::prediction_error::vector::{add, scale};

/// Returns cost and trajectory at other values of the unknowns, with the gains, whitening and
/// integration steps of a run. Returns `None` if a number is not finite.
///
/// ```text
/// e = y − b − H x        x ← x + K e        [q; v] ← Φ(q, v, τ + d, θ)        d ← a d
/// ```
pub(in super::super) fn replay(
    measurements: &Measurements,
    dynamics: &mut Dynamics,
    unknowns: &Unknowns,
    z: &[f64],
    run: &FilterRun,
) -> Option<(f64, Trajectory)> {
    let rows = dynamics.rows();
    dynamics.set(&unknowns.theta(z), unknowns.stribeck_velocities(z));
    let schedule = &run.schedule;
    let held = schedule.gains.chunks(3 * rows).zip(&schedule.whitening);
    let mut held = held.into_iter();
    let mut steps = schedule.steps.iter();
    let mut cost = 0.0;
    let mut torque = vec![0.0; rows];
    let mut trajectory = Trajectory::default();
    let kept = run.trajectory.disturbances.len();
    for segment in &measurements.segments {
        let decay = Decay::new(schedule.corner, segment.period);
        let mut x = start_state(rows, segment, unknowns, z);
        for k in 0..segment.samples() {
            for measurement in segment.at(k) {
                let (gains, whitening) = held.next()?;
                let sensor = &measurements.sensors[measurement.sensor];
                let observation = sensor.observation(measurement, rows);
                let offset = unknowns.offset(z, measurement.sensor);
                let innovation = innovation(&x, measurement, offset, observation);
                cost += whitened(innovation * whitening).powi(2);
                trajectory.innovations.push(innovation);
                add(&mut x, innovation, gains);
            }
            if !cost.is_finite() || !x.iter().all(|x| x.is_finite()) {
                return None;
            }
            let (moving, disturbance) = x.split_at_mut(2 * rows);
            if trajectory.disturbances.len() < kept {
                trajectory.disturbances.extend_from_slice(disturbance);
            }
            segment.write_torque(k, disturbance, &mut torque);
            let steps = steps.next().copied().unwrap_or(1);
            dynamics.advance(moving, &torque, segment.period, usize::from(steps));
            scale(disturbance, decay.factor);
        }
    }
    Some((cost, trajectory))
}
