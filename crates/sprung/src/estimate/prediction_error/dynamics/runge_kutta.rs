//! Integration of the state and its derivatives over a period by the Runge-Kutta method of order 4.

use super::motion::Dynamics;
use super::tangent::Tangent;
use crate::estimate::prediction_error::vector::add;

impl Dynamics {
    /// Moves the state by one period.
    ///
    /// - `steps`: number of integration steps.
    pub(in crate::estimate::prediction_error) fn advance(
        &mut self,
        x: &mut [f64],
        torque: &[f64],
        period: f64,
        steps: usize,
    ) {
        let rows = self.rows;
        let h = period / steps as f64;
        let mut at = std::mem::take(&mut self.at);
        for _ in 0..steps {
            at.copy_from_slice(x);
            self.sum.fill(0.0);
            for (weight, ahead) in STAGES {
                self.accelerate(&at, torque);
                for i in 0..rows {
                    self.sum[i] += weight * at[rows + i];
                    self.sum[rows + i] += weight * self.rate[i];
                }
                next(x, h * ahead, &self.rate, &mut at);
            }
            add(x, h / 6.0, &self.sum);
        }
        self.at = at;
    }

    /// Moves the state by one period, together with the exact derivatives of the integration.
    pub(in crate::estimate::prediction_error) fn advance_tangent(
        &mut self,
        x: &mut [f64],
        torque: &[f64],
        period: f64,
        steps: usize,
        tangent: &mut Tangent,
    ) {
        let rows = self.rows;
        let h = period / steps as f64;
        let half = rows * tangent.columns;
        let mut at = std::mem::take(&mut self.at);
        for _ in 0..steps {
            at.copy_from_slice(x);
            self.sum.fill(0.0);
            tangent.stage.copy_from_slice(&tangent.state);
            tangent.sum.fill(0.0);
            for (weight, ahead) in STAGES {
                self.differentiate(&at, torque);
                for i in 0..rows {
                    self.sum[i] += weight * at[rows + i];
                    self.sum[rows + i] += weight * self.rate[i];
                }
                next(x, h * ahead, &self.rate, &mut at);
                self.tangent_rate(tangent);
                let (of_positions, of_velocities) = tangent.sum.split_at_mut(half);
                add(of_positions, weight, &tangent.stage[half..]);
                add(of_velocities, weight, &tangent.rate);
                if ahead > 0.0 {
                    let step = h * ahead;
                    let (positions, velocities) = tangent.stage.split_at_mut(half);
                    let (from, from_velocity) = tangent.state.split_at(half);
                    for ((p, v), x) in positions.iter_mut().zip(&*velocities).zip(from) {
                        *p = x + step * v;
                    }
                    for ((v, rate), x) in
                        velocities.iter_mut().zip(&tangent.rate).zip(from_velocity)
                    {
                        *v = x + step * rate;
                    }
                }
            }
            add(x, h / 6.0, &self.sum);
            add(&mut tangent.state, h / 6.0, &tangent.sum);
        }
        self.at = at;
    }

    /// Writes the derivatives of the accelerations at a stage.
    fn tangent_rate(&self, tangent: &mut Tangent) {
        let (rows, columns) = (self.rows, tangent.columns);
        tangent.force.copy_from_slice(&tangent.torque);
        let entries = self.entries.iter().zip(&self.entry_columns);
        for ((entry, &column), row) in entries.zip(&self.entry_rows) {
            if let Some(place) = tangent.theta[column] {
                tangent.force[row * columns + place] -= entry;
            }
        }
        for &(joint, place) in &tangent.velocities {
            self.visit_stribeck_torques(joint, |row, torque| {
                tangent.force[row * columns + place] -= torque;
            });
        }
        let (positions, velocities) = tangent.stage.split_at(rows * columns);
        for (i, rate) in tangent.rate.chunks_mut(columns).enumerate() {
            rate.fill(0.0);
            let own = i * rows..(i + 1) * rows;
            for (matrix, rows_of) in [
                (&self.by_position, positions),
                (&self.by_velocity, velocities),
                (&self.inverse, &tangent.force),
            ] {
                for (factor, row) in matrix[own.clone()].iter().zip(rows_of.chunks(columns)) {
                    if *factor != 0.0 {
                        add(rate, *factor, row);
                    }
                }
            }
        }
    }
}

/// Weight of each stage of the Runge-Kutta method of order 4 in sixths, and distance to the next
/// stage in steps.
const STAGES: [(f64, f64); 4] = [(1.0, 0.5), (2.0, 0.5), (2.0, 1.0), (1.0, 0.0)];

/// Writes the state of the next stage.
fn next(x: &[f64], step: f64, rate: &[f64], at: &mut [f64]) {
    let rows = rate.len();
    let (positions, velocities) = at.split_at_mut(rows);
    for i in 0..rows {
        positions[i] = x[i] + step * velocities[i];
        velocities[i] = x[rows + i] + step * rate[i];
    }
}
