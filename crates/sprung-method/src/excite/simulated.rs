//! A closed loop of PD control on the motors, simulated from rest, and its adjoint equations.
//!
//! Runge-Kutta steps of order 4 integrate the loop. The adjoint runs through the same steps in reverse order, so the
//! gradient is that of the simulated motion without further error.

use faer::Mat;
use sprung_core::robot::Torques;

use super::motion::{ByMotion, Moved, fill_torque, waves};
use super::physics::{MotionAt, Physics};
use crate::description::Controller;

/// The steps of a simulation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Steps {
    /// s.
    pub(super) step: f64,
    /// Steps between samples.
    pub(super) every: usize,
    pub(super) samples: usize,
}

/// A closed loop over the duration of an experiment.
#[derive(Clone, Debug)]
pub(super) struct Simulated {
    physics: Physics,
    kp: Vec<f64>,
    kd: Vec<f64>,
    step: f64,
    /// Steps between samples.
    every: usize,
    samples: usize,
    /// Basis functions and their derivatives at half steps.
    waves: Vec<Mat<f64>>,
    /// References of positions and velocities at half steps, \[half steps × n\].
    reference: [Mat<f64>; 2],
    torque: Vec<f64>,
    motor: Vec<f64>,
}

/// Stages of a Runge-Kutta step.
const STAGES: usize = 4;

/// Position beyond which the loop counts as unstable, rad (m).
const RUNAWAY: f64 = 100.0;

impl Simulated {
    /// - `rate`, `harmonics`: of the references.
    pub(super) fn new(
        physics: Physics,
        controller: &Controller,
        (rate, harmonics): (f64, &[usize]),
        steps: Steps,
    ) -> Self {
        let Steps {
            step,
            every,
            samples,
        } = steps;
        let times: Vec<f64> = (0..=2 * every * samples)
            .map(|k| 0.5 * step * k as f64)
            .collect();
        Self {
            kp: controller.kp_nm_per_rad.clone(),
            kd: controller.kd_nms_per_rad.clone(),
            step,
            every,
            samples,
            waves: waves(rate, harmonics, 2, &times),
            torque: vec![0.0; physics.model.coordinates()],
            motor: vec![0.0; physics.model.joint_count()],
            reference: [Mat::zeros(0, 0), Mat::zeros(0, 0)],
            physics,
        }
    }

    /// Returns positions and velocities of all joints of a state.
    fn unpack(&self, x: &[f64], at: &mut MotionAt) {
        let model = &self.physics.model;
        let (positions, velocities) = x.split_at(model.coordinates());
        for joint in 0..model.joint_count() {
            let motor = model.torque_row(joint);
            at.link[0][joint] = positions[joint];
            at.link[1][joint] = velocities[joint];
            at.motor[0][joint] = positions[motor];
            at.motor[1][joint] = velocities[motor];
        }
    }

    /// Writes the torques on all coordinates, at a half step.
    fn command(&mut self, half: usize, at: &MotionAt) {
        let [position, velocity] = &self.reference;
        for (joint, motor) in self.motor.iter_mut().enumerate() {
            *motor = self.kp[joint] * (position[(half, joint)] - at.motor[0][joint])
                + self.kd[joint] * (velocity[(half, joint)] - at.motor[1][joint]);
        }
        let torques = Torques {
            motor: &self.motor,
            link: None,
        };
        if (self
            .physics
            .model
            .robot()
            .coordinate_torques(&torques, &mut self.torque))
        .is_err()
        {
            self.torque.fill(f64::NAN);
        }
    }

    /// Prepares the references of coefficients.
    fn refer(&mut self, coefficients: &[Vec<f64>]) {
        let given = Mat::from_fn(coefficients[0].len(), coefficients.len(), |i, j| {
            coefficients[j][i]
        });
        self.reference = [0, 1].map(|order: usize| &self.waves[order] * &given);
    }

    /// Writes the rate of a state.
    fn rate(&mut self, half: usize, x: &[f64], at: &mut MotionAt, out: &mut [f64]) {
        let rows = x.len() / 2;
        self.unpack(x, at);
        self.command(half, at);
        self.physics.accelerate(at, &self.torque);
        out[..rows].copy_from_slice(&x[rows..]);
        out[rows..].copy_from_slice(&self.physics.rate);
    }

    /// Returns the states at the stages of a step, and the rates there.
    fn stages(
        &mut self,
        k: usize,
        x: &[f64],
        at: &mut MotionAt,
        stages: &mut [[Vec<f64>; 2]; STAGES],
    ) {
        let h = self.step;
        for (stage, (half, factor)) in [(0, 0.0), (1, 0.5), (1, 0.5), (2, 1.0)]
            .into_iter()
            .enumerate()
        {
            let (done, rest) = stages.split_at_mut(stage);
            let [y, rate] = &mut rest[0];
            y.copy_from_slice(x);
            if let Some([_, before]) = done.last() {
                for (y, before) in y.iter_mut().zip(before) {
                    *y += factor * h * before;
                }
            }
            self.rate(2 * k + half, y, at, rate);
        }
    }

    fn start(&mut self) -> (Vec<f64>, MotionAt) {
        let model = self.physics.model.clone();
        let n = model.joint_count();
        let mut at = MotionAt::zero(n);
        for joint in 0..n {
            at.link[0][joint] = self.reference[0][(0, joint)];
        }
        let mut entries = vec![0.0; model.robot().entries];
        let mut deflections = vec![0.0; n];
        self.physics.entries(&at, &mut entries);
        self.physics.deflections(&entries, &mut deflections);
        let mut x = vec![0.0; 2 * model.coordinates()];
        for joint in 0..n {
            x[joint] = at.link[0][joint];
            let motor = model.torque_row(joint);
            if motor >= n {
                x[motor] = at.link[0][joint] + deflections[joint];
            }
        }
        (x, at)
    }

    pub(super) fn run(&mut self, coefficients: &[Vec<f64>]) -> Option<Moved> {
        let model = self.physics.model.clone();
        let (n, rows) = (model.joint_count(), model.coordinates());
        let count = model.robot().entries;
        self.refer(coefficients);
        let (mut x, _) = self.start();
        let mut instant = MotionAt::zero(n);
        let mut stages: [[Vec<f64>; 2]; STAGES] =
            std::array::from_fn(|_| std::array::from_fn(|_| vec![0.0; 2 * rows]));
        let steps = self.every * self.samples;
        let mut trace = Vec::with_capacity(STAGES * steps * 2 * rows);
        let mut at = Vec::with_capacity(self.samples);
        let mut entries = Mat::zeros(self.samples, count);
        let mut torque = Mat::zeros(self.samples, rows);
        let mut sample_entries = vec![0.0; count];
        for k in 0..steps {
            self.stages(k, &x, &mut instant, &mut stages);
            for [state, _] in &stages {
                trace.extend_from_slice(state);
            }
            if k % self.every == 0 {
                let t = k / self.every;
                self.unpack(&x, &mut instant);
                for joint in 0..n {
                    instant.link[2][joint] = stages[0][1][rows + joint];
                    instant.motor[2][joint] = stages[0][1][rows + model.torque_row(joint)];
                }
                self.physics.entries(&instant, &mut sample_entries);
                for (entry, x) in sample_entries.iter().enumerate() {
                    entries[(t, entry)] = *x;
                }
                fill_torque(&self.physics, &sample_entries, |row, sum| {
                    torque[(t, row)] = sum;
                });
                at.push(instant.clone());
            }
            for (i, x) in x.iter_mut().enumerate() {
                let [a, b, c, d] = [0, 1, 2, 3].map(|s: usize| stages[s][1][i]);
                *x += self.step / 6.0 * (a + 2.0 * (b + c) + d);
            }
            if !x.iter().all(|x| x.abs() < RUNAWAY) {
                return None;
            }
        }
        Some(Moved {
            at,
            entries,
            torque,
            trace,
            coefficients: coefficients.to_vec(),
        })
    }

    pub(super) fn pull(&mut self, moved: &Moved, by: &ByMotion) -> Vec<Vec<f64>> {
        let model = self.physics.model.clone();
        let (n, rows) = (model.joint_count(), model.coordinates());
        self.refer(&moved.coefficients);
        let count = moved.entries.ncols();
        let mut out = [0, 1].map(|order: usize| Mat::zeros(self.waves[order].nrows(), n));
        let mut instant = MotionAt::zero(n);
        let mut motion = MotionAt::zero(n);
        let mut adjoint = vec![0.0; 2 * rows];
        let [mut back, mut sum, mut by_rate] = [0, 1, 2].map(|_| vec![0.0; 2 * rows]);
        for k in (0..self.every * self.samples).rev() {
            let state = |stage: usize| {
                let first = (STAGES * k + stage) * 2 * rows;
                &moved.trace[first..first + 2 * rows]
            };
            let h = self.step;
            sum.copy_from_slice(&adjoint);
            back.fill(0.0);
            for (stage, (weight, next, half)) in
                [(1.0, 0.5, 0), (2.0, 0.5, 1), (2.0, 1.0, 1), (1.0, 0.0, 2)]
                    .into_iter()
                    .enumerate()
                    .rev()
            {
                // `back` has the derivative by the state of the next stage.
                for ((by, adjoint), back) in by_rate.iter_mut().zip(&adjoint).zip(&back) {
                    *by = h / 6.0 * weight * adjoint + next * h * back;
                }
                let y = state(stage);
                self.back(2 * k + half, y, &by_rate, &mut instant, &mut back, &mut out);
                for (sum, back) in sum.iter_mut().zip(&back) {
                    *sum += back;
                }
            }
            std::mem::swap(&mut adjoint, &mut sum);
            if k % self.every == 0 {
                let t = k / self.every;
                motion.clear();
                let weights = (0..count).map(|entry| by.entries[(t, entry)]);
                self.physics.pull(&moved.at[t], weights, &mut motion);
                for order in 0..3 {
                    for joint in 0..n {
                        motion.link[order][joint] += by.at[t].link[order][joint];
                        motion.motor[order][joint] += by.at[t].motor[order][joint];
                    }
                }
                // Accelerations follow from the state as in the first stage.
                by_rate.fill(0.0);
                for joint in 0..n {
                    let motor = model.torque_row(joint);
                    by_rate[rows + joint] += motion.link[2][joint];
                    by_rate[rows + motor] += motion.motor[2][joint];
                }
                self.back(2 * k, state(0), &by_rate, &mut instant, &mut back, &mut out);
                for (adjoint, back) in adjoint.iter_mut().zip(&back) {
                    *adjoint += back;
                }
                for joint in 0..n {
                    let motor = model.torque_row(joint);
                    for order in 0..2 {
                        adjoint[order * rows + joint] += motion.link[order][joint];
                        adjoint[order * rows + motor] += motion.motor[order][joint];
                    }
                }
            }
        }
        self.pull_start(&adjoint, &mut out);
        let by = self.waves[0].transpose() * &out[0] + self.waves[1].transpose() * &out[1];
        (0..n)
            .map(|joint| (0..by.nrows()).map(|i| by[(i, joint)]).collect())
            .collect()
    }

    /// Adds derivatives by the state at the start, which follows from the reference.
    fn pull_start(&mut self, adjoint: &[f64], out: &mut [Mat<f64>; 2]) {
        let (_, at) = self.start();
        let model = self.physics.model.clone();
        let n = model.joint_count();
        let mut by = MotionAt::zero(n);
        let of_motors: Vec<f64> = (0..n)
            .map(|joint| match model.torque_row(joint) {
                row if row >= n => adjoint[row],
                _ => 0.0,
            })
            .collect();
        self.physics.pull_deflections(&at, &of_motors, &mut by);
        for joint in 0..n {
            out[0][(0, joint)] += adjoint[joint] + of_motors[joint] + by.link[0][joint];
        }
    }

    /// Writes the derivatives by a state from those by its rate, and adds those by the reference.
    fn back(
        &mut self,
        half: usize,
        x: &[f64],
        by_rate: &[f64],
        at: &mut MotionAt,
        by_state: &mut [f64],
        out: &mut [Mat<f64>; 2],
    ) {
        let rows = x.len() / 2;
        self.unpack(x, at);
        self.command(half, at);
        self.physics.differentiate(at, &self.torque);
        let physics = &self.physics;
        let by_acceleration = &by_rate[rows..];
        for i in 0..rows {
            let column = |matrix: &[f64]| -> f64 {
                (by_acceleration.iter().enumerate())
                    .map(|(row, by)| by * matrix[row * rows + i])
                    .sum()
            };
            by_state[i] = column(&physics.by_position);
            by_state[rows + i] = by_rate[i] + column(&physics.by_velocity);
        }
        for joint in 0..self.kp.len() {
            let motor = physics.model.torque_row(joint);
            let by_torque: f64 = (by_acceleration.iter().enumerate())
                .map(|(row, by)| by * physics.inverse[row * rows + motor])
                .sum();
            let (p, d) = (self.kp[joint] * by_torque, self.kd[joint] * by_torque);
            by_state[motor] -= p;
            by_state[rows + motor] -= d;
            out[0][(half, joint)] += p;
            out[1][(half, joint)] += d;
        }
    }
}
