//! Simulates links and motors separately, each with the measured motion of the other.

use sprung_core::drives::State;
use sprung_core::robot::{Torques, Values};

use super::integrator::{Integrator, StepsExhausted};
use crate::model::{Model, Scratch};

/// Largest accepted error of a step, rad (m) and rad/s (m/s). It is far below an encoder's
/// resolution, which is accurate enough for this simulation.
const TOLERANCE: f64 = 1e-6;

/// Limit of simulated velocities over the largest measured velocity; a faster motion is unrelated
/// to the log.
const VELOCITY_LIMIT_RATIO: f64 = 10.0;

/// A measured motion, evenly sampled; columns of \[samples\], one per joint.
#[derive(Clone, Copy, Debug)]
pub struct Measured<'a> {
    /// Link positions, rad (m).
    pub q: &'a [Vec<f64>],
    /// Link velocities, rad/s (m/s).
    pub dq: &'a [Vec<f64>],
    /// Motor positions after gear and coupling, rad (m).
    pub phi: &'a [Vec<f64>],
    /// Motor velocities after gear and coupling, rad/s (m/s).
    pub dphi: &'a [Vec<f64>],
    /// Motor torques after gear and coupling, held until the next sample, N·m (N).
    pub tau: &'a [Vec<f64>],
}

/// Positions of links and motors, rad (m), columns of \[samples\], one per joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Positions {
    /// Link positions.
    pub q: Vec<Vec<f64>>,
    /// Motor positions after gear and coupling.
    pub phi: Vec<Vec<f64>>,
}

/// Simulates links and motors separately. The measured motors drive the links of flexible joints
/// through their springs. The torques, and the measured links through the springs, drive the
/// motors. Both start at the measured state; measured positions and velocities are linear between
/// samples.
///
/// No controller is needed. Neither part drifts away from the log, because a spring connects it to
/// the measured motion. A rigid joint has no spring, so it may drift.
///
/// - `theta`: parameters with physical inertias, \[p\]; `period`: T, s.
///
/// # Errors
///
/// [`StepsExhausted`] if the integration fails, or if a velocity exceeds ten times the fastest
/// measured velocity.
pub fn subsystems(
    model: &Model,
    theta: &[f64],
    measured: &Measured<'_>,
    period: f64,
) -> Result<Positions, StepsExhausted> {
    let n = model.joint_count();
    let samples = measured.q.first().map_or(0, Vec::len);
    let flexible: Vec<usize> = (0..n).filter(|&joint| model.is_flexible(joint)).collect();
    let at = |columns: &[Vec<f64>], k: usize| columns.iter().map(|c| c[k]).collect::<Vec<f64>>();
    let rotors = |all: Vec<f64>| flexible.iter().map(|&i| all[i]).collect::<Vec<f64>>();
    let columns = || vec![Vec::with_capacity(samples); n];
    let mut positions = Positions {
        q: columns(),
        phi: columns(),
    };
    if samples == 0 {
        return Ok(positions);
    }
    let velocities = measured.dq.iter().chain(measured.dphi).flatten();
    let fastest = VELOCITY_LIMIT_RATIO * velocities.fold(f64::MIN_POSITIVE, |m, v| m.max(v.abs()));
    // The last state is the time since the last sample, in periods.
    let mut x = [
        at(measured.q, 0),
        rotors(at(measured.phi, 0)),
        at(measured.dq, 0),
        rotors(at(measured.dphi, 0)),
        vec![0.0],
    ]
    .concat();
    let half = x.len() / 2;
    let mut subsystems = Subsystems {
        model,
        theta,
        bodies: model.bodies(theta),
        flexible: &flexible,
        scratch: Scratch::new(n),
        links: vec![0.0; 4 * n],
        motors: vec![0.0; 4 * n],
        torque: vec![0.0; model.coordinates()],
        out: vec![0.0; 2 * model.coordinates()],
    };
    let mut integrator = Integrator::new(TOLERANCE, x.len());
    let (mut from, mut to) = (vec![0.0; 4 * n], vec![0.0; 4 * n]);
    for k in 0..samples {
        let rotor_of = |joint: usize| flexible.binary_search(&joint).map_or(joint, |i| n + i);
        for joint in 0..n {
            positions.q[joint].push(x[joint]);
            positions.phi[joint].push(x[rotor_of(joint)]);
        }
        if k + 1 == samples {
            break;
        }
        let groups = [measured.q, measured.dq, measured.phi, measured.dphi];
        for (group, columns) in groups.into_iter().enumerate() {
            for joint in 0..n {
                from[group * n + joint] = columns[joint][k];
                to[group * n + joint] = columns[joint][k + 1];
            }
        }
        let tau = at(measured.tau, k);
        x[2 * half] = 0.0;
        integrator.advance(&mut x, period, |x, rate| {
            subsystems.rate(x, &from, &to, &tau, rate);
            rate[2 * half] = 1.0 / period;
        })?;
        let follows = x[half..2 * half].iter().all(|v| v.abs() <= fastest);
        if !follows {
            return Err(StepsExhausted);
        }
    }
    Ok(positions)
}

/// A robot in two parts, with their buffers.
struct Subsystems<'a> {
    model: &'a Model,
    theta: &'a [f64],
    bodies: Vec<[f64; sprung_core::spatial::BODY]>,
    flexible: &'a [usize],
    scratch: Scratch,
    // q, dq, phi and dphi with simulated links, and the same with simulated motors.
    links: Vec<f64>,
    motors: Vec<f64>,
    // Torque on each coordinate, and the accelerations of both parts.
    torque: Vec<f64>,
    out: Vec<f64>,
}

impl Subsystems<'_> {
    /// Writes the time derivative of links, rotors of flexible joints and their velocities.
    ///
    /// - `from`, `to`: measured q, dq, phi and dphi at the samples before and after.
    fn rate(&mut self, x: &[f64], from: &[f64], to: &[f64], tau: &[f64], rate: &mut [f64]) {
        let n = tau.len();
        let half = x.len() / 2;
        let part = x[2 * half];
        for (at, (from, to)) in from.iter().zip(to).enumerate() {
            let measured = from + part * (to - from);
            self.links[at] = measured;
            self.motors[at] = measured;
        }
        for joint in 0..n {
            self.links[joint] = x[joint];
            self.links[n + joint] = x[half + joint];
            if !self.model.is_flexible(joint) {
                self.links[2 * n + joint] = x[joint];
                self.links[3 * n + joint] = x[half + joint];
            }
        }
        for (i, &joint) in self.flexible.iter().enumerate() {
            self.motors[2 * n + joint] = x[n + i];
            self.motors[3 * n + joint] = x[half + n + i];
        }
        let values = Values {
            theta: self.theta,
            bodies: &self.bodies,
        };
        let torques = Torques {
            motor: tau,
            link: None,
        };
        let robot = self.model.robot();
        // The buffers have the robot's sizes, so no error is expected here and below.
        let mut fits = robot.coordinate_torques(&torques, &mut self.torque).is_ok();
        let halves = [&self.links, &self.motors].into_iter();
        for (all, out) in halves.zip(self.out.chunks_mut(half)) {
            let state = State {
                q: &all[..n],
                dq: &all[n..2 * n],
                phi: &all[2 * n..3 * n],
                dphi: &all[3 * n..],
                excess: &[],
            };
            let mut workspace = self.scratch.workspace();
            let solved = robot.acceleration(&values, &state, &self.torque, &mut workspace, out);
            fits &= solved.is_ok();
        }
        if !fits {
            rate.fill(f64::NAN);
            return;
        }
        rate[..half].copy_from_slice(&x[half..2 * half]);
        rate[half..half + n].copy_from_slice(&self.out[..n]);
        rate[half + n..2 * half].copy_from_slice(&self.out[half + n..]);
    }
}
