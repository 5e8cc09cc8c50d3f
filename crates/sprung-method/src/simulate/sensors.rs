//! Encoders, torque sensors and disturbances of the twin.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use sprung_core::parameters::JointParameter;

use crate::description::Simulate;
use crate::log::{InertialSensors, LinkMotion};
use crate::model::Model;

/// An incremental encoder. Its first reading is the position at the start, rounded to a count.
#[derive(Clone, Copy, Debug)]
pub struct Encoder {
    step: f64,
    phase: f64,
    zero: f64,
}

impl Encoder {
    /// Returns an encoder that starts at `position`, rad (m).
    ///
    /// - `counts`: counts per `turn`, rad (m); 0 for an exact sensor.
    pub fn new(counts: u32, turn: f64, position: f64, rng: &mut ChaCha8Rng) -> Self {
        let phase: f64 = rng.random();
        let step = if counts == 0 {
            0.0
        } else {
            turn / f64::from(counts)
        };
        let mut encoder = Self {
            step,
            phase,
            zero: 0.0,
        };
        if step > 0.0 {
            encoder.zero = encoder.read(position) - step * (position / step).round();
        }
        encoder
    }

    /// Returns the position that the encoder reads, rad.
    #[must_use]
    pub fn read(&self, position: f64) -> f64 {
        if self.step > 0.0 {
            self.step * (position / self.step + self.phase).floor() - self.zero
        } else {
            position
        }
    }
}

/// Gaussian noise with a first-order spectrum.
#[derive(Clone, Copy, Debug)]
pub struct Disturbance {
    deviation: f64,
    decay: f64,
    value: f64,
}

impl Disturbance {
    /// Corner frequency of the spectrum, Hz.
    pub const CORNER_HZ: f64 = 3.0;

    /// - `deviation`: standard deviation; `period`: s.
    pub fn new(deviation: f64, period: f64, rng: &mut ChaCha8Rng) -> Self {
        Self {
            deviation,
            decay: (-std::f64::consts::TAU * Self::CORNER_HZ * period).exp(),
            value: deviation * rng.sample::<f64, _>(StandardNormal),
        }
    }

    /// Returns the disturbance of the next sample, N·m.
    pub fn next(&mut self, rng: &mut ChaCha8Rng) -> f64 {
        let value = self.value;
        let innovation = (1.0 - self.decay * self.decay).sqrt() * self.deviation;
        self.value = self.decay * value + innovation * rng.sample::<f64, _>(StandardNormal);
        value
    }
}

/// Sensors on the links, with separate random numbers.
#[derive(Clone, Debug)]
pub(super) struct InertialSensorsOfTwin<'a> {
    sensors: &'a InertialSensors,
    settings: &'a Simulate,
    rng: ChaCha8Rng,
}

impl<'a> InertialSensorsOfTwin<'a> {
    pub(super) fn new(sensors: &'a InertialSensors, settings: &'a Simulate) -> Self {
        Self {
            rng: ChaCha8Rng::seed_from_u64(settings.seed ^ sensors.kind.seed()),
            sensors,
            settings,
        }
    }

    /// Returns the readings of the axes of each joint's sensor, in their unit, \[n\].
    ///
    /// - `motion`: positions, velocities and accelerations of the links, \[n\], rad, rad/s, rad/s² (m, m/s, m/s²).
    pub(super) fn read(&mut self, motion: [&[f64]; 3]) -> Vec<[f64; 3]> {
        let motions: Vec<LinkMotion> = self.sensors.motions(motion);
        let mut all = vec![[0.0; 3]; motions.len()];
        for sensor in &self.sensors.all {
            let joint = sensor.joint;
            let exact = self.sensors.reading(sensor, &motions[joint]);
            let errors = self.sensors.kind.errors(self.settings, joint);
            all[joint] = exact.map(|exact| {
                let noise = errors.noise * self.rng.sample::<f64, _>(StandardNormal);
                (exact + errors.bias + noise).clamp(-errors.limit, errors.limit)
            });
        }
        all
    }
}

/// Torque sensors in the joints.
#[derive(Clone, Debug)]
pub(super) struct TorqueSensors {
    /// Readings per torque of each spring, row by row; `None` for exact gains without cross-talk.
    matrix: Option<Vec<Vec<f64>>>,
    /// Readings without torque, N·m, \[n\].
    offsets: Vec<f64>,
    /// Standard deviations of the noise, N·m; no noise without entry.
    noise: Vec<f64>,
    /// Largest readings, N·m; no limit without entry.
    limits: Vec<f64>,
}

impl TorqueSensors {
    pub(super) fn new(model: &Model, theta: &[f64], settings: &Simulate) -> Self {
        let offset = |joint| {
            let index = model.index(JointParameter::TorqueOffset, joint);
            index.map_or(0.0, |index| theta[index])
        };
        let matrix = &settings.joint_torque_matrix;
        Self {
            matrix: (!matrix.is_empty()).then(|| matrix.clone()),
            offsets: (0..model.joint_count()).map(offset).collect(),
            noise: settings.joint_torque_noise_nm.clone(),
            limits: settings.joint_torque_limit_nm.clone(),
        }
    }

    /// Returns the readings for torques of the springs, \[n\], N·m.
    pub(super) fn read(&self, torques: &[f64], rng: &mut ChaCha8Rng) -> Vec<f64> {
        let mixed = |joint: usize| match &self.matrix {
            Some(matrix) => matrix[joint].iter().zip(torques).map(|(m, t)| m * t).sum(),
            None => torques[joint],
        };
        (self.offsets.iter().enumerate())
            .map(|(joint, offset)| {
                let mut reading: f64 = mixed(joint) + offset;
                if let Some(noise) = self.noise.get(joint) {
                    reading += noise * rng.sample::<f64, _>(StandardNormal);
                }
                let limit = self.limits.get(joint).copied().unwrap_or(f64::INFINITY);
                reading.clamp(-limit, limit)
            })
            .collect()
    }
}
