//! The digital twin: closed loop, encoders, amplifier and noise.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use sprung_core::chain::JointKind;
use sprung_core::covariate::Covariate;
use sprung_core::robot::Torques;

use super::closed_loop::{ClosedLoop, Diverged, LoopError};
use super::reference::Trajectory;
use super::sensors::{Disturbance, Encoder, TorqueSensors};
use crate::description::{Controller, Simulate};
use crate::model::{Model, Theta};

/// One sample of a simulated log, with the errors of the sensors.
#[derive(Clone, Debug, PartialEq)]
pub struct TwinSample {
    /// Time, s.
    pub time: f64,
    /// Link positions, rad.
    pub q: Vec<f64>,
    /// Motor positions, rad.
    pub phi: Vec<f64>,
    /// Logged motor torques, N·m.
    pub tau: Vec<f64>,
    /// Readings of the joint torque sensors, N·m.
    pub spring: Vec<f64>,
    /// Covariates of the joints, \[n × [`Covariate::COUNT`]\].
    pub covariates: Vec<f64>,
    /// True positions, velocities and accelerations of the links, rad, rad/s, rad/s² (m, m/s, m/s²), \[n\] each.
    pub motion: [Vec<f64>; 3],
}

/// Parts of a twin.
#[derive(Clone, Copy, Debug)]
pub struct TwinSetup<'a> {
    /// The robot's equations and limits.
    pub model: &'a Model,
    /// Its true parameters, \[p\].
    pub theta: &'a Theta,
    /// The controller.
    pub controller: &'a Controller,
    /// Sensors, noise, duration and seed.
    pub settings: &'a Simulate,
}

/// Covariates of the joints, which change at a constant rate.
#[derive(Clone, Debug)]
struct Drifts {
    // At the start, and the change over the experiment; \[n × covariates\] each.
    start: Vec<f64>,
    change: Vec<f64>,
    duration: f64,
    references: Vec<f64>,
}

impl Drifts {
    fn new(setup: &TwinSetup<'_>) -> Self {
        let settings = setup.settings;
        let references: Vec<f64> = setup.model.references().flatten().collect();
        let n = setup.model.joint_count();
        let places = (0..n).flat_map(|joint| Covariate::ALL.map(|covariate| (joint, covariate)));
        let ends =
            (places.zip(&references)).map(|((joint, covariate), &reference)| match covariate {
                Covariate::Temperature => {
                    let starts = &settings.temperature_start_c;
                    let start = starts.get(joint).copied().unwrap_or(reference);
                    let end = settings.temperature_end_c.get(joint);
                    [start, end.copied().unwrap_or(start)]
                }
                Covariate::Time => [0.0, settings.duration_s],
                Covariate::Operation | Covariate::Age | Covariate::Cycles | Covariate::Other => {
                    settings.drifts.of(covariate).unwrap_or([reference; 2])
                }
            });
        let ends: Vec<[f64; 2]> = ends.collect();
        Self {
            start: ends.iter().map(|[start, _]| *start).collect(),
            change: ends.iter().map(|[start, end]| end - start).collect(),
            duration: settings.duration_s,
            references,
        }
    }

    /// Returns the covariates at a time, s, \[n × covariates\].
    fn at(&self, time: f64) -> Vec<f64> {
        let share = time / self.duration;
        let all = self.start.iter().zip(&self.change);
        all.map(|(start, change)| start + share * change).collect()
    }
}

/// A controlled robot with its sensors.
#[derive(Clone, Debug)]
pub struct Twin {
    plant: ClosedLoop,
    rng: ChaCha8Rng,
    link: Vec<Encoder>,
    motor: Vec<Encoder>,
    offset: Vec<f64>,
    noise: Vec<f64>,
    drifts: Drifts,
    disturbance: Vec<Disturbance>,
    // `None` without link disturbances, so that these draw no random numbers.
    link_disturbance: Option<Vec<Disturbance>>,
    /// Torque of a contact on each link, N·m (N), and the times from and to which it lasts, s.
    contact: Vec<f64>,
    contacts: Vec<[f64; 2]>,
    torque_sensors: TorqueSensors,
    model: Model,
    theta: Theta,
}

impl Twin {
    /// Returns a twin at rest at the centre of its reference.
    ///
    /// # Errors
    ///
    /// [`LoopError`] as for [`ClosedLoop::new`].
    pub fn new(setup: &TwinSetup<'_>) -> Result<Self, LoopError> {
        let settings = setup.settings;
        let n = setup.model.joint_count();
        let plant = ClosedLoop::new(
            setup.model,
            setup.theta,
            setup.controller,
            settings.period_s,
            None,
        )?;
        let mut rng = ChaCha8Rng::seed_from_u64(settings.seed);
        let start = plant.state();
        let level = |list: &[f64], joint: usize| list.get(joint).copied().unwrap_or(0.0);
        let mut encoders = |counts: &[u32], positions: &[f64]| -> Vec<Encoder> {
            (0..n)
                .map(|i| {
                    let turn = match setup.model.kind(i) {
                        JointKind::Revolute => std::f64::consts::TAU,
                        JointKind::Prismatic => 1.0,
                    };
                    let counts = counts.get(i).copied().unwrap_or(0);
                    Encoder::new(counts, turn, positions[i], &mut rng)
                })
                .collect()
        };
        let link = encoders(&settings.link_encoder_counts_per_turn, &start.q);
        let motor = encoders(&settings.motor_encoder_counts_per_turn, &start.phi);
        let mut disturbances = |levels: &[f64]| -> Vec<Disturbance> {
            (0..n)
                .map(|i| Disturbance::new(level(levels, i), settings.period_s, &mut rng))
                .collect()
        };
        let disturbance = disturbances(&settings.torque_disturbance_nm);
        let on_links = &settings.link_torque_disturbance_nm;
        let link_disturbance =
            (on_links.iter().any(|level| *level > 0.0)).then(|| disturbances(on_links));
        let levels = |list: &[f64]| (0..n).map(|i| level(list, i)).collect();
        Ok(Self {
            plant,
            link,
            motor,
            offset: levels(&settings.motor_encoder_offset_rad),
            noise: levels(&settings.torque_noise_nm),
            drifts: Drifts::new(setup),
            disturbance,
            link_disturbance,
            contact: levels(&settings.contact_torque_nm),
            contacts: settings.contact_s.clone(),
            torque_sensors: TorqueSensors::new(setup.model, setup.theta, settings),
            model: setup.model.clone(),
            theta: setup.theta.clone(),
            rng,
        })
    }

    /// Replaces the values of the model in the controller; see [`ClosedLoop::with_feedforward`].
    ///
    /// # Errors
    ///
    /// [`LoopError`] as for [`ClosedLoop::with_feedforward`].
    pub fn with_feedforward(self, theta: &Theta) -> Result<Self, LoopError> {
        let plant = self.plant.with_feedforward(theta)?;
        Ok(Self { plant, ..self })
    }

    /// Replaces the reference; the robot stays where it is.
    #[must_use]
    pub fn with_reference(self, reference: Trajectory) -> Self {
        let plant = self.plant.with_reference(reference);
        Self { plant, ..self }
    }

    /// Returns the loop with its true state.
    #[must_use]
    pub fn plant(&self) -> &ClosedLoop {
        &self.plant
    }

    /// Measures, computes the controller's torque and advances by one period.
    ///
    /// # Errors
    ///
    /// [`Diverged`] if the loop runs away.
    pub fn sample(&mut self) -> Result<TwinSample, Diverged> {
        let state = self.plant.state();
        let time = self.plant.time();
        let read = |encoders: &[Encoder], positions: &[f64]| -> Vec<f64> {
            (encoders.iter().zip(positions))
                .map(|(encoder, position)| encoder.read(*position))
                .collect()
        };
        let mut phi = read(&self.motor, &state.phi);
        for (phi, offset) in phi.iter_mut().zip(&self.offset) {
            *phi += offset;
        }
        let mut q = read(&self.link, &state.q);
        for (i, q) in q.iter_mut().enumerate() {
            // A rigid joint has a single position, measured at the motor.
            if !self.plant.is_flexible(i) {
                *q = phi[i];
            }
        }
        let spring = self.model.spring_torques(&self.theta, &state.view());
        let spring = self.torque_sensors.read(&spring, &mut self.rng);
        let covariates = self.drifts.at(time);
        let excess: Vec<f64> = (covariates.iter().zip(&self.drifts.references))
            .map(|(value, reference)| value - reference)
            .collect();
        self.plant.set_excess(&excess);
        let tau = self.plant.command(time, &q, &phi);
        let mut applied = tau.clone();
        let mut logged = tau;
        for i in 0..applied.len() {
            applied[i] += self.disturbance[i].next(&mut self.rng);
            logged[i] += self.noise[i] * self.rng.sample::<f64, _>(StandardNormal);
        }
        let rng = &mut self.rng;
        let mut on_links: Option<Vec<f64>> = (self.link_disturbance.as_mut())
            .map(|all| all.iter_mut().map(|d| d.next(rng)).collect());
        if self
            .contacts
            .iter()
            .any(|[from, to]| (*from..*to).contains(&time))
        {
            let all = on_links.get_or_insert_with(|| vec![0.0; self.contact.len()]);
            all.iter_mut()
                .zip(&self.contact)
                .for_each(|(all, torque)| *all += torque);
        }
        let torques = Torques {
            motor: &applied,
            link: on_links.as_deref(),
        };
        let ddq = self.plant.link_accelerations(&torques);
        self.plant.advance_disturbed(&torques)?;
        Ok(TwinSample {
            time,
            q,
            phi,
            tau: logged,
            spring,
            covariates,
            motion: [state.q, state.dq, ddq],
        })
    }
}
