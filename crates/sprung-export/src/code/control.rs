//! The controller of the code: its constants, and samples of the library for the self-test.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sprung_core::controller::{pd, state_feedback};
use sprung_core::drives::State;
use sprung_core::links::LengthError;
use sprung_core::velocity::{AveragedVelocity, VelocityError};

use super::trace::Source;
use crate::controller::{ControllerCode, FeedbackCode, ShaperTap};

/// Samples of the self-test beside the delays of the shaper.
const SAMPLES: usize = 24;

/// Samples of the self-test at most for the delays.
const MAX_DELAYED: usize = 40;

/// Last samples of the self-test: the measured positions are so far away that torques reach their
/// limits.
const FAR: usize = 3;

/// A torque that stands for none.
const NO_LIMIT: f64 = 1e30;

/// Errors of the self-test's samples.
#[derive(Debug, thiserror::Error)]
pub(super) enum ControlError {
    #[error(transparent)]
    Length(#[from] LengthError),
    #[error(transparent)]
    Velocity(#[from] VelocityError),
}

/// A sample of the controller.
#[derive(Clone, Debug)]
pub(super) struct Sample {
    /// Desired positions, then their derivatives, \[5n\].
    wanted: Vec<f64>,
    /// Measured positions.
    q: Vec<f64>,
    phi: Vec<f64>,
    /// Torques and rotor motion of the feedforward for the desired motion, which is not shaped.
    nominal: [Vec<f64>; 3],
    /// Torques of the controller.
    tau: Vec<f64>,
}

impl Sample {
    /// Returns all arrays, in the order of the self-tests.
    pub(super) fn all(&self) -> [&[f64]; 7] {
        let [tau_ff, phi_d, dphi_d] = &self.nominal;
        [
            &self.wanted,
            &self.q,
            &self.phi,
            tau_ff,
            phi_d,
            dphi_d,
            &self.tau,
        ]
    }
}

/// A controller as code.
pub(super) struct Control<'a> {
    pub(super) code: &'a ControllerCode,
    pub(super) taps: Vec<ShaperTap>,
    pub(super) samples: Vec<Sample>,
}

impl<'a> Control<'a> {
    /// Runs the controller of the library on random motions.
    ///
    /// # Errors
    ///
    /// [`ControlError`] if the controller does not fit the robot.
    pub(super) fn new(source: &Source<'_>, code: &'a ControllerCode) -> Result<Self, ControlError> {
        let mut own = Self {
            code,
            taps: code.taps(),
            samples: Vec::new(),
        };
        // The motion must be so small that most torques are below their limits.
        for halvings in 0..10 {
            own.samples = own.run(source, 0.5_f64.powi(halvings))?;
            let near = own.samples.len() - FAR;
            let all = (own.samples[..near].iter()).flat_map(|sample| {
                (sample.tau.iter().zip(&code.torque_limits)).map(|(tau, limit)| tau.abs() < *limit)
            });
            let (inside, count) = (all.clone().filter(|inside| *inside).count(), all.count());
            if 2 * inside >= count {
                break;
            }
        }
        Ok(own)
    }

    /// Returns the largest torques as numbers of the code.
    pub(super) fn limits(&self) -> Vec<f64> {
        let limits = self.code.torque_limits.iter();
        limits.map(|limit| limit.min(NO_LIMIT)).collect()
    }

    /// Returns the number of samples that the shaper remembers.
    pub(super) fn shaped(&self) -> usize {
        1 + self.taps.iter().map(|tap| tap.delay).max().unwrap_or(0)
    }

    /// Returns the samples of both averages of the velocity.
    pub(super) fn windows(&self) -> [usize; 2] {
        self.code.velocity_window.map(|p| p + 1)
    }

    /// Returns the factor of the sum of differences in a velocity, 1/s.
    pub(super) fn velocity_scale(&self) -> f64 {
        let [positions, rates] = self.windows();
        1.0 / (self.code.period * (positions * rates) as f64)
    }

    fn run(&self, source: &Source<'_>, size: f64) -> Result<Vec<Sample>, ControlError> {
        let n = source.robot.joints();
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let mut waves = |size: f64| -> Vec<[f64; 3]> {
            let wave = |_| {
                [
                    size * random.random_range(0.2..1.0),
                    random.random_range(1.0..8.0),
                    random.random_range(-3.0..3.0),
                ]
            };
            (0..n).map(wave).collect()
        };
        let wanted = waves(size);
        let [of_link, of_motor] = [1e-3, 1e-4].map(|part| waves(part * size));
        let [p1, p2] = self.code.velocity_window;
        let mut velocities = vec![AveragedVelocity::new(p1, p2, self.code.period)?; 2 * n];
        let count = SAMPLES + FAR + self.shaped().min(MAX_DELAYED);
        let mut past: Vec<Vec<[f64; 5]>> = Vec::new();
        let mut samples = Vec::new();
        for k in 0..count {
            let t = k as f64 * self.code.period;
            let far = if k + FAR < count { 1.0 } else { 1e6 };
            past.push(wanted.iter().map(|wave| derivatives(wave, t)).collect());
            let shaped = self.shape(&past);
            let nominal = source.nominal(&self.code.feedforward, &shaped)?;
            let beside = |wave: &[f64; 3]| far * derivatives(wave, t)[0];
            let q: Vec<f64> = (shaped.iter().zip(&of_link))
                .map(|(d, wave)| d[0] + beside(wave))
                .collect();
            let phi: Vec<f64> = (0..n)
                .map(|i| match source.robot.motor_rows[i] {
                    Some(_) => nominal[1][i] + beside(&of_motor[i]),
                    None => q[i],
                })
                .collect();
            let rates: Vec<f64> = (velocities.iter_mut().zip(q.iter().chain(&phi)))
                .map(|(velocity, position)| velocity.process(*position))
                .collect();
            let tau = self.torques(&shaped, &nominal, [&q, &phi], &rates);
            let direct = past.last().cloned().unwrap_or_default();
            samples.push(Sample {
                wanted: (0..5)
                    .flat_map(|order| direct.iter().map(move |d| d[order]))
                    .collect(),
                nominal: source.nominal(&self.code.feedforward, &direct)?,
                q,
                phi,
                tau,
            });
        }
        Ok(samples)
    }

    /// Returns the shaped motion. Before the first sample, the desired motion rests.
    fn shape(&self, past: &[Vec<[f64; 5]>]) -> Vec<[f64; 5]> {
        let newest = past.len() - 1;
        let at = |delay: usize, i: usize, order: usize| match newest.checked_sub(delay) {
            Some(k) => past[k][i][order],
            None if order == 0 => past[0][i][0],
            None => 0.0,
        };
        let taps = self.taps.iter();
        (0..past[newest].len())
            .map(|i| {
                std::array::from_fn(|order| {
                    let parts = taps.clone();
                    parts
                        .map(|tap| tap.weight * at(tap.delay, i, order))
                        .sum::<f64>()
                })
            })
            .collect()
    }

    /// Returns the limited torques.
    fn torques(
        &self,
        shaped: &[[f64; 5]],
        [tau_ff, phi_d, dphi_d]: &[Vec<f64>; 3],
        [q, phi]: [&[f64]; 2],
        rates: &[f64],
    ) -> Vec<f64> {
        let (dq, dphi) = rates.split_at(q.len());
        let [q_d, dq_d] = [0, 1].map(|order| -> Vec<f64> {
            let own = shaped.iter();
            own.map(|d| d[order]).collect()
        });
        let state = |q, dq, phi, dphi| State {
            q,
            dq,
            phi,
            dphi,
            excess: &[],
        };
        let mut tau = tau_ff.clone();
        match &self.code.feedback {
            FeedbackCode::State { gain } => {
                let gain: Vec<&[f64]> = gain.iter().map(Vec::as_slice).collect();
                let desired = state(&q_d, &dq_d, phi_d, dphi_d);
                state_feedback(&gain, &desired, &state(q, dq, phi, dphi), &mut tau);
            }
            FeedbackCode::Motors { kp, kd } => {
                let mut feedback = vec![0.0; tau.len()];
                pd(kp, kd, [phi_d, dphi_d], [phi, dphi], &mut feedback);
                for (tau, own) in tau.iter_mut().zip(feedback) {
                    *tau += own;
                }
            }
        }
        (tau.iter().zip(&self.code.torque_limits))
            .map(|(tau, limit)| tau.clamp(-limit, *limit))
            .collect()
    }
}

/// Returns a sine and its derivatives up to the fourth.
///
/// - `wave`: amplitude, frequency in rad/s, phase.
fn derivatives([amplitude, w, phase]: &[f64; 3], t: f64) -> [f64; 5] {
    let (sin, cos) = (w * t + phase).sin_cos();
    let turns = [sin, cos, -sin, -cos, sin];
    std::array::from_fn(|order| amplitude * w.powi(order as i32) * turns[order])
}
