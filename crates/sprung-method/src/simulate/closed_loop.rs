//! Simulates plant and controller, sample by sample.

use sprung_core::controller::{
    Compensation, Feedforward, FeedforwardScratch, TorqueSeries, pd, state_feedback,
};
use sprung_core::drives::State;
use sprung_core::links::Step;
use sprung_core::robot::{Torques, Values};
use sprung_core::scalar::Scalar;
use sprung_core::spatial::BODY;
use sprung_core::velocity::{AveragedVelocity, VelocityError};

use super::integrator::Integrator;
use super::plant::{JointState, Plant};
use super::reference::Trajectory;
use crate::description::{self, Controller, ControllerKind};
use crate::model::{Elements, Model, ModelError, Theta};

/// Accepted error of an integration step, rad and rad/s. Over the paper's 10 s experiment,
/// positions differ by at most 2e-9 rad and velocities by at most 5e-8 rad/s from a simulation with
/// a millionth of this tolerance. Ten times this tolerance misses friction transitions and leaves
/// errors of 1.5e-6 rad.
const TOLERANCE: f64 = 1e-7;

/// Position beyond which a joint counts as run away, rad.
const RUNAWAY_POSITION: f64 = 100.0;

/// Errors in the setup of a closed loop.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LoopError {
    /// No robot can have the parameters.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The velocity estimator cannot be built.
    #[error("{0}")]
    Velocity(VelocityError),
}

/// The simulated loop ran away.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the simulated loop runs away at {time:.2} s")]
pub struct Diverged {
    /// Time of the divergence, s.
    pub time: f64,
}

/// A feedforward with its parameters and memory.
#[derive(Clone, Debug)]
struct FeedforwardModel {
    theta: Theta,
    bodies: Vec<[f64; BODY]>,
    /// Speed below which the compensation of friction fades, rad/s (m/s).
    compensation_speed: Option<f64>,
    // Of presliding friction, along the desired motion.
    elements: Elements,
    series: [Vec<TorqueSeries>; 4],
    steps: Vec<Step<TorqueSeries>>,
    phi: Vec<f64>,
    dphi: Vec<f64>,
    tau: Vec<f64>,
}

impl FeedforwardModel {
    fn new(model: &Model, theta: Theta, compensation_speed: Option<f64>) -> Self {
        let n = model.joint_count();
        Self {
            elements: model.elements(),
            bodies: model.bodies(&theta),
            theta,
            compensation_speed,
            series: std::array::from_fn(|_| vec![TorqueSeries::ZERO; n]),
            steps: vec![Step::default(); n],
            phi: vec![0.0; n],
            dphi: vec![0.0; n],
            tau: vec![0.0; n],
        }
    }

    /// Computes rotor motion and torques for a desired link motion.
    fn fill(&mut self, model: &Model, desired: &[[f64; 5]]) {
        let [q, dq, ddq, torque] = &mut self.series;
        let mut scratch = FeedforwardScratch {
            series: [q, dq, ddq, torque],
            steps: &mut self.steps,
        };
        let values = Values {
            theta: &self.theta,
            bodies: &self.bodies,
        };
        let mut out = Feedforward {
            tau: &mut self.tau,
            phi: &mut self.phi,
            dphi: &mut self.dphi,
        };
        let compensation = self.compensation_speed.map(|speed| Compensation {
            speed,
            elements: self.elements.values(),
        });
        if out
            .fill(&model.robot(), &values, desired, compensation, &mut scratch)
            .is_err()
        {
            self.tau.fill(f64::NAN);
        }
        let q_d: Vec<f64> = desired.iter().map(|desired| desired[0]).collect();
        self.elements.advance(&q_d, &self.phi);
    }
}

#[derive(Clone, Debug)]
enum Law {
    Pd {
        kp: Vec<f64>,
        kd: Vec<f64>,
    },
    StateFeedback {
        gain: Vec<Vec<f64>>,
        nominal: Box<FeedforwardModel>,
    },
}

/// Plant, controller and velocity estimator.
#[derive(Clone, Debug)]
pub struct ClosedLoop {
    model: Model,
    law: Law,
    reference: Trajectory,
    desired: Vec<[f64; 5]>,
    // Desired positions and desired velocities.
    wanted: [Vec<f64>; 2],
    velocities: Vec<f64>,
    // Velocity estimators of the links, then of the motors.
    velocity: Vec<AveragedVelocity>,
    plant: Plant,
    integrator: Integrator,
    period: f64,
    samples: u64,
}

impl ClosedLoop {
    /// Returns a closed loop at rest.
    ///
    /// - `theta`: parameters of the plant, \[p\].
    /// - `period`: T, s.
    /// - `start`: positions of links and motors at the first sample, \[n\], rad (m). Without them
    ///   the links start where the reference begins at rest, or else at its centre, and the motors where
    ///   the springs hold the links.
    ///
    /// # Errors
    ///
    /// [`LoopError`] if no robot can have the inertias, or if a nominal value for the feedforward
    /// is missing.
    pub fn new(
        model: &Model,
        theta: &Theta,
        controller: &Controller,
        period: f64,
        start: Option<(&[f64], &[f64])>,
    ) -> Result<Self, LoopError> {
        model.check_inertias(theta)?;
        let n = model.joint_count();
        let law = match controller.kind {
            ControllerKind::Pd => Law::Pd {
                kp: controller.kp_nm_per_rad.clone(),
                kd: controller.kd_nms_per_rad.clone(),
            },
            ControllerKind::StateFeedback => {
                let of_feedforward = match controller.feedforward {
                    description::Feedforward::Nominal => model.nominal()?,
                    description::Feedforward::Identified => theta.clone(),
                };
                model.check_stiffness(&of_feedforward)?;
                Law::StateFeedback {
                    gain: controller.gain.clone(),
                    nominal: Box::new(FeedforwardModel::new(
                        model,
                        of_feedforward,
                        controller.friction_compensation_speed_rad_per_s,
                    )),
                }
            }
        };
        let [p1, p2] = controller.velocity_window;
        let velocity = AveragedVelocity::new(p1, p2, period).map_err(LoopError::Velocity)?;
        let reference =
            Trajectory::new(&controller.reference, model).shaped(controller.shaper.clone());
        let state = match start {
            Some((q, phi)) => JointState::at_rest(q, phi),
            None => at_rest_in_springs(model, theta, &reference.start())?,
        };
        let plant = Plant::new(model, theta, &state);
        Ok(Self {
            reference,
            desired: vec![[0.0; 5]; n],
            wanted: [vec![0.0; n], vec![0.0; n]],
            velocities: vec![0.0; 2 * n],
            model: model.clone(),
            law,
            velocity: vec![velocity; 2 * n],
            integrator: Integrator::new(TOLERANCE, plant.states()),
            plant,
            period,
            samples: 0,
        })
    }

    /// Replaces the values of the model in the controller, by default those that it declares.
    ///
    /// # Errors
    ///
    /// [`LoopError`] if a spring of the model has no stiffness.
    pub fn with_feedforward(mut self, theta: &Theta) -> Result<Self, LoopError> {
        if let Law::StateFeedback { nominal, .. } = &mut self.law {
            self.model.check_stiffness(theta)?;
            let speed = nominal.compensation_speed;
            **nominal = FeedforwardModel::new(&self.model, theta.clone(), speed);
        }
        Ok(self)
    }

    /// Replaces the reference; the robot stays where it is.
    #[must_use]
    pub fn with_reference(mut self, reference: Trajectory) -> Self {
        self.reference = reference;
        self
    }

    /// Replaces the tolerance of the integration, rad and rad/s.
    #[must_use]
    pub fn with_tolerance(mut self, tolerance: f64) -> Self {
        self.integrator = Integrator::new(tolerance, self.plant.states());
        self
    }

    /// Returns the period of the controller and the log, s.
    #[must_use]
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Returns whether a joint has a spring.
    #[must_use]
    pub fn is_flexible(&self, joint: usize) -> bool {
        self.model.is_flexible(joint)
    }

    /// Returns the current true positions and velocities.
    #[must_use]
    pub fn state(&self) -> JointState {
        self.plant.state()
    }

    /// Returns the time of the next sample, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        // For a whole rate, k / rate has fewer printed digits than k T.
        let rate = (1.0 / self.period).round();
        if (rate * self.period - 1.0).abs() < 1e-12 {
            self.samples as f64 / rate
        } else {
            self.samples as f64 * self.period
        }
    }

    /// Returns the controller's torque for measured positions, limited by the amplifiers, \[n\],
    /// N·m (N).
    ///
    /// - `time`: time of the sample and of the reference, s.
    ///
    /// Call this once per sample, because it advances the velocity estimators.
    ///
    /// # Source
    ///
    /// Eq. (24), or (32) and (33); velocities by eqs. (25) and (26).
    pub fn command(&mut self, time: f64, q: &[f64], phi: &[f64]) -> Vec<f64> {
        let n = self.model.joint_count();
        self.reference.at(time, &mut self.desired);
        let estimators = self.velocity.iter_mut().zip(q.iter().chain(phi));
        for (velocity, (estimator, position)) in self.velocities.iter_mut().zip(estimators) {
            *velocity = estimator.process(*position);
        }
        let (dq, dphi) = self.velocities.split_at(n);
        for (order, wanted) in self.wanted.iter_mut().enumerate() {
            for (wanted, desired) in wanted.iter_mut().zip(&self.desired) {
                *wanted = desired[order];
            }
        }
        let [q_d, dq_d] = &self.wanted;
        let mut tau = vec![0.0; n];
        match &mut self.law {
            Law::Pd { kp, kd } => pd(kp, kd, [q_d, dq_d], [phi, dphi], &mut tau),
            Law::StateFeedback { gain, nominal } => {
                nominal.fill(&self.model, &self.desired);
                tau.copy_from_slice(&nominal.tau);
                let desired = State {
                    q: q_d,
                    dq: dq_d,
                    phi: &nominal.phi,
                    dphi: &nominal.dphi,
                    excess: &[],
                    elements: &[],
                };
                let measured = State {
                    q,
                    dq,
                    phi,
                    dphi,
                    excess: &[],
                    elements: &[],
                };
                let gain: Vec<&[f64]> = gain.iter().map(Vec::as_slice).collect();
                state_feedback(&gain, &desired, &measured, &mut tau);
            }
        }
        for (tau, limit) in tau.iter_mut().zip(self.model.torque_limits()) {
            *tau = tau.clamp(-limit, limit);
        }
        tau
    }

    /// Sets the covariates of the joints minus their references, \[n × [`Covariate::COUNT`]\]. They are
    /// zero before.
    ///
    /// [`Covariate::COUNT`]: sprung_core::covariate::Covariate::COUNT
    pub fn set_excess(&mut self, excess: &[f64]) {
        self.plant.excess.clear();
        self.plant.excess.extend_from_slice(excess);
    }

    /// Advances by one period with constant motor torques.
    ///
    /// # Errors
    ///
    /// [`Diverged`] if the integration fails or a joint runs away.
    pub fn advance(&mut self, tau: &[f64]) -> Result<(), Diverged> {
        self.advance_disturbed(&Torques {
            motor: tau,
            link: None,
        })
    }

    /// Returns the accelerations of the links in the present state with these torques, \[n\], rad/s² (m/s²).
    pub(super) fn link_accelerations(&mut self, torques: &Torques<'_>) -> Vec<f64> {
        self.plant.link_accelerations(torques)
    }

    /// Advances by one period with constant torques on motors and links.
    ///
    /// # Errors
    ///
    /// [`Diverged`] as for [`ClosedLoop::advance`].
    pub fn advance_disturbed(&mut self, torques: &Torques<'_>) -> Result<(), Diverged> {
        let diverged = Diverged { time: self.time() };
        self.plant
            .advance(&mut self.integrator, torques, self.period)
            .map_err(|_| diverged)?;
        self.samples += 1;
        if self
            .plant
            .positions()
            .iter()
            .all(|x| x.abs() < RUNAWAY_POSITION)
        {
            Ok(())
        } else {
            Err(diverged)
        }
    }
}

/// Returns a robot at rest in equilibrium with its springs.
pub(crate) fn at_rest_in_springs(
    model: &Model,
    theta: &Theta,
    q: &[f64],
) -> Result<JointState, ModelError> {
    model.check_stiffness(theta)?;
    let mut still = FeedforwardModel::new(model, theta.clone(), None);
    let desired: Vec<[f64; 5]> = q.iter().map(|&q| [q, 0.0, 0.0, 0.0, 0.0]).collect();
    still.fill(model, &desired);
    Ok(JointState::at_rest(q, &still.phi))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::demo;
    use crate::description::{Feedforward, no_files, read};

    const PERIOD: f64 = 1e-3;

    /// Largest error of each link, rad, in the last quarter of a simulation of the demo's state feedback
    /// with the true parameters.
    ///
    /// - `laws`: lines of the second joint.
    fn errors(
        (speed, laws): (Option<f64>, &str),
        samples: u32,
        change: impl Fn(&mut BTreeMap<String, f64>),
    ) -> [f64; 2] {
        let name = "name = \"joint2\"\n";
        assert!(demo::EXPERIMENT.contains(name));
        let text = demo::EXPERIMENT.replace(name, &format!("{name}{laws}\n"));
        let experiment = read("demo", &text, &[], &mut no_files).unwrap();
        let model = Model::new(&experiment).unwrap();
        let mut values: BTreeMap<String, f64> = toml::from_str(demo::TRUTH).unwrap();
        change(&mut values);
        let theta = model.theta(&values).unwrap();
        let mut controller = experiment.validate[1].controller.clone().unwrap();
        controller.feedforward = Feedforward::Identified;
        controller.friction_compensation_speed_rad_per_s = speed;
        let reference = Trajectory::new(&controller.reference, &model);
        let mut closed_loop = ClosedLoop::new(&model, &theta, &controller, PERIOD, None).unwrap();
        let mut desired = [[0.0; 5]; 2];
        let mut worst = [0.0_f64; 2];
        for _ in 0..samples {
            let (time, state) = (closed_loop.time(), closed_loop.state());
            let tau = closed_loop.command(time, &state.q, &state.phi);
            reference.at(time, &mut desired);
            if time > 0.75 * PERIOD * f64::from(samples) {
                for (worst, (q, desired)) in worst.iter_mut().zip(state.q.iter().zip(desired)) {
                    *worst = worst.max((q - desired[0]).abs());
                }
            }
            closed_loop.advance(&tau).unwrap();
        }
        worst
    }

    #[test]
    fn compensation_of_friction_follows_the_desired_motion_more_closely() {
        let [without, with] = [None, Some(0.02)].map(|speed| errors((speed, ""), 12_000, |_| {}));
        for joint in 0..2 {
            assert!(with[joint] < 0.5 * without[joint], "{with:?} {without:?}");
        }
        let frictionless = |values: &mut BTreeMap<String, f64>| {
            for (name, value) in values {
                if name.contains("viscous") || name.contains("coulomb") {
                    *value = 0.0;
                }
            }
        };
        let [without, with] =
            [None, Some(0.02)].map(|speed| errors((speed, ""), 100, frictionless));
        assert!((0..2).all(|joint| with[joint].to_bits() == without[joint].to_bits()));
    }

    #[test]
    fn compensation_remembers_how_far_friction_has_slid() {
        let laws = "motor_friction = [\"viscous\", \"coulomb\", \"presliding\"]\npresliding_width_rad = 0.4";
        let deforms = |values: &mut BTreeMap<String, f64>| {
            let coulomb = values
                .insert("joint2.motor_coulomb".to_owned(), 0.0)
                .unwrap();
            for element in 1..=6 {
                let torque = if element == 6 { coulomb } else { 0.0 };
                values.insert(format!("joint2.motor_presliding_{element}"), torque);
            }
        };
        let [without, with] =
            [None, Some(0.02)].map(|speed| errors((speed, laws), 12_000, deforms));
        assert!(with[1] < 0.2 * without[1], "{with:?} {without:?}");
    }
}
