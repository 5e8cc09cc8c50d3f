//! The functions of a robot with known parameters, one state at a time.

use sprung_core::chain::Chain;
use sprung_core::dynamics::inverse_dynamics;
use sprung_core::links::Step;
use sprung_core::parameters::{JointParameter, Side};
use sprung_core::robot::{Torques, Values};
use sprung_core::spatial::BODY;

use super::integrator::{Integrator, StepsExhausted};
use super::plant::{JointState, Plant};
use crate::model::{Model, Scratch, Theta};

/// Relative error of a simulated step.
const TOLERANCE: f64 = 1e-9;

/// A robot with known parameters.
///
/// Vectors have one number per joint, in SI units: rad and N·m for revolute joints, m and N for
/// prismatic ones. The motor of a rigid joint moves with its link.
#[derive(Clone, Debug)]
pub struct Dynamics {
    model: Model,
    theta: Theta,
    bodies: Vec<[f64; BODY]>,
    scratch: Scratch,
}

/// Torques on the links and on the motors, each \[n\], N·m (N).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BothTorques {
    /// On the links; zero at rigid joints.
    pub link: Vec<f64>,
    /// On the motors.
    pub motor: Vec<f64>,
}

/// Accelerations of links and motors, each \[n\], rad/s² (m/s²).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Accelerations {
    /// Of the links.
    pub ddq: Vec<f64>,
    /// Of the motors after gear and coupling.
    pub ddphi: Vec<f64>,
}

/// Error of a simulation.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the simulated motion grows without bound after {time_s:.3} s; check the torques, the initial \
     state and the parameters"
)]
pub struct RanAway {
    /// Time after the start, s.
    pub time_s: f64,
}

impl Dynamics {
    /// Returns a robot with parameters.
    ///
    /// - `theta`: the parameters of the model.
    #[must_use]
    pub fn new(model: Model, theta: Theta) -> Self {
        Self {
            bodies: model.bodies(&theta),
            scratch: Scratch::new(model.joint_count()),
            model,
            theta,
        }
    }

    /// Returns the equations and the names of the parameters.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Returns the parameters.
    #[must_use]
    pub fn theta(&self) -> &[f64] {
        &self.theta
    }

    /// Returns the number of joints.
    #[must_use]
    pub fn joints(&self) -> usize {
        self.model.joint_count()
    }

    /// Returns the number of coordinates: those of the links, then those of the motors of flexible
    /// joints.
    #[must_use]
    pub fn coordinates(&self) -> usize {
        self.model.coordinates()
    }

    /// Returns a state in which the motors of rigid joints move with their links.
    fn coupled(&self, state: &JointState) -> JointState {
        let mut state = state.clone();
        for i in (0..self.joints()).filter(|i| !self.model.is_flexible(*i)) {
            (state.phi[i], state.dphi[i]) = (state.q[i], state.dq[i]);
        }
        state
    }

    /// Returns the acceleration of each coordinate.
    fn of_coordinates(&self, accelerations: &Accelerations) -> Vec<f64> {
        let mut values = accelerations.ddq.clone();
        let flexible = (0..self.joints()).filter(|i| self.model.is_flexible(*i));
        values.extend(flexible.map(|i| accelerations.ddphi[i]));
        values
    }

    /// Computes the regressor of the equations of motion, \[coordinates × parameters\], row by row:
    /// its product with the parameters is the external torque on each coordinate.
    ///
    /// The arguments have one number per joint; otherwise all results are NaN.
    ///
    /// # Source
    ///
    /// Eqs. (1), (5) and (6).
    pub fn regressor(&mut self, state: &JointState, accelerations: &Accelerations) -> Vec<f64> {
        let (rows, p) = (self.coordinates(), self.theta.len());
        let state = self.coupled(state);
        let accelerations = self.of_coordinates(accelerations);
        let robot = self.model.robot();
        let mut entries = vec![0.0; robot.entries];
        let mut workspace = self.scratch.workspace();
        let computed =
            robot.torque_entries(&state.view(), &accelerations, &mut workspace, &mut entries);
        if computed.is_err() {
            return vec![f64::NAN; rows * p];
        }
        let mut matrix = vec![0.0; rows * p];
        for row in 0..rows {
            let columns = self.model.equation_columns(row);
            let entries = &entries[self.model.equation_entries(row)];
            for (column, entry) in columns.iter().zip(entries) {
                matrix[row * p + column] += entry;
            }
        }
        matrix
    }

    /// Computes the torques of a motion: on the links from outside, and of the motors.
    ///
    /// # Source
    ///
    /// Eq. (1).
    pub fn inverse_dynamics(
        &mut self,
        state: &JointState,
        accelerations: &Accelerations,
    ) -> BothTorques {
        let p = self.theta.len();
        let regressor = self.regressor(state, accelerations);
        let torques: Vec<f64> = (regressor.chunks(p.max(1)))
            .map(|row| row.iter().zip(&self.theta).map(|(y, x)| y * x).sum())
            .collect();
        self.split(&torques)
    }

    /// Splits the torques on all coordinates into those of links and motors.
    fn split(&self, torques: &[f64]) -> BothTorques {
        let n = self.joints();
        let link = |i: usize| {
            if self.model.is_flexible(i) {
                torques[i]
            } else {
                0.0
            }
        };
        BothTorques {
            link: (0..n).map(link).collect(),
            motor: (0..n).map(|i| torques[self.model.torque_row(i)]).collect(),
        }
    }

    /// Computes the mass matrix of all coordinates, \[coordinates × coordinates\], row by row.
    pub fn mass_matrix(&mut self, q: &[f64]) -> Vec<f64> {
        let rows = self.coordinates();
        let values = Values {
            theta: &self.theta,
            bodies: &self.bodies,
        };
        let mut matrix = vec![0.0; rows * rows];
        let mut workspace = self.scratch.workspace();
        let robot = self.model.robot();
        if (robot.mass_matrix(&values, q, &mut workspace, &mut matrix)).is_err() {
            matrix.fill(f64::NAN);
        }
        matrix
    }

    /// Computes the torques that hold the links against gravity, \[n\].
    #[must_use]
    pub fn gravity(&self, q: &[f64]) -> Vec<f64> {
        let zeros = vec![0.0; q.len()];
        self.links(q, &zeros, true)
    }

    /// Computes the Coriolis and centrifugal torques of the links, \[n\].
    #[must_use]
    pub fn coriolis(&self, q: &[f64], dq: &[f64]) -> Vec<f64> {
        self.links(q, dq, false)
    }

    fn links(&self, q: &[f64], dq: &[f64], heavy: bool) -> Vec<f64> {
        let robot = self.model.robot();
        let whole = robot.links.chain;
        let chain = if heavy {
            whole
        } else {
            Chain::checked(whole.joints(), [0.0; 3], whole.motions())
        };
        let n = self.joints();
        let mut torques = vec![0.0; n];
        let mut steps = vec![Step::default(); n];
        let zeros = vec![0.0; n];
        let computed = inverse_dynamics(
            &chain,
            &self.bodies,
            q,
            dq,
            &zeros,
            &mut steps,
            &mut torques,
        );
        if computed.is_err() {
            torques.fill(f64::NAN);
        }
        torques
    }

    /// Computes the friction torques against the motion of links and motors.
    #[must_use]
    pub fn friction(&self, state: &JointState) -> BothTorques {
        let of = |side: Side| {
            self.drives(state, |what, _| match what {
                JointParameter::BackEmf | JointParameter::TorqueOffset => side == Side::Motor,
                JointParameter::Friction(other, _) | JointParameter::Change(other, ..) => {
                    other == side
                }
                JointParameter::RotorInertia
                | JointParameter::Stiffness
                | JointParameter::CubicStiffness
                | JointParameter::Damping
                | JointParameter::Hysteresis(_)
                | JointParameter::Preload => false,
            })
        };
        BothTorques {
            link: of(Side::Link),
            motor: of(Side::Motor),
        }
    }

    /// Computes the torques of the springs on the links, \[n\]; zero at rigid joints.
    #[must_use]
    pub fn spring(&self, state: &JointState) -> Vec<f64> {
        let n = self.joints();
        self.drives(state, |what, row| {
            row >= n
                && matches!(
                    what,
                    JointParameter::Stiffness
                        | JointParameter::CubicStiffness
                        | JointParameter::Damping
                        | JointParameter::Hysteresis(_)
                        | JointParameter::Preload
                )
        })
    }

    /// Returns the sum of the counted terms of the drives, \[n\].
    fn drives(
        &self,
        state: &JointState,
        counts: impl Fn(JointParameter, usize) -> bool,
    ) -> Vec<f64> {
        let state = self.coupled(state);
        let robot = self.model.robot();
        let mut torques = vec![0.0; self.joints()];
        for term in robot.terms {
            if counts(term.what, term.row) {
                let drive = robot.drive(&state.view(), term.joint);
                let rest = term.rest(&drive, &robot.shapes[term.joint]);
                torques[term.joint] += self.theta[term.column] * rest;
            }
        }
        torques
    }

    /// Computes the accelerations that torques cause; NaN if the mass matrix is not positive
    /// definite.
    ///
    /// # Source
    ///
    /// Eq. (1).
    pub fn forward_dynamics(&mut self, state: &JointState, torques: &BothTorques) -> Accelerations {
        let (n, rows) = (self.joints(), self.coordinates());
        let state = self.coupled(state);
        let values = Values {
            theta: &self.theta,
            bodies: &self.bodies,
        };
        let robot = self.model.robot();
        let mut torque = vec![0.0; rows];
        let mut accelerations = vec![f64::NAN; rows];
        let given = Torques {
            motor: &torques.motor,
            link: Some(&torques.link),
        };
        let mut workspace = self.scratch.workspace();
        let computed = robot
            .coordinate_torques(&given, &mut torque)
            .and_then(|()| {
                robot.acceleration(
                    &values,
                    &state.view(),
                    &torque,
                    &mut workspace,
                    &mut accelerations,
                )
            });
        if computed.is_err() {
            accelerations.fill(f64::NAN);
        }
        Accelerations {
            ddq: accelerations[..n].to_vec(),
            ddphi: (0..n)
                .map(|i| accelerations[self.model.torque_row(i)])
                .collect(),
        }
    }

    /// Simulates a motion. Torques are constant over each period.
    ///
    /// - `torques`: motor torques of each period, each \[n\].
    /// - `period`: period of the torques, s.
    ///
    /// Returns the state at the beginning of each period, and the last one.
    ///
    /// # Errors
    ///
    /// [`RanAway`] if the motion grows without bound.
    pub fn simulate<'a>(
        &self,
        start: &JointState,
        torques: impl Iterator<Item = &'a [f64]>,
        period: f64,
    ) -> Result<Vec<JointState>, RanAway> {
        let start = self.coupled(start);
        let mut plant = Plant::new(&self.model, &self.theta, &start);
        let mut integrator = Integrator::new(TOLERANCE, plant.states());
        let mut states = vec![start];
        for (k, motor) in torques.enumerate() {
            let given = Torques { motor, link: None };
            let moved: Result<(), StepsExhausted> = plant.advance(&mut integrator, &given, period);
            let is_finite = plant.positions().iter().all(|x| x.is_finite());
            if moved.is_err() || !is_finite {
                return Err(RanAway {
                    time_s: k as f64 * period,
                });
            }
            states.push(plant.state());
        }
        Ok(states)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo;
    use crate::description::{no_files, read};
    use std::collections::BTreeMap;

    /// Returns the demo's robot, without friction and damping if requested.
    fn robot(lossless: bool) -> Dynamics {
        let experiment = read("demo", demo::EXPERIMENT, &[], &mut no_files).unwrap();
        let model = Model::new(&experiment).unwrap();
        let mut values: BTreeMap<String, f64> = toml::from_str(demo::TRUTH).unwrap();
        for (name, value) in &mut values {
            if lossless
                && (name.contains("viscous")
                    || name.contains("coulomb")
                    || name.contains("damping"))
            {
                *value = 0.0;
            }
        }
        let theta = model.theta(&values).unwrap();
        Dynamics::new(model.shaped(&values), theta)
    }

    fn state() -> JointState {
        JointState {
            q: vec![0.3, -0.7],
            dq: vec![1.2, -0.4],
            phi: vec![0.35, -0.72],
            dphi: vec![0.9, -0.1],
        }
    }

    fn accelerations() -> Accelerations {
        Accelerations {
            ddq: vec![2.0, -5.0],
            ddphi: vec![-1.0, 4.0],
        }
    }

    fn close(a: &[f64], b: &[f64], tolerance: f64) {
        assert_eq!(a.len(), b.len());
        for (a, b) in a.iter().zip(b) {
            assert!((a - b).abs() <= tolerance * (1.0 + b.abs()), "{a} {b}");
        }
    }

    #[test]
    fn accelerations_by_the_torques_of_a_motion_are_those_of_the_motion() {
        let mut robot = robot(false);
        let torques = robot.inverse_dynamics(&state(), &accelerations());
        let back = robot.forward_dynamics(&state(), &torques);
        close(&back.ddq, &accelerations().ddq, 1e-12);
        close(&back.ddphi, &accelerations().ddphi, 1e-12);
    }

    #[test]
    fn the_parts_of_the_torques_add_up() {
        let mut robot = robot(false);
        let (state, accelerations) = (state(), accelerations());
        let torques = robot.inverse_dynamics(&state, &accelerations);
        let masses = robot.mass_matrix(&state.q);
        let coordinates = robot.of_coordinates(&accelerations);
        let moved: Vec<f64> = (masses.chunks(4))
            .map(|row| row.iter().zip(&coordinates).map(|(m, a)| m * a).sum())
            .collect();
        let (gravity, coriolis) = (robot.gravity(&state.q), robot.coriolis(&state.q, &state.dq));
        let (spring, friction) = (robot.spring(&state), robot.friction(&state));
        let link: Vec<f64> = (0..2)
            .map(|i| moved[i] + gravity[i] + coriolis[i] - spring[i] + friction.link[i])
            .collect();
        let motor: Vec<f64> = (0..2)
            .map(|i| moved[2 + i] + spring[i] + friction.motor[i])
            .collect();
        close(&torques.link, &link, 1e-12);
        close(&torques.motor, &motor, 1e-12);
    }

    #[test]
    fn a_motion_without_losses_keeps_its_energy() {
        let mut robot = robot(true);
        let still = [0.0, 0.0];
        let torques = std::iter::repeat_n(&still[..], 500);
        let states = robot.simulate(&state(), torques, 0.002).unwrap();
        assert_eq!(states.len(), 501);
        let mut energy = |state: &JointState| {
            let masses = robot.mass_matrix(&state.q);
            let v = [state.dq.clone(), state.dphi.clone()].concat();
            let kinetic: f64 = (0..16)
                .map(|at| 0.5 * masses[at] * v[at / 4] * v[at % 4])
                .sum();
            let deflection = state.phi.iter().zip(&state.q).map(|(phi, q)| phi - q);
            let stored: f64 = (robot.spring(state).iter().zip(deflection))
                .map(|(torque, e)| 0.5 * torque * e)
                .sum();
            kinetic + stored
        };
        let (first, last) = (energy(&states[0]), energy(&states[500]));
        assert!(states[500].q != states[0].q);
        assert!((last / first - 1.0).abs() < 1e-6, "{first} {last}");
    }

    #[test]
    fn a_motion_that_runs_away_is_an_error() {
        let robot = robot(false);
        let violent = [1e300, -1e300];
        let error = robot.simulate(&state(), std::iter::repeat_n(&violent[..], 100), 0.01);
        assert!(error.unwrap_err().to_string().contains("without bound"));
    }
}
