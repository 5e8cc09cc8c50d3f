//! Information that later measurements contain about the state of a run.

use super::linear_run::LinearRun;
use crate::estimate::prediction_error::covariance::{
    AdjointMemory, adjoint_covariance, adjoint_product,
};
use crate::estimate::prediction_error::filter::StretchRun;
use crate::estimate::prediction_error::levels::Levels;
use crate::estimate::prediction_error::matrix::add_rows;
use crate::estimate::prediction_error::measurements::{Measurement, Segment, Sensor};
use crate::estimate::prediction_error::vector::{dot, widen};

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
    run: &StretchRun,
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
        let own = segment.first[k]..segment.first[k + 1];
        for (index, measurement) in own.clone().zip(&segment.measurements[own]).rev() {
            let counts = segment.counts(k);
            let (single, inverse_variance) = run.gain(index, states);
            widen(&mut gains, single);
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
        let own = if counts { inverse_variance } else { 0.0 };
        let both = own + dot(moved, gains);
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
