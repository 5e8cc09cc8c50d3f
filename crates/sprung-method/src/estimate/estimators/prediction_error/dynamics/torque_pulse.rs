//! Change of the parameters' torques by an additional torque that acts for one period.

use sprung_core::linear::dot;

use super::motion::Dynamics;
use crate::estimate::estimators::prediction_error::state_layout::state_count;
use crate::estimate::estimators::prediction_error::vector::scale;

/// Least change of a coordinate or a velocity, rad (m) and rad/s (m/s), over which the regressor is differentiated. It is
/// far below the velocity at which friction reverses.
const LEAST_SPREAD: f64 = 1e-6;

/// The period during which the torque acts.
#[derive(Clone, Copy, Debug)]
pub(in crate::estimate::estimators::prediction_error) struct Pulse<'a> {
    /// Positions and velocities of all rows in the middle of the period, \[2 rows\].
    pub(in crate::estimate::estimators::prediction_error) state: &'a [f64],
    /// F over the period, \[2 rows × 3 rows\].
    pub(in crate::estimate::estimators::prediction_error) transition: &'a [f64],
    /// T, s.
    pub(in crate::estimate::estimators::prediction_error) period: f64,
    /// Standard deviations of positions and velocities of all rows by the noise, \[2 rows\].
    pub(in crate::estimate::estimators::prediction_error) spread: &'a [f64],
}

impl Pulse<'_> {
    /// Returns the factor by which no change of the motion exceeds its standard deviation, and one reaches it; `None` if
    /// nothing moves.
    ///
    /// - `moved`: changes of positions and velocities, \[2 rows\].
    fn scale_to_spread(self, moved: &[f64]) -> Option<f64> {
        let largest = (moved.iter().zip(self.spread))
            .map(|(change, spread)| change.abs() / spread.max(LEAST_SPREAD))
            .fold(0.0, f64::max);
        (largest > 0.0).then(|| largest.recip())
    }
}

/// Mean response of one row to a torque that acts for a period. The response at each instant is
/// weighted with its effect on the velocity at the end of the period.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Response {
    /// Acceleration relative to the acceleration at the beginning of the period.
    acceleration: f64,
    /// Velocity over the acceleration at the beginning of the period, s.
    velocity: f64,
}

impl Response {
    /// Returns the response of a velocity that decays with the rate λ.
    ///
    /// ```text
    /// u = λ T        acceleration u/(eᵘ − 1)        velocity (1 − u/(eᵘ − 1))/λ
    /// ```
    ///
    /// - `kept`: fraction `e⁻ᵘ` of a velocity that is left after the period T, s.
    fn new(kept: f64, period: f64) -> Self {
        let decay = -kept.clamp(f64::MIN_POSITIVE, 1.0).ln();
        // The series up to the second order avoids a difference of nearly equal numbers.
        if decay < 1e-4 {
            return Self {
                acceleration: 1.0 - decay / 2.0,
                velocity: period * (0.5 - decay / 12.0),
            };
        }
        let acceleration = decay / decay.exp_m1();
        Self {
            acceleration,
            velocity: period * (1.0 - acceleration) / decay,
        }
    }
}

impl Dynamics {
    /// Visits the changes of the parameters' torques when an additional torque of 1 N·m (N) acts on
    /// one row for a period. It accelerates the robot, and friction depends on the resulting
    /// velocity. The arguments of `visit` are the pushed row, row and column of theta of the
    /// changed torque, and its mean change.
    ///
    /// In the transition of Coulomb friction a velocity may decay faster than the sampling. The
    /// torque of the inertia then hardly changes, but the torque of the friction does.
    ///
    /// - `pushed`: rows that get the torque one after the other.
    pub(in crate::estimate::estimators::prediction_error) fn visit_pulse_torques(
        &mut self,
        pulse: Pulse<'_>,
        pushed: &[usize],
        mut visit: impl FnMut(usize, usize, usize, f64),
    ) {
        let rows = self.rows;
        let states = state_count(rows);
        let responses: Vec<Response> = (0..rows)
            .map(|row| {
                let kept = pulse.transition[(rows + row) * states + rows + row];
                Response::new(kept, pulse.period)
            })
            .collect();
        self.accelerate_and_invert(pulse.state, &vec![0.0; rows]);
        let mut moved = vec![0.0; 2 * rows];
        let mut rate = vec![0.0; rows];
        for &push in pushed {
            let inverse_column = self.inverse[push * rows..(push + 1) * rows].to_vec();
            for (row, (a, response)) in inverse_column.iter().zip(&responses).enumerate() {
                moved[rows + row] = a * response.velocity;
                rate[row] = a * response.acceleration;
            }
            let Some(torque) = pulse.scale_to_spread(&moved) else {
                continue;
            };
            scale(&mut moved, torque);
            scale(&mut rate, torque);
            self.write_changes(pulse.state, &moved, &rate);
            let places = self.regressor.rows.iter().zip(&self.regressor.columns);
            for (change, (&row, &column)) in self.regressor.changes.iter().zip(places) {
                if change.abs() > 0.0 {
                    visit(push, row, column, change / torque);
                }
            }
        }
    }

    /// Writes the mean changes of the entries of the regressor when the motion changes, to `changes`: half the
    /// difference between both directions. Changes as large as the standard deviation of the noise give the mean slope
    /// over the noise, which is far less than the central slope if friction reverses within the noise.
    fn write_changes(&mut self, state: &[f64], moved: &[f64], rate: &[f64]) {
        let mut at = vec![0.0; state.len()];
        for sign in [-1.0, 1.0] {
            for (at, (state, moved)) in at.iter_mut().zip(state.iter().zip(moved)) {
                *at = state + sign * moved;
            }
            for (entry, rate) in self.rate.iter_mut().zip(rate) {
                *entry = sign * rate;
            }
            self.unpack(&at);
            self.write_entries();
            if sign < 0.0 {
                self.regressor.changes.clone_from(&self.regressor.entries);
            }
        }
        for (change, after) in self
            .regressor
            .changes
            .iter_mut()
            .zip(&self.regressor.entries)
        {
            *change = 0.5 * (after - *change);
        }
    }

    /// Visits the changes of the parameters' torques when the state deviates, each row for its own
    /// deviation. The arguments of `visit` are row and column of theta of the changed torque, and its
    /// mean change over the period.
    ///
    /// - `begin`: deviation of coordinates, velocities and disturbances at the beginning of the
    ///   period for each row, \[rows × 3 rows\]; the torque of a disturbance is not counted.
    pub(in crate::estimate::estimators::prediction_error) fn visit_deviation_torques(
        &mut self,
        pulse: Pulse<'_>,
        begin: &[f64],
        mut visit: impl FnMut(usize, usize, f64),
    ) {
        let rows = self.rows;
        let states = state_count(rows);
        let mut rate = vec![0.0; rows];
        for (row, begin) in begin.chunks(states).enumerate() {
            // The motion changes by its mean over the period: positions, velocities, accelerations.
            let mut moved: Vec<f64> = begin[..2 * rows].to_vec();
            for i in 0..rows {
                let end = |i: usize| dot(&pulse.transition[i * states..][..states], begin);
                let (position, velocity) = (end(i), end(rows + i));
                rate[i] = (velocity - begin[rows + i]) / pulse.period;
                moved[rows + i] = (position - begin[i]) / pulse.period;
                moved[i] = 0.5 * (begin[i] + position);
            }
            let Some(part) = pulse.scale_to_spread(&moved) else {
                continue;
            };
            scale(&mut moved, part);
            scale(&mut rate, part);
            self.write_changes(pulse.state, &moved, &rate);
            for entry in self.model.equation_entries(row) {
                let change = self.regressor.changes[entry] / part;
                if change.abs() > 0.0 {
                    visit(row, self.regressor.columns[entry], change);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::{no_files, read};
    use crate::estimate::estimators::prediction_error::dynamics::{Steps, Tangent};
    use crate::model::Model;

    /// A carriage on a spring, whose motor has Coulomb friction.
    const CARRIAGE: &str = r#"
        format = 1
        [robot]
        name = "carriage"
        dh_modified = [{ prismatic = true }]
        gravity_m_per_s2 = [0.0, -9.81, 0.0]
        [[robot.joint]]
        name = "carriage"
        link_friction = ["viscous"]
        motor_friction = ["viscous", "coulomb"]
        coulomb_sharpness_s_per_rad = 100.0
        [identify]
        encoder_offset = "none"
    "#;

    /// Masses of carriage and rotor, kg; viscous friction of both, N s/m; stiffness, N/m; Coulomb
    /// friction of the motor, N. In the transition the velocity of the rotor decays with 1200 1/s.
    const THETA: [f64; 6] = [2.0, 0.5, 0.3, 0.7, 900.0, 6.0];
    const ROWS: usize = 2;
    const STATES: usize = 6;
    const PERIOD: f64 = 4e-3;

    #[test]
    fn responses_follow_from_the_decay() {
        let slow = Response::new(1.0, 1e-3);
        assert!((slow.acceleration - 1.0).abs() < 1e-12 && (slow.velocity - 5e-4).abs() < 1e-15);
        // Both forms agree where one replaces the other.
        let [below, above] = [0.999e-4_f64, 1.001e-4].map(|u| Response::new((-u).exp(), 1e-3));
        assert!((below.acceleration - above.acceleration).abs() < 2e-7);
        assert!((below.velocity - above.velocity).abs() < 1e-10);
        let fast = Response::new((-5.0_f64).exp(), 1e-3);
        assert!((fast.acceleration - 5.0 / (5.0_f64.exp() - 1.0)).abs() < 1e-12);
        assert!((fast.velocity - 1e-3 / 5.0 * (1.0 - fast.acceleration)).abs() < 1e-15);
    }

    /// Returns positions and velocities after a period, and their derivatives.
    fn advance(model: &Model, start: &[f64], torque: &[f64]) -> (Vec<f64>, Tangent) {
        let mut dynamics = Dynamics::new(model, &THETA);
        let places = (0..THETA.len()).map(Some).collect();
        let mut tangent = Tangent::new(ROWS, THETA.len(), places, Vec::new());
        let mut x = start.to_vec();
        let steps = Steps {
            count: 64,
            is_smooth: false,
        };
        dynamics.advance_tangent(&mut x, torque, PERIOD, steps, &mut tangent);
        (x, tangent)
    }

    #[test]
    fn pulses_give_the_mixed_derivatives_of_the_motion() {
        let experiment = read("carriage", CARRIAGE, &[], &mut no_files).unwrap();
        let model = Model::new(&experiment).unwrap();
        let at = |name: &str| model.index_of(name).unwrap();
        let motor = 1;
        // The friction is in its transition, then outside of it.
        for velocity in [0.0, 0.2] {
            let start = [0.0, 0.0, velocity, velocity];
            let (end, tangent) = advance(&model, &start, &[0.0, 0.1]);
            let middle: Vec<f64> = start.iter().zip(&end).map(|(a, b)| 0.5 * (a + b)).collect();
            let transition = tangent.transition;
            let mut found = vec![0.0; THETA.len()];
            let pulse = Pulse {
                state: &middle,
                transition: &transition,
                period: PERIOD,
                spread: &[0.0; 2 * ROWS],
            };
            let by_torque = transition[(ROWS + motor) * STATES + 2 * ROWS + motor];
            Dynamics::new(&model, &THETA).visit_pulse_torques(
                pulse,
                &[motor],
                |_, row, c, torque| {
                    if row == motor {
                        found[c] -= torque * by_torque;
                    }
                },
            );
            let h = 1e-4;
            let [more, less] =
                [h, -h].map(|h| advance(&model, &start, &[0.0, 0.1 + h]).1.sensitivity);
            for name in [
                "carriage.rotor_inertia",
                "carriage.motor_viscous",
                "carriage.motor_coulomb",
            ] {
                let column = (ROWS + motor) * THETA.len() + at(name);
                let expected = (more[column] - less[column]) / (2.0 * h);
                // The mean decay of a period replaces the decay at each instant. Without the decay the first number
                // would be 27 times too large, and the last one zero, so a tenth and a hundredth show that it is right.
                let limit = if velocity > 0.0 { 0.01 } else { 0.1 };
                assert!(
                    (found[at(name)] - expected).abs() <= limit * expected.abs() + 1e-12,
                    "{name} at {velocity}: {} instead of {expected}",
                    found[at(name)]
                );
            }
        }
    }
}
