//! The controller of the code: its constants, and a run of the library's controller for the self-test.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sprung_core::controller::{pd, state_feedback};
use sprung_core::links::LengthError;
use sprung_core::shaper::{Shaper, ShaperError, Tap, memory_len};
use sprung_core::velocity::VelocityError;

use super::emit::Language;
use super::feedforward::DesiredMotion;
use super::trace::Source;
use crate::controller::ControlCode;
use crate::description::{Controller, ControllerKind};
use crate::reload::state;

/// Samples of the self-test beside the delays of the shaper.
const SAMPLES: usize = 40;

/// Samples of the self-test at most for the delays.
const MAX_DELAYED: usize = 40;

/// Last samples of the self-test: the measured positions are so far away that torques reach both
/// limits.
const FAR: usize = 3;

/// A torque that represents none.
const NO_LIMIT: f64 = 1e30;

/// Errors of the self-test's samples.
#[derive(Debug, thiserror::Error)]
pub(super) enum ControlError {
    #[error(transparent)]
    Length(#[from] LengthError),
    #[error(transparent)]
    Velocity(#[from] VelocityError),
    #[error(transparent)]
    Shaper(#[from] ShaperError),
}

/// A sample of the controller.
#[derive(Clone, Debug)]
struct Sample {
    /// Desired positions, then their derivatives, \[5n\].
    desired: Vec<f64>,
    /// Measured positions.
    q: Vec<f64>,
    phi: Vec<f64>,
    /// Torques of the controller.
    tau: Vec<f64>,
}

impl Sample {
    /// Returns all arrays, in the order of the self-tests.
    pub(super) fn all(&self) -> [&[f64]; 4] {
        [&self.desired, &self.q, &self.phi, &self.tau]
    }
}

/// A controller as code.
pub(super) struct Control<'a> {
    code: &'a ControlCode,
    taps: Vec<Tap>,
    samples: Vec<Sample>,
    /// Whether the feedforward has a memory.
    has_memory: bool,
    /// Motions of the self-test of the feedforward; empty if the controller has none.
    pub(super) motions: Vec<DesiredMotion>,
}

impl<'a> Control<'a> {
    /// Runs the controller of the library on a motion by chance.
    ///
    /// # Errors
    ///
    /// [`ControlError`] if the controller does not fit the robot.
    pub(super) fn new(
        source: &Source<'_>,
        code: &'a ControlCode,
        motions: Vec<DesiredMotion>,
    ) -> Result<Self, ControlError> {
        let mut control = Self {
            code,
            taps: code.taps_or_none(),
            samples: Vec::new(),
            has_memory: code.controller.kind == ControllerKind::StateFeedback
                && source
                    .elements_of_feedforward(code.controller.friction_compensation_speed_rad_per_s)
                    > 0,
            motions,
        };
        // The motion must be so small that most torques are below their limits.
        for halvings in 0..10 {
            control.samples = control.run(source, 0.5_f64.powi(halvings))?;
            let near = control.samples.len() - FAR;
            let all = (control.samples[..near].iter()).flat_map(|sample| {
                (sample.tau.iter().zip(&code.torque_limits)).map(|(tau, limit)| tau.abs() < *limit)
            });
            let (inside, count) = (all.clone().filter(|inside| *inside).count(), all.count());
            if 2 * inside >= count {
                break;
            }
        }
        Ok(control)
    }

    /// Returns a template with the constants of the controller.
    pub(super) fn filled(&self, language: &Language, template: &str) -> String {
        let controller = self.controller();
        let [of_state, of_pd] = language.commands;
        let command = match controller.kind {
            ControllerKind::StateFeedback => of_state,
            ControllerKind::Pd => of_pd,
        };
        let rows: String = controller
            .gain
            .iter()
            .map(|row| language.row(row))
            .collect();
        let (delays, weights): (Vec<String>, Vec<f64>) = (self.taps.iter())
            .map(|tap| (tap.delay.to_string(), tap.weight))
            .unzip();
        let pairs: Vec<String> = (delays.iter().zip(&weights))
            .map(|(delay, weight)| format!("({delay}, {})", language.constant(*weight)))
            .collect();
        let [positions, rates] = controller.velocity_window.map(|p| p + 1);
        // The factor of the sum of differences in a velocity, 1/s.
        let scale = 1.0 / (self.code.period_s * (positions * rates) as f64);
        let limits: Vec<f64> = (self.code.torque_limits.iter())
            .map(|limit| limit.min(NO_LIMIT))
            .collect();
        let whose = match controller.kind {
            ControllerKind::Pd => "the motors",
            ControllerKind::StateFeedback => "the links",
        };
        let mut text = template.replace("%COMMAND%", command);
        for (name, code) in language.memory_of_control {
            text = text.replace(name, if self.has_memory { code } else { "" });
        }
        text.replace("%GAIN%", &rows)
            .replace("%KP%", &language.constants(&controller.kp_nm_per_rad))
            .replace("%KD%", &language.constants(&controller.kd_nms_per_rad))
            .replace("%PERIOD%", &format!("{:?}", self.code.period_s))
            .replace("%WHOSE%", whose)
            .replace("%MEASURED%", &(positions + rates).to_string())
            .replace("%SHAPED%", &self.shaped().to_string())
            .replace("%TAPS%", &delays.len().to_string())
            .replace("%DELAYS%", &delays.join(", "))
            .replace("%WEIGHTS%", &language.constants(&weights))
            .replace("%PAIRS%", &pairs.join(", "))
            .replace("%LIMITS%", &language.constants(&limits))
            .replace("%POSITIONS%", &positions.to_string())
            .replace("%RATES%", &rates.to_string())
            .replace("%SCALE%", &language.constant(scale))
    }

    /// Returns the lines of the caller for a comment. They take their place last, since they may look like other places.
    pub(super) fn header(&self, language: &Language) -> String {
        language.comments(&self.code.header)
    }

    /// Returns the self-tests of the controller and of its feedforward; the latter is empty without one.
    pub(super) fn tests(&self, language: &Language) -> [String; 2] {
        let [test, of_feedforward] = language.tests;
        let samples = self.samples.iter().map(Sample::all);
        let test = test
            .replace("%COUNT%", &self.samples.len().to_string())
            .replace("%FAR%", &FAR.to_string())
            .replace("%SAMPLES%", &language.elements(samples));
        if self.motions.is_empty() {
            return [test, String::new()];
        }
        let motions = self.motions.iter().map(DesiredMotion::all);
        let mut of_feedforward = of_feedforward.to_owned();
        for (name, code) in language.memory_of_control {
            of_feedforward = of_feedforward.replace(name, if self.has_memory { code } else { "" });
        }
        let of_feedforward = of_feedforward
            .replace("%COUNT%", &self.motions.len().to_string())
            .replace("%MOTIONS%", &language.elements(motions));
        [test, of_feedforward]
    }

    fn controller(&self) -> &Controller {
        &self.code.controller
    }

    /// Returns the number of samples that the shaper remembers.
    fn shaped(&self) -> usize {
        memory_len(&self.taps, 1)
    }

    /// Returns samples on a motion of waves, beside which the measured positions are.
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
        // Without feedforward the deviation alone makes the torque, which must exceed the rounding of gains times positions.
        let of_motors = match self.controller().kind {
            ControllerKind::Pd => 0.05,
            ControllerKind::StateFeedback => 1e-4,
        };
        let [of_link, of_motor] = [1e-3, of_motors].map(|part| waves(part * size));
        let mut velocities = vec![self.code.velocity()?; 2 * n];
        let mut rest = vec![0.0; 5 * n];
        for (rest, wave) in rest.iter_mut().zip(&wanted) {
            *rest = derivatives(wave, 0.0)[0];
        }
        let memory = vec![0.0; memory_len(&self.taps, 5 * n)];
        let mut shaper = Shaper::new(&self.taps, &rest, memory)?;
        let mut shaped = rest;
        let mut elements = source.model.elements();
        let count = SAMPLES + FAR + self.shaped().min(MAX_DELAYED);
        let mut samples = Vec::new();
        for k in 0..count {
            let t = k as f64 * self.code.period_s;
            let far = match k {
                _ if k + FAR < count => 1.0,
                _ if k % 2 == 0 => 1e6,
                _ => -1e6,
            };
            let desired: Vec<f64> = (0..5)
                .flat_map(|order| wanted.iter().map(move |wave| derivatives(wave, t)[order]))
                .collect();
            shaper.process(&desired, &mut shaped)?;
            let nominal = self.nominal(source, &shaped, elements.values())?;
            elements.advance(&shaped[..n], &nominal[1]);
            let beside = |wave: &[f64; 3]| far * derivatives(wave, t)[0];
            let q: Vec<f64> = (shaped.iter().zip(&of_link))
                .map(|(q_d, wave)| q_d + beside(wave))
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
            samples.push(Sample {
                desired,
                q,
                phi,
                tau,
            });
        }
        Ok(samples)
    }

    /// Returns torques, positions and velocities of the motors by the desired motion. Of PD it is the
    /// motion of the motors themselves.
    fn nominal(
        &self,
        source: &Source<'_>,
        desired: &[f64],
        elements: &[f64],
    ) -> Result<[Vec<f64>; 3], LengthError> {
        let n = source.robot.joints();
        let controller = self.controller();
        match controller.kind {
            ControllerKind::Pd => {
                let of = |order: usize| desired[order * n..(order + 1) * n].to_vec();
                Ok([vec![0.0; n], of(0), of(1)])
            }
            ControllerKind::StateFeedback => {
                let q_d: Vec<[f64; 5]> = (0..n)
                    .map(|i| std::array::from_fn(|order| desired[order * n + i]))
                    .collect();
                let speed = controller.friction_compensation_speed_rad_per_s;
                let elements = if self.has_memory { elements } else { &[] };
                source.nominal(speed, &q_d, elements)
            }
        }
    }

    /// Returns the limited torques.
    fn torques(
        &self,
        desired: &[f64],
        [tau_d, phi_d, dphi_d]: &[Vec<f64>; 3],
        [q, phi]: [&[f64]; 2],
        rates: &[f64],
    ) -> Vec<f64> {
        let n = q.len();
        let (dq, dphi) = rates.split_at(n);
        let controller = self.controller();
        let mut tau = tau_d.clone();
        match controller.kind {
            ControllerKind::StateFeedback => {
                let gain: Vec<&[f64]> = controller.gain.iter().map(Vec::as_slice).collect();
                let desired = state([&desired[..n], &desired[n..2 * n], phi_d, dphi_d]);
                state_feedback(&gain, &desired, &state([q, dq, phi, dphi]), &mut tau);
            }
            ControllerKind::Pd => pd(
                &controller.kp_nm_per_rad,
                &controller.kd_nms_per_rad,
                [phi_d, dphi_d],
                [phi, dphi],
                &mut tau,
            ),
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
