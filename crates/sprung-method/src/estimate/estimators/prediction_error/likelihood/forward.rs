//! Forward pass: the filter at other levels.

use super::linear_run::LinearRun;
use crate::estimate::estimators::prediction_error::covariance::{
    Correction, Propagation, propagate, propagate_state, start_covariance,
};
use crate::estimate::estimators::prediction_error::levels::Decay;
use crate::estimate::estimators::prediction_error::measurements::observe;
use crate::estimate::estimators::prediction_error::vector::{add, add_short, extend_single};

/// Results of the forward pass.
pub(super) struct Forward {
    /// L, minus the logarithm of the likelihood, without its constant.
    pub(super) loss: f64,
    /// K of each measurement, \[measurements × states\], in single precision to save memory; S; and
    /// e/S.
    pub(super) gains: Vec<f32>,
    pub(super) variance: Vec<f64>,
    pub(super) scaled_innovation: Vec<f64>,
    /// Rows of P for the disturbances after the measurements of each sample, \[samples × rows ×
    /// states\], in single precision; and the disturbances, \[samples × rows\].
    pub(super) covariance: Vec<f32>,
    pub(super) disturbances: Vec<f64>,
}

/// Runs the linear filter. Returns `None` if the run has fewer measurements or samples.
///
/// The state is that of the run plus a deviation. A measurement moves the state by the new gain and
/// moved the run by the gain of the run, so the deviation moves by the difference.
pub(super) fn forward(linear: &LinearRun<'_>) -> Option<Forward> {
    let (rows, states) = (linear.rows, linear.states);
    let run = linear.run;
    let mut propagation = Propagation::new(rows);
    let mut correction = Correction::default();
    let (mut memory, mut transition) = (vec![0.0; states], Vec::new());
    let mut corrections = run.corrections(states);
    let mut disturbances = run.trajectory.disturbances.chunks(rows);
    let (segment, decay) = (linear.segment, linear.decay);
    let (samples, count) = (linear.samples, segment.measurements.len());
    let mut forward = Forward {
        loss: 0.0,
        gains: Vec::with_capacity(count * states),
        variance: Vec::with_capacity(count),
        scaled_innovation: Vec::with_capacity(count),
        covariance: Vec::with_capacity(samples * rows * states),
        disturbances: Vec::with_capacity(samples * rows),
    };
    let change = decay.factor - Decay::new(run.linearization.corner, segment.period).factor;
    let mut covariance = start_covariance(rows, segment, linear.levels);
    let mut deviation = vec![0.0; states];
    for k in 0..linear.samples {
        for measurement in segment.at(k) {
            let (gains, before) = corrections.next()?;
            let observation = linear.observation(measurement);
            let innovation = before - observe(&deviation, observation.clone());
            let noise = linear.levels.measurement_variance(measurement);
            let (cross, variance) = correction.measure(&covariance, observation, noise);
            let scaled = innovation / variance;
            if segment.counts(k) {
                forward.loss += 0.5 * (innovation * scaled + variance.ln());
            }
            extend_single(&mut forward.gains, cross.iter().map(|c| c / variance));
            forward.variance.push(variance);
            forward.scaled_innovation.push(scaled);
            add(&mut deviation, scaled, cross);
            add_short(&mut deviation, -before, gains);
        }
        correction.apply(&mut covariance);
        let disturbance = disturbances.next()?;
        let of_disturbances = covariance[2 * rows * states..].iter().copied();
        extend_single(&mut forward.covariance, of_disturbances);
        let pairs = deviation[2 * rows..].iter().zip(disturbance);
        forward.disturbances.extend(pairs.map(|(a, b)| a + b));
        let period = linear.period(k, &mut transition);
        propagate(
            &mut covariance,
            period.transition,
            linear.levels,
            period.reversals,
            decay,
            &mut propagation,
        );
        propagate_state(&mut deviation, period.transition, decay.factor, &mut memory);
        add(&mut deviation[2 * rows..], change, disturbance);
    }
    Some(forward)
}
