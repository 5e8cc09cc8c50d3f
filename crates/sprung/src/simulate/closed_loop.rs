//! Plant and controller, sample by sample.

use sprung_core::controller::{Feedforward, Pd, STATES, StateFeedback};
use sprung_core::regressor::JointState;
use sprung_core::velocity::{AveragedVelocity, VelocityError};

use super::integrator::Integrator;
use super::reference::Trajectory;
use crate::description::{self, Controller, ControllerKind};
use crate::model::{JOINT_COUNT, Model, ModelError, Theta};

/// Error of one integration step that is accepted, rad and rad/s. Over the
/// paper's 10 s experiment the positions stay within 2e-9 rad of those of a
/// millionth of it, velocities within 5e-8 rad/s; a tenfold tolerance misses
/// transitions and leaves 1.5e-6 rad.
const TOLERANCE: f64 = 1e-7;

/// Position beyond which a joint is taken to have run away, rad.
const RUNAWAY: f64 = 100.0;

/// What keeps a loop from being simulated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LoopError {
    /// The parameters are not those of a robot.
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
    /// When, s.
    pub time: f64,
}

#[derive(Clone, Debug)]
enum Law {
    Pd(Pd),
    StateFeedback(StateFeedback, Box<Theta>),
}

/// Plant, controller and velocity estimator.
#[derive(Clone, Debug)]
pub struct ClosedLoop {
    model: Model,
    theta: Theta,
    law: Law,
    reference: Trajectory,
    velocity: [AveragedVelocity; 2 * JOINT_COUNT],
    state: [f64; 4 * JOINT_COUNT],
    integrator: Integrator,
    period: f64,
    samples: u64,
}

impl ClosedLoop {
    /// Returns a loop at rest.
    ///
    /// - `theta`: parameters of the plant, \[15\].
    /// - `period`: T, s.
    /// - `q`, `phi`: positions at the first sample, \[2\], rad.
    ///
    /// # Errors
    ///
    /// [`LoopError`] if the inertias are not those of a robot, or a nominal
    /// value that the feedforward needs is missing.
    pub fn new(
        model: &Model,
        theta: &Theta,
        controller: &Controller,
        period: f64,
        q: &[f64; JOINT_COUNT],
        phi: &[f64; JOINT_COUNT],
    ) -> Result<Self, LoopError> {
        model.check_inertias(theta)?;
        let law = match controller.kind {
            ControllerKind::Pd => Law::Pd(Pd {
                kp: array(&controller.kp_nm_per_rad),
                kd: array(&controller.kd_nms_per_rad),
            }),
            ControllerKind::StateFeedback => {
                let of_feedforward = match controller.feedforward {
                    description::Feedforward::Nominal => model.nominal()?,
                    description::Feedforward::Identified => *theta,
                };
                model.check_stiffness(&of_feedforward)?;
                let mut gain = [[0.0; STATES]; JOINT_COUNT];
                for (row, given) in gain.iter_mut().zip(&controller.gain) {
                    *row = array(given);
                }
                Law::StateFeedback(StateFeedback { gain }, Box::new(of_feedforward))
            }
        };
        let [p1, p2] = controller.velocity_window;
        let velocity = AveragedVelocity::new(p1, p2, period).map_err(LoopError::Velocity)?;
        let mut state = [0.0; 4 * JOINT_COUNT];
        state[..JOINT_COUNT].copy_from_slice(q);
        state[JOINT_COUNT..2 * JOINT_COUNT].copy_from_slice(phi);
        Ok(Self {
            reference: Trajectory::new(&controller.reference, model.joints()),
            model: model.clone(),
            theta: *theta,
            law,
            velocity: [velocity; 2 * JOINT_COUNT],
            state,
            integrator: Integrator::new(TOLERANCE),
            period,
            samples: 0,
        })
    }

    /// Replaces the tolerance of the integration, rad and rad/s.
    #[must_use]
    pub fn with_tolerance(mut self, tolerance: f64) -> Self {
        self.integrator = Integrator::new(tolerance);
        self
    }

    /// Returns the period of controller and log, s.
    #[must_use]
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Returns the true positions and velocities now.
    #[must_use]
    pub fn state(&self) -> JointState {
        unpack(&self.state)
    }

    /// Returns the time of the next sample, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        // k / rate prints shorter than k T where the rate is a whole number.
        let rate = (1.0 / self.period).round();
        if (rate * self.period - 1.0).abs() < 1e-12 {
            self.samples as f64 / rate
        } else {
            self.samples as f64 * self.period
        }
    }

    /// Returns the torque that the controller commands for measured positions,
    /// as far as the amplifiers let it through.
    ///
    /// - `time`: of the sample, s; the reference runs on it.
    ///
    /// Call it once per sample: the velocity estimators move on.
    ///
    /// # Source
    ///
    /// Eq. (24), or (32) and (33); velocities by eqs. (25) and (26).
    pub fn command(
        &mut self,
        time: f64,
        q: &[f64; JOINT_COUNT],
        phi: &[f64; JOINT_COUNT],
    ) -> [f64; JOINT_COUNT] {
        let desired = self.reference.at(time);
        let mut measured = JointState {
            q: *q,
            phi: *phi,
            ..JointState::default()
        };
        for joint in 0..JOINT_COUNT {
            measured.dq[joint] = self.velocity[joint].process(q[joint]);
            measured.dphi[joint] = self.velocity[JOINT_COUNT + joint].process(phi[joint]);
        }
        let mut tau = match &self.law {
            Law::Pd(pd) => pd.torque(
                &desired.map(|d| d[0]),
                &desired.map(|d| d[1]),
                &measured.phi,
                &measured.dphi,
            ),
            Law::StateFeedback(feedback, theta) => {
                feedback.torque(&Feedforward::new(&desired, theta), &measured)
            }
        };
        for (tau, limit) in tau.iter_mut().zip(self.model.torque_limits()) {
            *tau = tau.clamp(-limit, *limit);
        }
        tau
    }

    /// Holds a torque on the motors for one period.
    ///
    /// # Errors
    ///
    /// [`Diverged`] if the motion cannot be followed or leaves all bounds.
    pub fn advance(&mut self, tau: &[f64; JOINT_COUNT]) -> Result<(), Diverged> {
        let (arm, theta) = (self.model.arm(), &self.theta);
        let diverged = Diverged { time: self.time() };
        self.integrator
            .advance(&mut self.state, self.period, |x| {
                let state = unpack(x);
                let acceleration = arm.acceleration(theta, &state, tau);
                pack(
                    &state.dq,
                    &state.dphi,
                    &acceleration.ddq,
                    &acceleration.ddphi,
                )
            })
            .map_err(|_| diverged)?;
        self.samples += 1;
        if self.state[..2 * JOINT_COUNT]
            .iter()
            .all(|x| x.abs() < RUNAWAY)
        {
            Ok(())
        } else {
            Err(diverged)
        }
    }
}

fn unpack(x: &[f64; 4 * JOINT_COUNT]) -> JointState {
    JointState {
        q: [x[0], x[1]],
        phi: [x[2], x[3]],
        dq: [x[4], x[5]],
        dphi: [x[6], x[7]],
    }
}

fn pack(
    dq: &[f64; JOINT_COUNT],
    dphi: &[f64; JOINT_COUNT],
    ddq: &[f64; JOINT_COUNT],
    ddphi: &[f64; JOINT_COUNT],
) -> [f64; 4 * JOINT_COUNT] {
    [
        dq[0], dq[1], dphi[0], dphi[1], ddq[0], ddq[1], ddphi[0], ddphi[1],
    ]
}

/// Copies a list whose length the description has checked.
fn array<const N: usize>(list: &[f64]) -> [f64; N] {
    let mut all = [0.0; N];
    for (slot, value) in all.iter_mut().zip(list) {
        *slot = *value;
    }
    all
}
