//! The robot over one sampling period, and its derivatives.
//!
//! State: the coordinates of all rows, then their velocities, \[2 rows\]. Inputs:
//! one torque per row, held for the period.

use sprung_core::drives::{Drive, State};
use sprung_core::linearized::{Derivatives, Partial, Partials};
use sprung_core::links::Step;
use sprung_core::robot::Values;
use sprung_core::scalar::Scalar;
use sprung_core::spatial::BODY;

use super::vector::add;
use crate::model::{Model, Scratch, Theta};

/// What the fastest friction may pull a velocity in one step of the integration,
/// and the phase that the fastest spring may swing through, rad: Runge-Kutta of
/// order 4 is stable to 2.7, and off by 1e-3 of a swing at 0.7.
const MAX_DAMPING_PER_STEP: f64 = 1.2;
const MAX_PHASE_PER_STEP: f64 = 0.7;

/// Steps of the integration in a period, at most.
const MAX_STEPS: usize = 64;

/// Derivatives that travel with the state: those of the state \[2 rows × columns\]
/// and those of the torques \[rows × columns\], row by row.
///
/// Of the last columns, `theta` says which parameter each is the derivative by.
#[derive(Clone, Debug)]
pub(super) struct Tangent {
    pub(super) columns: usize,
    pub(super) state: Vec<f64>,
    pub(super) torque: Vec<f64>,
    /// Column of each parameter of theta; nothing if it is not wanted.
    pub(super) theta: Vec<Option<usize>>,
    stage: Vec<f64>,
    sum: Vec<f64>,
    force: Vec<f64>,
    rate: Vec<f64>,
}

impl Tangent {
    /// Returns zero derivatives.
    pub(super) fn new(rows: usize, columns: usize, theta: Vec<Option<usize>>) -> Self {
        let zeros = |count: usize| vec![0.0; count * columns];
        Self {
            columns,
            state: zeros(2 * rows),
            torque: zeros(rows),
            theta,
            stage: zeros(2 * rows),
            sum: zeros(2 * rows),
            force: zeros(rows),
            rate: zeros(rows),
        }
    }
}

/// A robot with its parameters, ready to move.
#[derive(Clone, Debug)]
pub(super) struct Dynamics<'m> {
    model: &'m Model,
    theta: Theta,
    bodies: Vec<[f64; BODY]>,
    n: usize,
    rows: usize,
    motors: Vec<usize>,
    scratch: Scratch,
    // q, dq, phi, dphi.
    joints: Vec<f64>,
    inverse: Vec<f64>,
    by_position: Vec<f64>,
    by_velocity: Vec<f64>,
    entries: Vec<f64>,
    // Column of theta of each entry.
    entry_columns: Vec<usize>,
    entry_rows: Vec<usize>,
    partials: [Vec<Partial>; 4],
    steps: Vec<Step<Partial>>,
    // States and rates of a step.
    at: Vec<f64>,
    rate: Vec<f64>,
    sum: Vec<f64>,
}

impl<'m> Dynamics<'m> {
    pub(super) fn new(model: &'m Model, theta: &[f64]) -> Self {
        let robot = model.robot();
        let (n, rows) = (robot.joints(), robot.rows());
        let mut entry_columns = vec![0; model.entries()];
        let mut entry_rows = vec![0; model.entries()];
        for row in 0..rows {
            let columns = model.row_columns(row).iter();
            for (entry, &column) in model.row_entries(row).zip(columns) {
                entry_columns[entry] = column;
                entry_rows[entry] = row;
            }
        }
        Self {
            model,
            bodies: model.bodies(theta),
            theta: theta.to_vec(),
            n,
            rows,
            motors: (0..n).map(|joint| robot.motor_coordinate(joint)).collect(),
            scratch: Scratch::new(n),
            joints: vec![0.0; 4 * n],
            inverse: vec![0.0; rows * rows],
            by_position: vec![0.0; rows * rows],
            by_velocity: vec![0.0; rows * rows],
            entries: vec![0.0; model.entries()],
            entry_columns,
            entry_rows,
            partials: std::array::from_fn(|_| vec![Partial::ZERO; n]),
            steps: vec![Step::default(); n],
            at: vec![0.0; 2 * rows],
            rate: vec![0.0; rows],
            sum: vec![0.0; 2 * rows],
        }
    }

    pub(super) fn rows(&self) -> usize {
        self.rows
    }

    /// Replaces the parameters.
    pub(super) fn set(&mut self, theta: &[f64]) {
        self.theta.copy_from_slice(theta);
        self.bodies = self.model.bodies(theta);
    }

    fn unpack(&mut self, x: &[f64]) {
        let (positions, velocities) = x.split_at(self.rows);
        let n = self.n;
        self.joints[..n].copy_from_slice(&positions[..n]);
        self.joints[n..2 * n].copy_from_slice(&velocities[..n]);
        for (joint, &motor) in self.motors.iter().enumerate() {
            self.joints[2 * n + joint] = positions[motor];
            self.joints[3 * n + joint] = velocities[motor];
        }
    }

    /// Writes the accelerations at a state, and what derivatives need.
    fn rate(&mut self, x: &[f64], torque: &[f64], tangent: bool) {
        self.unpack(x);
        let state = state(&self.joints, self.n);
        let values = Values {
            theta: &self.theta,
            bodies: &self.bodies,
        };
        let robot = self.model.robot();
        let mut workspace = self.scratch.workspace();
        let (rate, inverse) = (&mut self.rate, &mut self.inverse);
        let mut fits = robot.motion(&values, &state, torque, &mut workspace, rate, inverse);
        if tangent && fits.is_ok() {
            let [q, dq, ddq, tau] = &mut self.partials;
            let mut partials = Partials {
                numbers: [q, dq, ddq, tau],
                steps: &mut self.steps,
            };
            let mut out = Derivatives {
                by_position: &mut self.by_position,
                by_velocity: &mut self.by_velocity,
            };
            fits = robot
                .derivatives(
                    &values,
                    &state,
                    rate,
                    inverse,
                    &mut workspace,
                    &mut partials,
                    &mut out,
                )
                .and_then(|()| {
                    robot.torque_entries(&state, rate, &mut workspace, &mut self.entries)
                });
        }
        if fits.is_err() {
            // The memory is made to fit, so there is no other outcome.
            self.rate.fill(f64::NAN);
        }
    }

    /// Visits what the parameters' torques change by where a torque of 1 N·m (N) on one
    /// row more accelerates the robot: that row, row and column of theta of the torque,
    /// and its change.
    ///
    /// - `positions`: of all rows; `pushed`: rows that get the torque in turn.
    pub(super) fn visit_acceleration_torques(
        &mut self,
        positions: &[f64],
        pushed: &[usize],
        mut visit: impl FnMut(usize, usize, usize, f64),
    ) {
        let rows = self.rows;
        let mut rest = positions.to_vec();
        rest.resize(2 * rows, 0.0);
        self.rate(&rest, &vec![0.0; rows], false);
        self.rate.fill(0.0);
        self.write_entries();
        let before = self.entries.clone();
        for &push in pushed {
            self.rate
                .copy_from_slice(&self.inverse[push * rows..(push + 1) * rows]);
            self.write_entries();
            let places = self.entry_rows.iter().zip(&self.entry_columns);
            for ((after, before), (&row, &column)) in self.entries.iter().zip(&before).zip(places) {
                let change = after - before;
                if change.abs() > 0.0 {
                    visit(push, row, column, change);
                }
            }
        }
    }

    /// Writes the entries of the regressor at the state that was unpacked last.
    fn write_entries(&mut self) {
        let state = state(&self.joints, self.n);
        let mut workspace = self.scratch.workspace();
        let robot = self.model.robot();
        let fits = robot.torque_entries(&state, &self.rate, &mut workspace, &mut self.entries);
        if fits.is_err() {
            self.entries.fill(f64::NAN);
        }
    }

    /// Returns how many steps the integration of a period needs: friction and
    /// springs say how fast the motion can change.
    ///
    /// - `x`: the state, \[2 rows\]; `torque`: \[rows\].
    pub(super) fn steps(&mut self, x: &[f64], torque: &[f64], period: f64) -> usize {
        self.rate(x, torque, false);
        let robot = self.model.robot();
        let rows = self.rows;
        // Friction at the slowest velocity that the period comes by.
        let slowest = |row: usize| {
            let (from, change) = (x[rows + row], self.rate[row] * period);
            // A period that misses the reversal by little may end in it.
            let (low, high) = (from.min(from + 1.5 * change), from.max(from + 1.5 * change));
            if low <= 0.0 && high >= 0.0 {
                0.0
            } else {
                low.abs().min(high.abs())
            }
        };
        let mut pull = vec![0.0; rows];
        let mut spring = vec![0.0; rows];
        for term in robot.terms {
            let (joint, motor) = (term.joint, self.motors[term.joint]);
            let drive = Drive {
                deflection: x[motor] - x[joint],
                deflection_rate: x[rows + motor] - x[rows + joint],
                link_velocity: slowest(joint),
                motor_velocity: slowest(motor),
            };
            let slopes = term.slopes(&drive, &robot.shapes[joint]);
            let mass = self.inverse[term.row * rows + term.row];
            let value = self.theta[term.column].abs() * mass;
            spring[term.row] += value * slopes.deflection.abs();
            for slope in [
                slopes.deflection_rate,
                slopes.link_velocity,
                slopes.motor_velocity,
            ] {
                pull[term.row] += value * slope.abs();
            }
        }
        let most = |all: &[f64]| all.iter().fold(0.0_f64, |m, x| m.max(*x));
        let needed = (most(&pull) * period / MAX_DAMPING_PER_STEP)
            .max(most(&spring).sqrt() * period / MAX_PHASE_PER_STEP);
        if needed.is_finite() {
            (needed.ceil() as usize).clamp(1, MAX_STEPS)
        } else {
            1
        }
    }

    /// Moves the state by one period.
    ///
    /// - `steps`: of the integration.
    pub(super) fn advance(&mut self, x: &mut [f64], torque: &[f64], period: f64, steps: usize) {
        let rows = self.rows;
        let h = period / steps as f64;
        let mut at = std::mem::take(&mut self.at);
        for _ in 0..steps {
            at.copy_from_slice(x);
            self.sum.fill(0.0);
            for (weight, ahead) in STAGES {
                self.rate(&at, torque, false);
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

    /// Moves the state by one period, and its derivatives exactly along.
    pub(super) fn advance_tangent(
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
                self.rate(&at, torque, true);
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

/// Returns positions and velocities of links and motors as the model names them.
fn state(joints: &[f64], n: usize) -> State<'_> {
    let (link, motor) = joints.split_at(2 * n);
    State {
        q: &link[..n],
        dq: &link[n..],
        phi: &motor[..n],
        dphi: &motor[n..],
    }
}

/// Weight of each stage of the Runge-Kutta method of order 4 in sixths, and how
/// far ahead the next stage looks, in steps.
const STAGES: [(f64, f64); 4] = [(1.0, 0.5), (2.0, 0.5), (2.0, 1.0), (1.0, 0.0)];

/// Writes where the next stage looks.
fn next(x: &[f64], step: f64, rate: &[f64], at: &mut [f64]) {
    let rows = rate.len();
    let (positions, velocities) = at.split_at_mut(rows);
    for i in 0..rows {
        positions[i] = x[i] + step * velocities[i];
        velocities[i] = x[rows + i] + step * rate[i];
    }
}
