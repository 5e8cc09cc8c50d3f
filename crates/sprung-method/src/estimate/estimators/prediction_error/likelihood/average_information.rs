//! Second forward pass: the average of expected and observed information of the levels.

use super::backward::Backward;
use super::forward::Forward;
use super::linear_run::{LinearRun, Period};
use crate::estimate::estimators::prediction_error::levels::Level;
use crate::estimate::estimators::prediction_error::matrix::{add_outer, add_square, multiply};
use crate::estimate::estimators::prediction_error::measurements::Measurement;
use crate::estimate::estimators::prediction_error::vector::{add, scale, widen};

/// Contribution of each level's change to the state, filtered.
struct Added<'a> {
    linear: &'a LinearRun<'a>,
    levels: &'a [Level],
    forward: &'a Forward,
    backward: &'a Backward,
    /// Contribution of each level to the state, \[states × levels\].
    states: Vec<f64>,
    /// Contribution of each level to the present innovation, \[levels\].
    found: Vec<f64>,
    memory: Vec<f64>,
    gains: Vec<f64>,
    transition: Vec<f64>,
}

/// Returns the average information, \[levels × levels\]; only the lower triangle is filled. Its
/// entries are sums of products of the levels' whitened contributions to the innovations.
pub(super) fn average_information(
    linear: &LinearRun<'_>,
    levels: &[Level],
    forward: &Forward,
    backward: &Backward,
) -> Vec<f64> {
    let count = levels.len();
    let mut information = vec![0.0; count * count];
    let mut added = Added {
        linear,
        levels,
        forward,
        backward,
        states: vec![0.0; linear.states * count],
        found: vec![0.0; count],
        memory: vec![0.0; 2 * linear.rows * count],
        gains: Vec::new(),
        transition: Vec::new(),
    };
    added.start(&backward.start);
    let segment = linear.segment;
    let mut index = 0;
    for k in 0..linear.samples {
        for measurement in segment.at(k) {
            added.measure((measurement, index));
            if segment.counts(k) {
                add_square(
                    &mut information,
                    0.5 / forward.variance[index],
                    &added.found,
                );
            }
            index += 1;
        }
        added.predict(k);
    }
    information
}

impl Added<'_> {
    /// Sets the contributions at the start of the segment.
    ///
    /// - `state_adjoint`, `corner_adjoint`: end of the backward pass in this segment.
    fn start(&mut self, (state_adjoint, corner_adjoint): &(Vec<f64>, Vec<f64>)) {
        let (rows, count) = (self.linear.rows, self.levels.len());
        let disturbance = &self.linear.levels.disturbance;
        self.states.fill(0.0);
        for (level, kind) in self.levels.iter().enumerate() {
            match *kind {
                Level::Disturbance(row) => {
                    let at = 2 * rows + row;
                    self.states[at * count + level] =
                        2.0 * disturbance[row].powi(2) * state_adjoint[at];
                }
                Level::Corner => {
                    for (row, by_corner) in corner_adjoint.iter().enumerate() {
                        self.states[(2 * rows + row) * count + level] =
                            disturbance[row].powi(2) * by_corner;
                    }
                }
                Level::TorqueNoise(_) | Level::ReversalNoise(_) | Level::SensorNoise(_) => {}
            }
        }
    }

    /// Writes the contribution of each level to an innovation, and corrects the states by the gain.
    fn measure(&mut self, (measurement, index): (&Measurement, usize)) {
        let (states, count) = (self.linear.states, self.levels.len());
        let range = index * states..(index + 1) * states;
        widen(&mut self.gains, &self.forward.gains[range]);
        self.found.fill(0.0);
        for (state, weight) in self.linear.observation(measurement) {
            let row = &self.states[state * count..(state + 1) * count];
            add(&mut self.found, weight, row);
        }
        let sensor = measurement.sensor;
        for (found, level) in self.found.iter_mut().zip(self.levels) {
            if *level == Level::SensorNoise(sensor) {
                *found += 2.0
                    * self.linear.levels.sensor_noise[sensor].powi(2)
                    * self.backward.smoothing_error[index];
            }
        }
        add_outer(&mut self.states, -1.0, &self.gains, &self.found);
    }

    /// Propagates the contributions over a period.
    fn predict(&mut self, sample: usize) {
        let (rows, states, levels) = (self.linear.rows, self.linear.states, self.linear.levels);
        let count = self.levels.len();
        let Period {
            transition,
            reversals,
            decay,
        } = self.linear.period(sample, &mut self.transition);
        let adjoint = &self.backward.state_adjoint[sample * states..(sample + 1) * states];
        multiply(transition, &self.states, count, &mut self.memory);
        let (moving, disturbances) = self.states.split_at_mut(2 * rows * count);
        moving.copy_from_slice(&self.memory);
        scale(disturbances, decay.factor);
        for (level, kind) in self.levels.iter().enumerate() {
            match *kind {
                Level::TorqueNoise(row) | Level::ReversalNoise(row) => {
                    let variance = match *kind {
                        Level::ReversalNoise(_) => {
                            reversals[row] * levels.reversal_noise[row].powi(2)
                        }
                        Level::TorqueNoise(_)
                        | Level::Disturbance(_)
                        | Level::SensorNoise(_)
                        | Level::Corner => levels.torque_noise[row].powi(2),
                    };
                    if variance == 0.0 {
                        continue;
                    }
                    let column = || transition[2 * rows + row..].iter().step_by(states);
                    let pulled: f64 = column().zip(adjoint).map(|(a, r)| a * r).sum();
                    let factor = 2.0 * variance * pulled;
                    for (entry, a) in moving[level..].iter_mut().step_by(count).zip(column()) {
                        *entry += factor * a;
                    }
                }
                Level::Disturbance(row) => {
                    disturbances[row * count + level] +=
                        2.0 * levels.added_variance(row, decay) * adjoint[2 * rows + row];
                }
                Level::Corner => {
                    for row in 0..rows {
                        let here = sample * rows + row;
                        let slope = decay.by_log_corner;
                        let less = 2.0 * decay.factor * slope * levels.disturbance[row].powi(2);
                        disturbances[row * count + level] += slope * self.backward.smoothed[here]
                            - less * adjoint[2 * rows + row]
                            + levels.added_variance(row, decay)
                                * self.backward.corner_adjoint[here];
                    }
                }
                Level::SensorNoise(_) => {}
            }
        }
    }
}
