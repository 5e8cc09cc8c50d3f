//! Integration of the state and its derivatives over a period by the Runge-Kutta method of order 4.

use super::motion::Dynamics;
use super::step_size::Steps;
use super::tangent::Tangent;
use crate::estimate::estimators::prediction_error::vector::add;

impl Dynamics {
    /// Moves the state by one period.
    ///
    /// - `steps`: number of integration steps.
    pub(in crate::estimate::estimators::prediction_error) fn advance(
        &mut self,
        x: &mut [f64],
        torque: &[f64],
        period: f64,
        steps: usize,
    ) {
        let rows = self.rows;
        let h = period / steps as f64;
        let mut at = std::mem::take(&mut self.within.at);
        let mut acting = Acting::new(torque, &self.ramp, period);
        for step in 0..steps {
            at.copy_from_slice(x);
            self.within.sum.fill(0.0);
            for (stage, (weight, ahead)) in STAGES.into_iter().enumerate() {
                self.accelerate(&at, acting.at(h * (step as f64 + PLACES[stage])));
                for i in 0..rows {
                    self.within.sum[i] += weight * at[rows + i];
                    self.within.sum[rows + i] += weight * self.rate[i];
                }
                next(x, h * ahead, &self.rate, &mut at);
            }
            add(x, h / 6.0, &self.within.sum);
        }
        self.within.at = at;
    }

    /// Moves the state by one period, together with its derivatives. They come from the equations
    /// linearised in the middle of the period, or of each step if friction is not smooth.
    pub(in crate::estimate::estimators::prediction_error) fn advance_tangent(
        &mut self,
        x: &mut [f64],
        torque: &[f64],
        period: f64,
        steps: Steps,
        tangent: &mut Tangent,
    ) {
        let rows = self.rows;
        let h = period / steps.count as f64;
        let mut at = std::mem::take(&mut self.within.at);
        let mut acting = Acting::new(torque, &self.ramp, period);
        for step in 0..steps.count {
            at.copy_from_slice(x);
            self.within.sum.fill(0.0);
            let middle = middle_stage(steps, step);
            for (stage, (weight, ahead)) in STAGES.into_iter().enumerate() {
                let torque = acting.at(h * (step as f64 + PLACES[stage]));
                if middle == Some(stage) {
                    self.differentiate(&at, torque);
                    if steps.is_smooth {
                        tangent.linearise(self, h, steps.count);
                        tangent.advance(self, true);
                    } else {
                        tangent.linearise(self, h, 1);
                        tangent.advance(self, step == 0);
                    }
                } else {
                    self.accelerate(&at, torque);
                }
                for i in 0..rows {
                    self.within.sum[i] += weight * at[rows + i];
                    self.within.sum[rows + i] += weight * self.rate[i];
                }
                next(x, h * ahead, &self.rate, &mut at);
            }
            add(x, h / 6.0, &self.within.sum);
        }
        self.within.at = at;
    }
}

/// Weight of each stage of the Runge-Kutta method of order 4 in sixths, and distance to the next
/// stage in steps.
const STAGES: [(f64, f64); 4] = [(1.0, 0.5), (2.0, 0.5), (2.0, 1.0), (1.0, 0.0)];

/// Place of each stage, in steps.
const PLACES: [f64; 4] = [0.0, 0.5, 0.5, 1.0];

/// The torque within a period.
struct Acting<'t> {
    /// In the middle of the period, \[rows\].
    torque: &'t [f64],
    /// Rate, \[rows\]; empty if the torque is held.
    ramp: Vec<f64>,
    middle: f64,
    now: Vec<f64>,
}

impl<'t> Acting<'t> {
    fn new(torque: &'t [f64], ramp: &[f64], period: f64) -> Self {
        Self {
            torque,
            ramp: ramp.to_vec(),
            middle: 0.5 * period,
            now: Vec::with_capacity(ramp.len()),
        }
    }

    /// Returns the torque at a time of the period, s.
    fn at(&mut self, time: f64) -> &[f64] {
        if self.ramp.is_empty() {
            return self.torque;
        }
        let away = time - self.middle;
        let pairs = self.torque.iter().zip(&self.ramp);
        self.now.clear();
        self.now
            .extend(pairs.map(|(torque, ramp)| torque + ramp * away));
        &self.now
    }
}

/// Returns the stage of a step at which the equations are linearised, if there is one.
fn middle_stage(steps: Steps, step: usize) -> Option<usize> {
    if !steps.is_smooth {
        return Some(STAGES.len() / 2);
    }
    // The middle of an even number of steps is the beginning of a step.
    let stage = if steps.count.is_multiple_of(2) {
        0
    } else {
        STAGES.len() / 2
    };
    (step == steps.count / 2).then_some(stage)
}

/// Writes the state of the next stage.
fn next(x: &[f64], step: f64, rate: &[f64], at: &mut [f64]) {
    let rows = rate.len();
    let (positions, velocities) = at.split_at_mut(rows);
    for i in 0..rows {
        positions[i] = x[i] + step * velocities[i];
        velocities[i] = x[rows + i] + step * rate[i];
    }
}
