//! The plant: integrates the robot's equations over time.

use sprung_core::drives::State;
use sprung_core::robot::{Torques, Values};
use sprung_core::spatial::BODY;

use super::integrator::{Integrator, StepsExhausted};
use crate::model::{Elements, Model, Scratch};

/// Positions and velocities of all joints, each \[n\].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointState {
    /// Link positions, rad (m).
    pub q: Vec<f64>,
    /// Link velocities, rad/s (m/s).
    pub dq: Vec<f64>,
    /// Motor positions after gear and coupling, rad (m).
    pub phi: Vec<f64>,
    /// Motor velocities after gear and coupling, rad/s (m/s).
    pub dphi: Vec<f64>,
}

impl JointState {
    /// Returns the state of a robot at rest.
    #[must_use]
    pub fn at_rest(q: &[f64], phi: &[f64]) -> Self {
        Self {
            q: q.to_vec(),
            dq: vec![0.0; q.len()],
            phi: phi.to_vec(),
            dphi: vec![0.0; phi.len()],
        }
    }

    /// Returns a view of the state.
    #[must_use]
    pub fn view(&self) -> State<'_> {
        State {
            q: &self.q,
            dq: &self.dq,
            phi: &self.phi,
            dphi: &self.dphi,
            excess: &[],
            elements: &[],
        }
    }
}

/// A robot with its parameters and its state.
#[derive(Clone, Debug)]
pub(super) struct Plant {
    model: Model,
    theta: Vec<f64>,
    bodies: Vec<[f64; BODY]>,
    flexible: Vec<usize>,
    // Link coordinates, rotor coordinates of flexible joints; then their velocities.
    x: Vec<f64>,
    scratch: Scratch,
    // Buffer for q, dq, phi and dphi.
    joints: Vec<f64>,
    // Torque on each coordinate.
    torque: Vec<f64>,
    /// Covariates of the joints minus their references, \[n × `Covariate::COUNT`\]; empty if no
    /// friction depends on any.
    pub(super) excess: Vec<f64>,
    // Elements of presliding friction and hysteresis at the beginning of a step, and within it.
    elements: Elements,
    within: Vec<f64>,
}

impl Plant {
    pub(super) fn new(model: &Model, theta: &[f64], start: &JointState) -> Self {
        let n = model.joint_count();
        let flexible: Vec<usize> = (0..n).filter(|&i| model.is_flexible(i)).collect();
        let rotors = |all: &[f64]| flexible.iter().map(|&i| all[i]).collect::<Vec<f64>>();
        let x = [
            start.q.clone(),
            rotors(&start.phi),
            start.dq.clone(),
            rotors(&start.dphi),
        ];
        Self {
            bodies: model.bodies(theta),
            theta: theta.to_vec(),
            x: x.concat(),
            flexible,
            scratch: Scratch::new(n),
            joints: vec![0.0; 4 * n],
            torque: vec![0.0; model.coordinates()],
            excess: Vec::new(),
            elements: begun(model, start),
            within: Vec::new(),
            model: model.clone(),
        }
    }

    pub(super) fn states(&self) -> usize {
        self.x.len()
    }

    pub(super) fn positions(&self) -> &[f64] {
        &self.x[..self.x.len() / 2]
    }

    pub(super) fn state(&self) -> JointState {
        let n = self.model.joint_count();
        let mut all = vec![0.0; 4 * n];
        unpack(&self.x, &self.flexible, n, &mut all);
        let part = |k: usize| all[k * n..(k + 1) * n].to_vec();
        JointState {
            q: part(0),
            dq: part(1),
            phi: part(2),
            dphi: part(3),
        }
    }

    /// Returns the accelerations of the links in the present state, \[n\], rad/s² (m/s²).
    pub(super) fn link_accelerations(&mut self, torques: &Torques<'_>) -> Vec<f64> {
        let mut rate = vec![0.0; self.x.len()];
        let x = std::mem::take(&mut self.x);
        self.derivative(torques)(&x, &mut rate);
        self.x = x;
        let first = rate.len() / 2;
        rate[first..first + torques.motor.len()].to_vec()
    }

    /// Integrates over `duration` with constant torques.
    pub(super) fn advance(
        &mut self,
        integrator: &mut Integrator,
        torques: &Torques<'_>,
        duration: f64,
    ) -> Result<(), StepsExhausted> {
        let mut x = std::mem::take(&mut self.x);
        let done = integrator.advance(&mut x, duration, self.derivative(torques));
        self.x = x;
        if !self.elements.is_empty() {
            let JointState { q, phi, .. } = self.state();
            self.elements.advance(&q, &phi);
        }
        done
    }

    /// Returns the function that writes the derivative of a state with constant torques.
    fn derivative(&mut self, torques: &Torques<'_>) -> impl FnMut(&[f64], &mut [f64]) {
        let Self {
            model,
            theta,
            bodies,
            flexible,
            scratch,
            joints,
            torque,
            excess,
            elements,
            within,
            ..
        } = self;
        let (robot, n) = (model.robot(), torques.motor.len());
        // The buffers have the robot's sizes, so no error is expected here and below.
        let fits = robot.coordinate_torques(torques, torque).is_ok();
        let values = Values { theta, bodies };
        move |x, rate| {
            unpack(x, flexible, n, joints);
            let (link, motor) = joints.split_at(2 * n);
            elements.write_at(&link[..n], &motor[..n], within);
            let state = State {
                q: &link[..n],
                dq: &link[n..],
                phi: &motor[..n],
                dphi: &motor[n..],
                excess,
                elements: within,
            };
            let (positions, accelerations) = rate.split_at_mut(x.len() / 2);
            positions.copy_from_slice(&x[positions.len()..]);
            let mut workspace = scratch.workspace();
            let solved = robot.acceleration(&values, &state, torque, &mut workspace, accelerations);
            if !fits || solved.is_err() {
                rate.fill(f64::NAN);
            }
        }
    }
}

/// Returns the elements of a robot that begins to move.
fn begun(model: &Model, start: &JointState) -> Elements {
    let mut elements = model.elements();
    elements.advance(&start.q, &start.phi);
    elements
}

/// Writes q, dq, phi and dphi to `all`.
fn unpack(x: &[f64], flexible: &[usize], n: usize, all: &mut [f64]) {
    let (positions, velocities) = x.split_at(x.len() / 2);
    for (side, values) in [positions, velocities].into_iter().enumerate() {
        let (links, rotors) = values.split_at(n);
        all[side * n..(side + 1) * n].copy_from_slice(links);
        let motors = &mut all[(2 + side) * n..(3 + side) * n];
        motors.copy_from_slice(links);
        for (&joint, value) in flexible.iter().zip(rotors) {
            motors[joint] = *value;
        }
    }
}
