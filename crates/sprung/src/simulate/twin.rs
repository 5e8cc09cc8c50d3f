//! The whole experiment: loop, encoders, amplifier and noise.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::closed_loop::{ClosedLoop, Diverged, LoopError};
use super::sensors::{Disturbance, Encoder};
use crate::description::{Controller, Simulate};
use crate::model::{JOINT_COUNT, Model, Theta};

/// One sample of a simulated log, as its sensors see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwinSample {
    /// Time, s.
    pub time: f64,
    /// Link positions, rad.
    pub q: [f64; JOINT_COUNT],
    /// Motor positions, rad.
    pub phi: [f64; JOINT_COUNT],
    /// Logged motor torques, N·m.
    pub tau: [f64; JOINT_COUNT],
}

/// What a twin is made of.
#[derive(Clone, Copy, Debug)]
pub struct TwinSetup<'a> {
    /// The robot's equations and limits.
    pub model: &'a Model,
    /// Its true parameters, \[15\].
    pub theta: &'a Theta,
    /// The controller that moves it.
    pub controller: &'a Controller,
    /// Sensors, noise, length and seed.
    pub settings: &'a Simulate,
}

/// A robot under control, and the sensors that watch it.
#[derive(Clone, Debug)]
pub struct Twin {
    plant: ClosedLoop,
    rng: ChaCha8Rng,
    link: [Encoder; JOINT_COUNT],
    motor: [Encoder; JOINT_COUNT],
    noise: [f64; JOINT_COUNT],
    disturbance: [Disturbance; JOINT_COUNT],
}

impl Twin {
    /// Returns a twin at rest with all joints at zero.
    ///
    /// # Errors
    ///
    /// [`LoopError`] as for [`ClosedLoop::new`].
    pub fn new(setup: &TwinSetup<'_>) -> Result<Self, LoopError> {
        let settings = setup.settings;
        let zero = [0.0; JOINT_COUNT];
        let plant = ClosedLoop::new(
            setup.model,
            setup.theta,
            setup.controller,
            settings.period_s,
            &zero,
            &zero,
        )?;
        let mut rng = ChaCha8Rng::seed_from_u64(settings.seed);
        let counts = |list: &[u32], joint: usize| list.get(joint).copied().unwrap_or(0);
        let level = |list: &[f64], joint: usize| list.get(joint).copied().unwrap_or(0.0);
        let link = std::array::from_fn(|i| {
            Encoder::new(
                counts(&settings.link_encoder_counts_per_turn, i),
                0.0,
                &mut rng,
            )
        });
        let motor = std::array::from_fn(|i| {
            Encoder::new(
                counts(&settings.motor_encoder_counts_per_turn, i),
                0.0,
                &mut rng,
            )
        });
        let disturbance = std::array::from_fn(|i| {
            Disturbance::new(
                level(&settings.torque_disturbance_nm, i),
                settings.torque_disturbance_hz,
                settings.period_s,
                &mut rng,
            )
        });
        Ok(Self {
            plant,
            link,
            motor,
            noise: std::array::from_fn(|i| level(&settings.torque_noise_nm, i)),
            disturbance,
            rng,
        })
    }

    /// Returns the loop, whose true state sensors do not show.
    #[must_use]
    pub fn plant(&self) -> &ClosedLoop {
        &self.plant
    }

    /// Measures, commands and moves on by one period.
    ///
    /// # Errors
    ///
    /// [`Diverged`] if the loop runs away.
    pub fn sample(&mut self) -> Result<TwinSample, Diverged> {
        let state = self.plant.state();
        let time = self.plant.time();
        let q = std::array::from_fn(|i| self.link[i].read(state.q[i]));
        let phi = std::array::from_fn(|i| self.motor[i].read(state.phi[i]));
        let tau = self.plant.command(time, &q, &phi);
        let mut applied = tau;
        let mut logged = tau;
        for i in 0..JOINT_COUNT {
            applied[i] += self.disturbance[i].next(&mut self.rng);
            logged[i] += self.noise[i] * self.rng.sample::<f64, _>(StandardNormal);
        }
        self.plant.advance(&applied)?;
        Ok(TwinSample {
            time,
            q,
            phi,
            tau: logged,
        })
    }
}
