//! Information that later measurements contain about the state of a run.

use sprung_core::linear::dot;

use super::linear_run::LinearRun;
use crate::estimate::estimators::prediction_error::covariance::{
    AdjointMemory, adjoint_covariance, adjoint_product,
};
use crate::estimate::estimators::prediction_error::filter::SegmentRun;
use crate::estimate::estimators::prediction_error::levels::Levels;
use crate::estimate::estimators::prediction_error::matrix::add_rows;
use crate::estimate::estimators::prediction_error::measurements::{Measurement, Segment, Sensor};
use crate::estimate::estimators::prediction_error::vector::widen;

/// Visits the samples of a segment, the last one first. The arguments are the sample's index, the
/// information N of later measurements about the state at the end of the period after the sample,
/// \[states × states\], and F over this period.
///
/// ```text
/// over a period        N ← Fᵀ N F
/// over a measurement   N ← (1 − K H)ᵀ N (1 − K H) + Hᵀ H / S
/// ```
///
/// - `run`: with the linearization, at `levels`.
///
/// # Source
///
/// de Jong, Annals of Statistics 1988: the recursion of N.
pub(in super::super) fn information_ahead(
    sensors: &[Sensor],
    segment: &Segment,
    run: &SegmentRun,
    levels: &Levels,
    mut visit: impl FnMut(usize, &[f64], &[f64]),
) {
    let linear = LinearRun::new(sensors, segment, run, levels);
    let states = linear.states;
    let mut information = vec![0.0; states * states];
    let mut product = vec![0.0; states * states];
    let (mut gains, mut transition) = (Vec::new(), Vec::new());
    let mut moved = vec![0.0; states];
    let mut memory = AdjointMemory::new(linear.rows);
    for k in (0..segment.samples()).rev() {
        let period = linear.period(k, &mut transition);
        let (transition, decay) = (period.transition, period.decay.factor);
        visit(k, &information, transition);
        adjoint_product(&information, transition, decay, &mut product, &mut memory);
        adjoint_covariance(&product, transition, decay, &mut information, &mut memory);
        let range = segment.first[k]..segment.first[k + 1];
        for (index, measurement) in range.clone().zip(&segment.measurements[range]).rev() {
            let counts = segment.counts(k);
            let (short, inverse_variance) = run.gain(index, states);
            widen(&mut gains, short);
            let gain = (gains.as_slice(), inverse_variance);
            linear.back(&mut information, &mut moved, (measurement, counts), gain);
        }
    }
}

impl LinearRun<'_> {
    /// Takes the information back over a measurement.
    ///
    /// - `counts`: whether the measurement is information; otherwise it only moves the state.
    /// - `gains`: K, \[states\]; `inverse_variance`: 1/S.
    fn back(
        &self,
        information: &mut [f64],
        moved: &mut [f64],
        (measurement, counts): (&Measurement, bool),
        (gains, inverse_variance): (&[f64], f64),
    ) {
        let states = self.states;
        // N K; N is symmetric.
        moved.fill(0.0);
        add_rows(moved, gains, information);
        let added = if counts { inverse_variance } else { 0.0 };
        let both = added + dot(moved, gains);
        let observation = self.observation(measurement);
        for (state, weight) in observation.clone() {
            for (i, moved) in moved.iter().enumerate() {
                information[state * states + i] -= weight * moved;
                information[i * states + state] -= weight * moved;
            }
            for (other, by) in observation.clone() {
                information[state * states + other] += both * weight * by;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::estimators::prediction_error::covariance::propagate_state;
    use crate::estimate::estimators::prediction_error::levels::Disturbances;
    use crate::estimate::estimators::prediction_error::measurements::observe;
    use crate::estimate::estimators::prediction_error::tests::{Case, search_of};

    /// Returns the sum of squares of the whitened innovations that a deviation of the state at the
    /// end of the period after a sample causes.
    fn squares(linear: &LinearRun<'_>, sample: usize, deviation: &[f64]) -> f64 {
        let (segment, states) = (linear.segment, linear.states);
        let (mut x, mut memory) = (deviation.to_vec(), vec![0.0; states]);
        let (mut transition, mut gains) = (Vec::new(), Vec::new());
        let mut sum = 0.0;
        for k in sample + 1..segment.samples() {
            for index in segment.first[k]..segment.first[k + 1] {
                let measurement = &segment.measurements[index];
                let moved = observe(&x, linear.observation(measurement));
                let (short, inverse_variance) = linear.run.gain(index, states);
                widen(&mut gains, short);
                sum += moved * moved * inverse_variance;
                for (x, gain) in x.iter_mut().zip(&gains) {
                    *x -= moved * gain;
                }
            }
            let period = linear.period(k, &mut transition);
            propagate_state(&mut x, period.transition, period.decay.factor, &mut memory);
        }
        sum
    }

    #[test]
    fn information_is_the_sum_of_squares_of_later_innovations() {
        let case = Case::new();
        let (run, _) = search_of(&case, Disturbances::Free);
        let (sensors, segment) = (&case.measurements.sensors, &case.measurements.segments[0]);
        let linear = LinearRun::new(sensors, segment, &run.segments[0], &case.levels);
        let states = linear.states;
        let sample = segment.samples() / 2;
        let mut compared = 0;
        information_ahead(
            sensors,
            segment,
            &run.segments[0],
            &case.levels,
            |k, information, _| {
                if k != sample {
                    return;
                }
                for i in 0..states {
                    let mut deviation = vec![0.0; states];
                    deviation[i] = 1.0;
                    let expected = squares(&linear, k, &deviation);
                    let found = information[i * (states + 1)];
                    assert!(
                        (found - expected).abs() < 1e-9 * expected,
                        "state {i}: {found} instead of {expected}"
                    );
                    compared += 1;
                }
            },
        );
        assert_eq!(compared, states);
    }
}
