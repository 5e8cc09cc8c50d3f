//! Covariance of a run's state by noise of the logged torque.

use super::linear_run::LinearRun;
use crate::estimate::estimators::prediction_error::covariance::{Propagation, propagate};
use crate::estimate::estimators::prediction_error::filter::SegmentRun;
use crate::estimate::estimators::prediction_error::levels::Levels;
use crate::estimate::estimators::prediction_error::matrix::add_outer;
use crate::estimate::estimators::prediction_error::measurements::{Segment, Sensor, observe};
use crate::estimate::estimators::prediction_error::vector::{add, extend_single, widen};

/// Returns the covariance of the state after the measurements of every n-th sample by noise of the
/// logged torque before it, \[samples/n × states × states\], in single precision to save memory.
///
/// ```text
/// over a measurement   M ← (1 − K H) M (1 − K H)ᵀ
/// over a period        M ← F M Fᵀ + F_τ diag(σ²) F_τᵀ
/// ```
///
/// - `run`: with the linearization, at `levels`.
/// - `noise`: σ, N·m (N), \[rows\]; `stride`: n.
pub(in super::super) fn noise_behind(
    sensors: &[Sensor],
    segment: &Segment,
    run: &SegmentRun,
    levels: &Levels,
    (noise, stride): (&[f64], usize),
) -> Vec<f32> {
    let of_noise = Levels {
        torque_noise: noise.to_vec(),
        reversal_noise: vec![0.0; noise.len()],
        disturbance: vec![0.0; noise.len()],
        ..levels.clone()
    };
    let linear = LinearRun::new(sensors, segment, run, &of_noise);
    let states = linear.states;
    let mut covariance = vec![0.0; states * states];
    let mut kept = Vec::with_capacity(segment.samples().div_ceil(stride) * states * states);
    let (mut gains, mut transition) = (Vec::new(), Vec::new());
    let mut cross = vec![0.0; states];
    let mut memory = Propagation::new(linear.rows);
    for k in 0..segment.samples() {
        let range = segment.first[k]..segment.first[k + 1];
        for (index, measurement) in range.clone().zip(&segment.measurements[range]) {
            widen(&mut gains, run.gain(index, states).0);
            cross.fill(0.0);
            for (state, weight) in linear.observation(measurement) {
                let row = &covariance[state * states..(state + 1) * states];
                add(&mut cross, weight, row);
            }
            let variance = observe(&cross, linear.observation(measurement));
            add(&mut cross, -0.5 * variance, &gains);
            add_outer(&mut covariance, -1.0, &gains, &cross);
            add_outer(&mut covariance, -1.0, &cross, &gains);
        }
        if k.is_multiple_of(stride) {
            extend_single(&mut kept, covariance.iter().copied());
        }
        let period = linear.period(k, &mut transition);
        propagate(
            &mut covariance,
            period.transition,
            &of_noise,
            period.reversals,
            period.decay,
            &mut memory,
        );
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::estimators::prediction_error::covariance::propagate_state;
    use crate::estimate::estimators::prediction_error::levels::Disturbances;
    use crate::estimate::estimators::prediction_error::tests::{Case, search_of};

    #[test]
    fn covariance_is_the_sum_of_squares_of_the_deviations_by_earlier_torques() {
        const LAST: usize = 40;
        let case = Case::new();
        let (run, _) = search_of(&case, Disturbances::Free);
        let (sensors, segment) = (&case.measurements.sensors, &case.measurements.segments[0]);
        let run = &run.segments[0];
        let noise = [0.0, 0.0, 0.3, 0.03];
        let linear = LinearRun::new(sensors, segment, run, &case.levels);
        let states = linear.states;
        let mut expected = vec![0.0; states * states];
        let (mut transition, mut gains) = (Vec::new(), Vec::new());
        let mut memory = vec![0.0; states];
        for (row, noise) in noise.iter().enumerate() {
            for first in 0..LAST {
                // The deviation by the noise of one period.
                let mut x = vec![0.0; states];
                for k in first..=LAST {
                    for index in segment.first[k]..segment.first[k + 1] {
                        let measurement = &segment.measurements[index];
                        let moved = observe(&x, linear.observation(measurement));
                        widen(&mut gains, run.gain(index, states).0);
                        add(&mut x, -moved, &gains);
                    }
                    if k == LAST {
                        break;
                    }
                    let period = linear.period(k, &mut transition);
                    propagate_state(&mut x, period.transition, period.decay.factor, &mut memory);
                    if k == first {
                        let by_torque = period.transition.chunks(states);
                        for (x, by) in x.iter_mut().zip(by_torque) {
                            *x += noise * by[2 * linear.rows + row];
                        }
                    }
                }
                add_outer(&mut expected, 1.0, &x, &x);
            }
        }
        let found = noise_behind(sensors, segment, run, &case.levels, (&noise, LAST));
        let found = &found[states * states..2 * states * states];
        for i in 0..states {
            for j in 0..states {
                let scale = (expected[i * (states + 1)] * expected[j * (states + 1)]).sqrt();
                let [found, expected] =
                    [f64::from(found[i * states + j]), expected[i * states + j]];
                assert!(
                    (found - expected).abs() <= 1e-6 * scale,
                    "{i}, {j}: {found} instead of {expected}"
                );
            }
        }
    }
}
