//! The likelihood of the levels of the disturbances, the filter being linear about
//! the last trajectory, with its exact gradient and a curvature.
//!
//! Forward goes the filter; backward go the derivatives of the loss by state and
//! covariance, which give those by all levels at once; forward once more goes, for
//! each level, what a change of it would add to the measurements.
//!
//! # Source
//!
//! Koopman and Shephard, Biometrika 1992: "Exact score for time series models in
//! state space form"; Gilmour, Thompson and Cullis, Biometrics 1995: "Average
//! information REML".

use super::covariance::{
    carry, disturb, dot, propagate, pull, pull_product, pull_state, start_covariance, update,
};
use super::dynamics::add;
use super::filter::{Levels, Schedule, measured, seen};
use super::level_gradient::{Gradient, fresh};
use super::levels::{Level, Search};
use super::measurements::{Event, Record, Stretch};

/// The innovations of a run about which the likelihood is linear.
#[derive(Clone, Copy)]
pub(super) struct About<'a> {
    pub(super) record: &'a Record,
    pub(super) schedule: &'a Schedule,
    // Samples whose transitions are used.
    samples: usize,
}

/// What the likelihood says at some levels, by their logarithms.
#[derive(Clone, Debug)]
pub(super) struct Slope {
    /// Minus the logarithm of the likelihood, without its constant.
    pub(super) loss: f64,
    pub(super) gradient: Vec<f64>,
    /// The part of the gradient that innovations of the expected size would give.
    pub(super) expected: Vec<f64>,
    /// Average of expected and observed information, \[levels × levels\]; the lower
    /// triangle is filled.
    pub(super) curvature: Vec<f64>,
}

/// What is called with the index of a sample and the derivatives of the loss behind it.
type Visit<'v> = dyn FnMut(usize, &[f64], &[f64]) + 'v;

/// A stretch with the transitions of its samples.
pub(super) struct Part<'a> {
    stretch: &'a Stretch,
    samples: usize,
    /// \[samples × 2 rows × 3 rows\].
    transitions: &'a [f64],
    /// What is left of a disturbance after a period, and its derivative by the
    /// logarithm of the corner.
    pub(super) left: f64,
    pub(super) slope: f64,
}

/// What the forward pass leaves for the others.
#[derive(Default)]
struct Trail {
    /// Gains of each measurement, \[measurements × states\], variance of its
    /// innovation, and that over the variance.
    gains: Vec<f64>,
    variance: Vec<f64>,
    unlikely: Vec<f64>,
    /// Covariance of the disturbances with all states after a sample's measurements,
    /// \[samples × rows × states\], and the disturbances, \[samples × rows\].
    covariance: Vec<f64>,
    drift: Vec<f64>,
    /// Backward: what a period leads to weighs on the state behind it,
    /// \[samples × states\]; on each measurement; and, by the corner, on the
    /// disturbances, \[samples × rows\].
    weight: Vec<f64>,
    of_measurement: Vec<f64>,
    by_corner: Vec<f64>,
    /// The same at the start of each part: \[states\], \[rows\].
    starts: Vec<(Vec<f64>, Vec<f64>)>,
}

impl<'a> About<'a> {
    /// - `samples`: whose transitions are kept.
    pub(super) fn new(record: &'a Record, schedule: &'a Schedule, samples: usize) -> Self {
        Self {
            record,
            schedule,
            samples,
        }
    }

    /// Returns what the likelihood says at some levels.
    pub(super) fn likelihood(&self, search: &Search, levels: &Levels) -> Slope {
        let parts = self.parts(levels);
        let mut trail = Trail::default();
        let loss = self.forward(&parts, levels, &mut trail);
        let mut all = Gradient::new(levels);
        self.backward(&parts, levels, &mut trail, &mut all, &mut |_, _, _| {});
        let mut slope = Slope {
            loss,
            gradient: search.all.iter().map(|level| all.of(*level)).collect(),
            expected: Vec::new(),
            curvature: self.information(&parts, search, levels, &trail),
        };
        slope.expected = (search.all.iter().zip(&slope.gradient))
            .map(|(level, own)| own + all.found(*level))
            .collect();
        slope
    }

    /// Visits, from the last sample to the first, the information that later
    /// measurements give about the state behind it: its index and that matrix,
    /// \[states × states\].
    pub(super) fn information_ahead(&self, levels: &Levels, mut visit: impl FnMut(usize, &[f64])) {
        let parts = self.parts(levels);
        let mut trail = Trail::default();
        self.forward(&parts, levels, &mut trail);
        let mut information = Vec::new();
        let mut of = |sample: usize, by_covariance: &[f64], weight: &[f64]| {
            // The derivative is half of it less its square root as it was found.
            information.clear();
            let all = by_covariance.chunks(weight.len()).zip(weight);
            for (row, own) in all {
                information.extend(
                    row.iter()
                        .zip(weight)
                        .map(|(d, other)| 2.0 * d + own * other),
                );
            }
            visit(sample, &information);
        };
        let mut all = Gradient::new(levels);
        self.backward(&parts, levels, &mut trail, &mut all, &mut of);
    }

    fn parts(&self, levels: &Levels) -> Vec<Part<'_>> {
        let rows = levels.drift.len();
        let size = 6 * rows * rows;
        let mut transitions = self.schedule.transitions.as_slice();
        let mut left = self.samples.min(transitions.len() / size);
        let mut parts = Vec::new();
        for stretch in &self.record.stretches {
            let samples = stretch.samples().min(left);
            let (own, others) = transitions.split_at(samples * size);
            (transitions, left) = (others, left - samples);
            let decay = levels.left_after(stretch.period);
            parts.push(Part {
                stretch,
                samples,
                transitions: own,
                left: decay,
                slope: decay * decay.ln(),
            });
        }
        parts
    }

    /// Runs the filter; returns the loss.
    fn forward(&self, parts: &[Part<'_>], levels: &Levels, trail: &mut Trail) -> f64 {
        let rows = levels.drift.len();
        let states = 3 * rows;
        let mut product = vec![0.0; 2 * rows * states];
        let mut column = vec![0.0; states];
        let mut run = self.schedule.measured(states);
        let mut drifts = self.schedule.path.drift.chunks(rows);
        let mut loss = 0.0;
        for part in parts {
            let change = part.left - Levels::left(self.schedule.corner, part.stretch.period);
            let mut covariance = start_covariance(rows, part.stretch, levels);
            let mut deviation = vec![0.0; states];
            for k in 0..part.samples {
                for event in part.events(k) {
                    let Some((gains, before)) = run.next() else {
                        return f64::INFINITY;
                    };
                    let of = seen(&self.record.sensors[event.sensor], event, rows);
                    let innovation = before - measured(&deviation, of.clone());
                    let noise = levels.variance(event);
                    let variance = update(&mut covariance, of, noise, &mut column);
                    let unlikely = innovation / variance;
                    loss += 0.5 * (innovation * unlikely + variance.ln());
                    trail.gains.extend(column.iter().map(|c| c / variance));
                    trail.variance.push(variance);
                    trail.unlikely.push(unlikely);
                    // The state moves by its own gain; the run moved by its.
                    add(&mut deviation, unlikely, &column);
                    add(&mut deviation, -before, gains);
                }
                let Some(drift) = drifts.next() else {
                    return f64::INFINITY;
                };
                (trail.covariance).extend_from_slice(&covariance[2 * rows * states..]);
                let own = &deviation[2 * rows..];
                trail
                    .drift
                    .extend(own.iter().zip(drift).map(|(a, b)| a + b));
                let transition = part.transition(k, rows);
                propagate(&mut covariance, transition, &mut product, part.left);
                disturb(&mut covariance, transition, levels, part.left);
                carry(&mut deviation, transition, part.left, &mut column);
                add(&mut deviation[2 * rows..], change, drift);
            }
        }
        loss
    }

    /// Carries the derivatives of the loss by state and covariance backward, and
    /// gathers those by the levels.
    ///
    /// - `visit`: called with the index of each sample, the derivatives by the
    ///   covariance behind it, and minus those by the state.
    fn backward(
        &self,
        parts: &[Part<'_>],
        levels: &Levels,
        trail: &mut Trail,
        gradient: &mut Gradient,
        visit: &mut Visit<'_>,
    ) {
        let rows = levels.drift.len();
        let states = 3 * rows;
        let mut sample = trail.drift.len() / rows;
        let mut measurement = trail.variance.len();
        trail.weight = vec![0.0; sample * states];
        trail.by_corner = vec![0.0; sample * rows];
        trail.of_measurement = vec![0.0; measurement];
        let mut pulled = vec![0.0; states * states];
        let mut moved = vec![0.0; states];
        for part in parts.iter().rev() {
            // Derivatives by the covariance, and minus those by the state.
            let mut by_covariance = vec![0.0; states * states];
            let mut weight = vec![0.0; states];
            let mut by_corner = vec![0.0; rows];
            for k in (0..part.samples).rev() {
                sample -= 1;
                visit(sample, &by_covariance, &weight);
                let transition = part.transition(k, rows);
                let own = sample * states..(sample + 1) * states;
                trail.weight[own].copy_from_slice(&weight);
                let own = sample * rows..(sample + 1) * rows;
                trail.by_corner[own.clone()].copy_from_slice(&by_corner);
                for (i, corner) in by_corner.iter_mut().enumerate() {
                    *corner = part.left * *corner + part.slope * weight[2 * rows + i];
                }
                gradient.by_drift(&by_covariance, &weight, levels, part, &trail.drift[own]);
                pull_product(&by_covariance, transition, part.left, &mut pulled);
                let rows_of = rows * states;
                let covariance = &trail.covariance[sample * rows_of..(sample + 1) * rows_of];
                gradient.by_white(
                    &pulled,
                    &by_covariance,
                    &weight,
                    levels,
                    transition,
                    part.left,
                );
                gradient.by_decay(&pulled, covariance, part.slope);
                pull(&pulled, transition, part.left, &mut by_covariance);
                pull_state(&mut weight, transition, part.left, &mut moved);
                // What all measurements say of the disturbance here.
                for i in 0..rows {
                    let own = &covariance[i * states..(i + 1) * states];
                    trail.drift[sample * rows + i] += dot(own, &weight);
                }
                for event in part.events(k).iter().rev() {
                    measurement -= 1;
                    let gains = &trail.gains[measurement * states..(measurement + 1) * states];
                    let (unlikely, variance) =
                        (trail.unlikely[measurement], trail.variance[measurement]);
                    let of = seen(&self.record.sensors[event.sensor], event, rows);
                    for (sum, row) in moved.iter_mut().zip(by_covariance.chunks(states)) {
                        *sum = dot(row, gains);
                    }
                    let ahead = dot(&weight, gains);
                    let by_variance = 0.5 * (1.0 / variance - unlikely * unlikely)
                        + ahead * unlikely
                        + dot(&moved, gains);
                    let error = unlikely - ahead;
                    trail.of_measurement[measurement] = error;
                    gradient.by_sensor(event.sensor, by_variance, error, levels);
                    for (state, factor) in of.clone() {
                        for i in 0..states {
                            let both = -factor * (moved[i] + 0.5 * unlikely * weight[i]);
                            by_covariance[state * states + i] += both;
                            by_covariance[i * states + state] += both;
                        }
                        for (other, by) in of.clone() {
                            by_covariance[state * states + other] += by_variance * factor * by;
                        }
                    }
                    for (state, factor) in of {
                        weight[state] += error * factor;
                    }
                }
            }
            gradient.by_start(&by_covariance, &weight, levels);
            trail.starts.push((weight, by_corner));
        }
        trail.starts.reverse();
    }

    /// Returns the average information: what each level would add to the
    /// measurements, filtered and multiplied.
    fn information(
        &self,
        parts: &[Part<'_>],
        search: &Search,
        levels: &Levels,
        trail: &Trail,
    ) -> Vec<f64> {
        let rows = levels.drift.len();
        let (states, count) = (3 * rows, search.all.len());
        let mut information = vec![0.0; count * count];
        let mut found = vec![0.0; count];
        let mut memory = vec![0.0; states];
        let (mut sample, mut measurement) = (0, 0);
        for (part, (weight, by_corner)) in parts.iter().zip(&trail.starts) {
            let mut added = vec![0.0; count * states];
            for (own, level) in added.chunks_mut(states).zip(&search.all) {
                match *level {
                    Level::Drift(row) => {
                        let at = 2 * rows + row;
                        own[at] = 2.0 * levels.drift[row].powi(2) * weight[at];
                    }
                    Level::Corner => {
                        for (row, by_corner) in by_corner.iter().enumerate() {
                            own[2 * rows + row] = levels.drift[row].powi(2) * by_corner;
                        }
                    }
                    Level::White(_) | Level::Sensor(_) => {}
                }
            }
            for k in 0..part.samples {
                for event in part.events(k) {
                    let gains = &trail.gains[measurement * states..(measurement + 1) * states];
                    let of = seen(&self.record.sensors[event.sensor], event, rows);
                    let all = search.all.iter().zip(added.chunks_mut(states));
                    for (found, (level, own)) in found.iter_mut().zip(all) {
                        *found = measured(own, of.clone());
                        if *level == Level::Sensor(event.sensor) {
                            *found += 2.0
                                * levels.sensor[event.sensor].powi(2)
                                * trail.of_measurement[measurement];
                        }
                        if *found != 0.0 {
                            add(own, -*found, gains);
                        }
                    }
                    let factor = 0.5 / trail.variance[measurement];
                    for (i, own) in found.iter().enumerate() {
                        let row = &mut information[i * count..=i * count + i];
                        add(row, factor * own, &found[..=i]);
                    }
                    measurement += 1;
                }
                let transition = part.transition(k, rows);
                let weight = &trail.weight[sample * states..(sample + 1) * states];
                for (own, level) in added.chunks_mut(states).zip(&search.all) {
                    carry(own, transition, part.left, &mut memory);
                    match *level {
                        Level::White(row) => {
                            let column = || transition[2 * rows + row..].iter().step_by(states);
                            let pulled: f64 = column().zip(weight).map(|(a, r)| a * r).sum();
                            let factor = 2.0 * levels.white[row].powi(2) * pulled;
                            for (own, a) in own.iter_mut().zip(column()) {
                                *own += factor * a;
                            }
                        }
                        Level::Drift(row) => {
                            let at = 2 * rows + row;
                            own[at] += 2.0 * fresh(levels, row, part.left) * weight[at];
                        }
                        Level::Corner => {
                            for row in 0..rows {
                                let at = 2 * rows + row;
                                let here = sample * rows + row;
                                let less = 2.0 * part.left * part.slope * levels.drift[row].powi(2);
                                own[at] += part.slope * trail.drift[here] - less * weight[at]
                                    + fresh(levels, row, part.left) * trail.by_corner[here];
                            }
                        }
                        Level::Sensor(_) => {}
                    }
                }
                sample += 1;
            }
        }
        information
    }
}

impl Part<'_> {
    fn events(&self, k: usize) -> &[Event] {
        &self.stretch.events[self.stretch.first[k]..self.stretch.first[k + 1]]
    }

    /// Returns the derivatives of the state behind a sample, \[2 rows × 3 rows\].
    fn transition(&self, k: usize, rows: usize) -> &[f64] {
        let size = 6 * rows * rows;
        &self.transitions[k * size..(k + 1) * size]
    }
}
