//! Compares the dynamics of a file that was read back with those of the identified model.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;
use sprung_core::chain::JointKind;
use sprung_core::drives::State;
use sprung_core::linear::{dot, factor, solve};
use sprung_core::links::{LengthError, Step};
use sprung_core::robot::{Robot, Values};

use super::error::ExportError;
use super::format::Format;
use super::mechanism::{Mechanism, Motion};
use super::robot::{Form, MOTOR, SPRING, StandardRobot};
use crate::model::{Model, Scratch};

/// Number of random states.
pub(super) const STATES: usize = 1000;

/// Number of random states for one of many drawn robots. Their files have equal entries with other values, so a wrong
/// entry shows at the first state.
pub(super) const STATES_OF_DRAW: usize = 4;

/// Largest relative difference from the identified model.
const TOLERANCE: f64 = 1e-9;

/// Ranges of random motions.
const DEFLECTION: f64 = 0.1;
const VELOCITY: f64 = 2.0;
const ACCELERATION: f64 = 10.0;
const TORQUE: f64 = 10.0;

/// Largest differences of a file from the identified model, each relative to the largest value of its
/// state.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Proof {
    /// Number of random states.
    pub states: usize,
    /// Difference of the torques of given motions.
    pub inverse_dynamics: f64,
    /// Difference of the mass matrix.
    pub mass_matrix: f64,
    /// Difference of the accelerations by given torques.
    pub accelerations: f64,
}

/// The identified model as the file can represent it.
pub(super) struct Reference<'a> {
    pub(super) model: &'a Model,
    pub(super) theta: &'a [f64],
    pub(super) robot: &'a StandardRobot,
    pub(super) format: Format,
    pub(super) form: Form,
    /// Number of random states.
    pub(super) states: usize,
}

impl Reference<'_> {
    /// Compares a mechanism at random states.
    ///
    /// # Errors
    ///
    /// [`ExportError::Differs`] if a joint or a friction is missing, or if the dynamics differ.
    pub(super) fn prove(&self, mechanism: &Mechanism) -> Result<Proof, ExportError> {
        let differs = |what: String| ExportError::Differs {
            format: self.format.name(),
            what,
        };
        let map = self.coordinates(mechanism).map_err(differs)?;
        self.check_coulomb(mechanism).map_err(differs)?;
        let proof = self
            .compare(mechanism, &map)
            .map_err(|error| differs(error.to_string()))?;
        for (what, difference) in [
            ("inverse dynamics", proof.inverse_dynamics),
            ("the mass matrix", proof.mass_matrix),
            ("accelerations", proof.accelerations),
        ] {
            if difference.is_nan() || difference > TOLERANCE {
                return Err(differs(format!("{what} by {difference:.1e}")));
            }
        }
        Ok(proof)
    }

    /// Returns each coordinate of the model as a combination of the joints of the file, \[rows × joints\].
    fn coordinates(&self, mechanism: &Mechanism) -> Result<Vec<Vec<f64>>, String> {
        let mut used = vec![false; mechanism.joints.len()];
        let mut map = Vec::new();
        for row in 0..self.model.coordinates() {
            let joint = &self.robot.joints[self.model.joint_of(row)];
            let is_motor = row >= self.model.joint_count();
            let (name, motor): (String, String) =
                (joint.name.clone(), format!("{}{MOTOR}", joint.name));
            let parts = match (joint.has_spring(self.form), self.format, is_motor) {
                (true, Format::Sdf, false) => vec![motor, format!("{name}{SPRING}")],
                (true, _, true) => vec![motor],
                _ => vec![name],
            };
            let mut combination = vec![0.0; mechanism.joints.len()];
            for part in parts {
                let at = mechanism.joint(&part);
                let at = at.ok_or_else(|| format!("it has no joint {part}"))?;
                combination[at] = 1.0;
                used[at] = true;
            }
            map.push(combination);
        }
        match used.iter().position(|used| !used) {
            Some(at) => Err(format!(
                "it has a joint {} too many",
                mechanism.joints[at].name
            )),
            None => Ok(map),
        }
    }

    fn check_coulomb(&self, mechanism: &Mechanism) -> Result<(), String> {
        for joint in &self.robot.joints {
            let (link, motor) = (joint.drive.link.coulomb, joint.drive.motor.coulomb);
            let name = &joint.name;
            let wanted = match (joint.has_spring(self.form), self.format) {
                (true, Format::Sdf) => vec![
                    (format!("{name}{MOTOR}"), link + motor),
                    (format!("{name}{SPRING}"), 0.0),
                ],
                (true, _) => vec![(name.clone(), link), (format!("{name}{MOTOR}"), motor)],
                (false, _) => vec![(name.clone(), link + motor)],
            };
            for (name, wanted) in wanted {
                let found = mechanism
                    .joint(&name)
                    .map(|at| mechanism.joints[at].coulomb);
                let found = found.ok_or_else(|| format!("it has no joint {name}"))?;
                if (found - wanted).abs() > TOLERANCE * wanted {
                    return Err(format!(
                        "the Coulomb friction of {name} is {found} instead of {wanted}"
                    ));
                }
            }
        }
        Ok(())
    }

    fn compare(&self, mechanism: &Mechanism, map: &[Vec<f64>]) -> Result<Proof, LengthError> {
        let gravity = mechanism.gravity.unwrap_or(self.robot.gravity);
        let count = mechanism.joints.len();
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let mut proof = Proof {
            states: self.states,
            inverse_dynamics: 0.0,
            mass_matrix: 0.0,
            accelerations: 0.0,
        };
        let zeros = vec![0.0; count];
        for _ in 0..self.states {
            let q = self.positions(mechanism, &mut random);
            let mut draw = |size: f64| -> Vec<f64> {
                (0..count)
                    .map(|_| random.random_range(-size..size))
                    .collect()
            };
            let (dq, ddq, torque) = (draw(VELOCITY), draw(ACCELERATION), draw(TORQUE));
            let motion = |ddq| Motion {
                q: &q,
                dq: &dq,
                ddq,
            };
            let known = self.torques(map, &motion(&ddq))?;
            let found = mechanism.torques(&motion(&ddq), gravity);
            worst(&mut proof.inverse_dynamics, &known, &found);
            let masses = self.masses(map, &q)?;
            let found = mechanism.masses(&q);
            worst(&mut proof.mass_matrix, &masses, &found);
            let accelerations = |masses: &[f64], still: &[f64]| {
                let mut left: Vec<f64> = (torque.iter().zip(still)).map(|(t, s)| t - s).collect();
                let mut masses = masses.to_vec();
                if factor(&mut masses, count) {
                    solve(&masses, &mut left);
                } else {
                    left.fill(f64::NAN);
                }
                left
            };
            let known = accelerations(&masses, &self.torques(map, &motion(&zeros))?);
            let found = accelerations(&found, &mechanism.torques(&motion(&zeros), gravity));
            worst(&mut proof.accelerations, &known, &found);
        }
        Ok(proof)
    }

    /// Returns random positions of the joints of a file with small deflections.
    fn positions(&self, mechanism: &Mechanism, random: &mut ChaCha8Rng) -> Vec<f64> {
        let mut positions = vec![0.0; mechanism.joints.len()];
        for (i, joint) in self.robot.joints.iter().enumerate() {
            let reach = match self.model.kind(i) {
                JointKind::Revolute => std::f64::consts::PI,
                JointKind::Prismatic => 1.0,
            };
            let position = random.random_range(-reach..reach);
            let deflection = random.random_range(-DEFLECTION..DEFLECTION);
            let motor = format!("{}{MOTOR}", joint.name);
            for (name, value) in [
                (joint.name.clone(), position),
                (motor, position + deflection),
                (format!("{}{SPRING}", joint.name), -deflection),
            ] {
                if let Some(at) = mechanism.joint(&name) {
                    positions[at] = value;
                }
            }
        }
        positions
    }

    /// Returns the torques on the joints of the file by the identified model.
    fn torques(&self, map: &[Vec<f64>], motion: &Motion<'_>) -> Result<Vec<f64>, LengthError> {
        let of = |values: &[f64]| -> Vec<f64> { map.iter().map(|row| dot(row, values)).collect() };
        let (x, dx, ddx) = (of(motion.q), of(motion.dq), of(motion.ddq));
        let n = self.model.joint_count();
        let robot = self.model.robot();
        let motor = |values: &[f64]| -> Vec<f64> {
            (0..n).map(|i| values[robot.motor_coordinate(i)]).collect()
        };
        let (phi, dphi, ddphi) = (motor(&x), motor(&dx), motor(&ddx));
        let bodies = self.model.bodies(self.theta);
        let values = Values {
            theta: self.theta,
            bodies: &bodies,
        };
        let motion = [&x[..n], &dx[..n], &ddx[..n], &phi, &dphi, &ddphi];
        let mut torques = required(&robot, &values, motion)?;
        if self.format == Format::Sdf {
            // The exactness table states that the bearing's friction acts on the motor.
            for (i, joint) in self.robot.joints.iter().enumerate() {
                if joint.has_spring(self.form) {
                    let viscous = joint.drive.link.viscous;
                    torques[i] -= viscous * dx[i];
                    torques[robot.motor_coordinate(i)] += viscous * dphi[i];
                }
            }
        }
        Ok(back(map, &torques))
    }

    /// Returns the mass matrix of the joints of the file by the identified model.
    fn masses(&self, map: &[Vec<f64>], q: &[f64]) -> Result<Vec<f64>, LengthError> {
        let n = self.model.joint_count();
        let rows = map.len();
        let x: Vec<f64> = map.iter().map(|row| dot(row, q)).collect();
        let bodies = self.model.bodies(self.theta);
        let values = Values {
            theta: self.theta,
            bodies: &bodies,
        };
        let mut masses = vec![0.0; rows * rows];
        let mut scratch = Scratch::new(n);
        let robot = self.model.robot();
        robot.mass_matrix(&values, &x[..n], &mut scratch.workspace(), &mut masses)?;
        // Mapᵀ M Map.
        let count = q.len();
        let mut half = vec![vec![0.0; rows]; count];
        for (column, half) in half.iter_mut().enumerate() {
            for (row, entry) in half.iter_mut().enumerate() {
                *entry = (0..rows)
                    .map(|k| masses[row * rows + k] * map[k][column])
                    .sum();
            }
        }
        let columns: Vec<Vec<f64>> = half.iter().map(|half| back(map, half)).collect();
        Ok((0..count * count)
            .map(|at| columns[at % count][at / count])
            .collect())
    }
}

/// Returns a state without memory of the motion, at the references of all covariates.
pub(super) fn state([q, dq, phi, dphi]: [&[f64]; 4]) -> State<'_> {
    State {
        q,
        dq,
        phi,
        dphi,
        excess: &[],
        elements: &[],
    }
}

/// Returns the torques that a motion requires in all coordinates of the model, row by row.
///
/// - `q`, `dq`, `ddq`, then those of the motors, each \[n\].
///
/// # Errors
///
/// [`LengthError`] if the parameters do not fit the robot.
pub(super) fn required(
    robot: &Robot<'_>,
    values: &Values<'_>,
    [q, dq, ddq, phi, dphi, ddphi]: [&[f64]; 6],
) -> Result<Vec<f64>, LengthError> {
    let n = robot.joints();
    let mut torques = vec![0.0; robot.rows()];
    let mut steps = vec![Step::default(); n];
    robot.link_torque(values, q, dq, ddq, &mut steps, &mut torques[..n])?;
    let state = state([q, dq, phi, dphi]);
    for term in robot.terms {
        let drive = robot.drive(&state, term.joint);
        let rest = term.rest(&drive, &robot.shapes[term.joint]);
        let column = rest + term.momentum(ddphi[term.joint]);
        torques[term.row] += values.theta[term.column] * column;
    }
    Ok(torques)
}

/// Multiplies by the transposed map.
fn back(map: &[Vec<f64>], torques: &[f64]) -> Vec<f64> {
    let count = map.first().map_or(0, Vec::len);
    (0..count)
        .map(|column| {
            (map.iter().zip(torques))
                .map(|(row, t)| row[column] * t)
                .sum()
        })
        .collect()
}

/// Raises the largest relative difference. A value that is no number stays.
pub(super) fn worst(largest: &mut f64, known: &[f64], found: &[f64]) {
    let size = known.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
    let difference = (known.iter().zip(found)).fold(0.0_f64, |most, (a, b)| {
        let difference = (a - b).abs();
        if difference.is_nan() || most.is_nan() {
            f64::NAN
        } else {
            most.max(difference)
        }
    });
    let relative = if size > 0.0 {
        difference / size
    } else {
        difference
    };
    *largest = if relative.is_nan() || largest.is_nan() {
        f64::NAN
    } else {
        largest.max(relative)
    };
}
