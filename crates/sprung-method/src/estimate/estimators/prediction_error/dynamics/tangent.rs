//! Derivatives of the state by the unknowns, and by the state at the beginning of a period.

use sprung_core::friction::Scale;

use super::motion::Dynamics;
use crate::estimate::estimators::prediction_error::matrix::multiply;
use crate::estimate::estimators::prediction_error::state_layout::state_count;

/// The column of the derivatives by a scale of a joint's friction laws.
#[derive(Clone, Copy, Debug)]
pub(in crate::estimate::estimators::prediction_error) struct ScalePlace {
    pub(in crate::estimate::estimators::prediction_error) joint: usize,
    pub(in crate::estimate::estimators::prediction_error) scale: Scale,
    pub(in crate::estimate::estimators::prediction_error) place: usize,
}

/// Derivatives of the filter's state, and their change over a period. Disturbances are constant
/// within a period.
#[derive(Clone, Debug)]
pub(in crate::estimate::estimators::prediction_error) struct Tangent {
    rows: usize,
    /// Number of unknowns.
    pub(in crate::estimate::estimators::prediction_error) columns: usize,
    /// ∂x/∂z, \[3 rows × columns\].
    pub(in crate::estimate::estimators::prediction_error) sensitivity: Vec<f64>,
    /// Derivatives of the logged torques by the unknowns, \[rows × columns\].
    pub(in crate::estimate::estimators::prediction_error) torque: Vec<f64>,
    /// F over the period without the rows of the disturbances, \[2 rows × 3 rows\].
    pub(in crate::estimate::estimators::prediction_error) transition: Vec<f64>,
    /// Column of each parameter of theta; `None` for a parameter without derivatives.
    places: Vec<Option<usize>>,
    /// Scales of friction laws with a derivative.
    scales: Vec<ScalePlace>,
    /// Derivatives of the accelerations by positions and velocities, \[rows × 2 rows\].
    by_motion: Vec<f64>,
    /// F over one integration step, \[2 rows × 3 rows\], and its product with `by_motion`.
    one: Vec<f64>,
    rate: Vec<f64>,
    /// F over the steps linearised last, \[2 rows × 3 rows\].
    step: Vec<f64>,
    /// Factors of `step`: \[3 rows × 3 rows\] and \[3 rows × columns\].
    states: Vec<f64>,
    unknowns: Vec<f64>,
}

impl Tangent {
    /// Returns derivatives that are zero.
    ///
    /// - `places`: column of each parameter of theta; `scales`: the estimated scales of friction laws.
    pub(in crate::estimate::estimators::prediction_error) fn new(
        rows: usize,
        columns: usize,
        places: Vec<Option<usize>>,
        scales: Vec<ScalePlace>,
    ) -> Self {
        let states = state_count(rows);
        Self {
            rows,
            columns,
            sensitivity: vec![0.0; states * columns],
            torque: vec![0.0; rows * columns],
            transition: vec![0.0; 2 * rows * states],
            places,
            scales,
            by_motion: vec![0.0; 2 * rows * rows],
            one: vec![0.0; 2 * rows * states],
            step: vec![0.0; 2 * rows * states],
            rate: vec![0.0; rows * states],
            states: vec![0.0; states * states],
            unknowns: vec![0.0; states * columns],
        }
    }

    /// Writes F over some integration steps, each of length h, with the equations linearised at one
    /// instant.
    ///
    /// - `dynamics`: differentiated at this instant.
    pub(super) fn linearise(&mut self, dynamics: &Dynamics, h: f64, steps: usize) {
        self.expand(dynamics, h);
        if steps > 1 {
            let moving = self.step.len();
            self.one.copy_from_slice(&self.step);
            for _ in 1..steps {
                self.states[..moving].copy_from_slice(&self.step);
                identity_of_disturbances(self.rows, &mut self.states[moving..]);
                multiply(
                    &self.one,
                    &self.states,
                    state_count(self.rows),
                    &mut self.step,
                );
            }
        }
    }

    /// Moves the derivatives by the steps linearised last.
    ///
    /// ```text
    /// F ← F_h F        ∂x/∂z ← F_h [∂x/∂z; ∂d/∂z + ∂τ/∂z − Y ∂θ/∂z]
    /// ```
    ///
    /// - `dynamics`: differentiated at the instant of the linearisation.
    /// - `is_first`: whether these are the first steps of the period.
    pub(super) fn advance(&mut self, dynamics: &Dynamics, is_first: bool) {
        let (states, moving) = (state_count(self.rows), 2 * self.rows);
        if is_first {
            self.transition.copy_from_slice(&self.step);
        } else {
            self.states[..moving * states].copy_from_slice(&self.transition);
            identity_of_disturbances(self.rows, &mut self.states[moving * states..]);
            multiply(&self.step, &self.states, states, &mut self.transition);
        }
        self.force(dynamics);
        let moved = &mut self.sensitivity[..moving * self.columns];
        self.unknowns[..moving * self.columns].copy_from_slice(moved);
        multiply(&self.step, &self.unknowns, self.columns, moved);
    }

    /// Writes F over one step: the exponential of the linearised equations up to the order 4.
    fn expand(&mut self, dynamics: &Dynamics, h: f64) {
        let (rows, moving, states) = (self.rows, 2 * self.rows, state_count(self.rows));
        for (i, row) in self.by_motion.chunks_mut(moving).enumerate() {
            let range = i * rows..(i + 1) * rows;
            row[..rows].copy_from_slice(&dynamics.by_position[range.clone()]);
            row[rows..].copy_from_slice(&dynamics.by_velocity[range]);
        }
        // Horner's rule: F ← 1 + (h/k) A F for k = 4, 3, 2, 1.
        self.step.fill(0.0);
        for (i, row) in self.step.chunks_mut(states).enumerate() {
            row[i] = 1.0;
        }
        let half = rows * states;
        for order in (1..=4).rev() {
            let step = h / f64::from(order);
            multiply(&self.by_motion, &self.step, states, &mut self.rate);
            let (positions, velocities) = self.step.split_at_mut(half);
            for (x, v) in positions.iter_mut().zip(&*velocities) {
                *x = step * v;
            }
            for (v, rate) in velocities.iter_mut().zip(&self.rate) {
                *v = step * rate;
            }
            for i in 0..rows {
                positions[i * states + i] += 1.0;
                let velocity = &mut velocities[i * states..(i + 1) * states];
                velocity[rows + i] += 1.0;
                let by_torque = &dynamics.inverse[i * rows..(i + 1) * rows];
                for (entry, inverse) in velocity[moving..].iter_mut().zip(by_torque) {
                    *entry += step * inverse;
                }
            }
        }
    }

    /// Writes the derivatives of the torques that move the robot below the place of those of the
    /// motion.
    fn force(&mut self, dynamics: &Dynamics) {
        let columns = self.columns;
        let disturbances = 2 * self.rows * columns;
        let force = &mut self.unknowns[disturbances..];
        let all = self.sensitivity[disturbances..].iter().zip(&self.torque);
        for (force, (disturbance, torque)) in force.iter_mut().zip(all) {
            *force = disturbance + torque;
        }
        let entries = dynamics.entries.iter().zip(&dynamics.entry_columns);
        for ((entry, &column), row) in entries.zip(&dynamics.entry_rows) {
            if let Some(place) = self.places[column] {
                force[row * columns + place] -= entry;
            }
        }
        for of in &self.scales {
            dynamics.visit_bent_torques((of.joint, of.scale), |row, torque| {
                force[row * columns + of.place] -= torque;
            });
        }
    }
}

/// Writes the rows of the disturbances of F over a part of a period, \[rows × 3 rows\].
fn identity_of_disturbances(rows: usize, out: &mut [f64]) {
    out.fill(0.0);
    for (i, row) in out.chunks_mut(state_count(rows)).enumerate() {
        row[2 * rows + i] = 1.0;
    }
}
