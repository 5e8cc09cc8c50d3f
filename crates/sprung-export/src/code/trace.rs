//! Functions of the model as expressions.

use sprung_core::chain::Chain;
use sprung_core::drives::Drive;
use sprung_core::dynamics::{inverse_dynamics, mass_matrix};
use sprung_core::links::{
    JointScratch, LengthError, PairScratch, Step, Workspace, numbers_len, torque,
};
use sprung_core::parameters::{JointParameter, Side};
use sprung_core::presliding::ALL_ELEMENTS;
use sprung_core::robot::Robot;
use sprung_core::scalar::Scalar;
use sprung_core::spatial::BODY;

use super::graph::{Graph, Operand, Operation, Symbol};
use crate::model::Model;

/// An argument of a function: an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Array {
    /// Name with the unit of revolute joints.
    pub(super) name: &'static str,
    pub(super) shape: Shape,
    pub(super) length: usize,
}

/// Which numbers an array contains.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    /// One for each joint.
    Vector,
    /// The square of a vector, row by row.
    Matrix,
    /// The elements of presliding friction and hysteresis of each joint.
    Elements,
    /// One for each row of the model and each parameter, row by row; most are zero.
    Regressor,
}

/// A function of the model.
#[derive(Debug)]
pub(super) struct Traced {
    pub(super) name: &'static str,
    pub(super) about: &'static str,
    pub(super) inputs: Vec<Array>,
    pub(super) outputs: Vec<Array>,
    /// Operations with their numbers, each after its operands.
    pub(super) operations: Vec<(u32, Operation)>,
    /// Values of all outputs, one after the other.
    pub(super) results: Vec<Operand>,
}

/// Names of the arguments, with their units.
pub(super) const Q: &str = "q_rad";
pub(super) const DQ: &str = "dq_rad_per_s";
pub(super) const DDQ: &str = "ddq_rad_per_s2";
pub(super) const PHI: &str = "phi_rad";
pub(super) const DPHI: &str = "dphi_rad_per_s";
pub(super) const DDPHI: &str = "ddphi_rad_per_s2";
pub(super) const TAU: &str = "tau_nm";
pub(super) const TAU_LINK: &str = "tau_link_nm";
pub(super) const TAU_MOTOR: &str = "tau_motor_nm";
pub(super) const MASS: &str = "mass_kgm2";
pub(super) const REGRESSOR: &str = "regressor";
pub(super) const ELEMENTS: &str = "elements";

/// Name of inverse dynamics.
const INVERSE_DYNAMICS: &str = "inverse_dynamics";

/// Name of inverse dynamics with the elements as arguments.
pub(super) const WITH_MEMORY: &str = "inverse_dynamics_with_memory";

/// Name of inverse dynamics without the springs that have a torque sensor.
pub(super) const BESIDE_SENSORS: &str = "inverse_dynamics_beside_sensors";

/// The identified model.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub(super) model: &'a Model,
    /// Its equations.
    pub(super) robot: Robot<'a>,
    /// Parameters of all laws.
    pub(super) theta: &'a [f64],
    pub(super) bodies: &'a [[f64; BODY]],
}

/// Motion of links and motors, as numbers of a graph.
struct Motion<'g> {
    q: Vec<Symbol<'g>>,
    dq: Vec<Symbol<'g>>,
    ddq: Vec<Symbol<'g>>,
    phi: Vec<Symbol<'g>>,
    dphi: Vec<Symbol<'g>>,
    ddphi: Vec<Symbol<'g>>,
    /// \[n\]; empty for a function without memory of the motion.
    elements: Vec<[Symbol<'g>; ALL_ELEMENTS]>,
}

impl<'g> Motion<'g> {
    /// Returns the arrays that a function has; other numbers are zero. The motor of a rigid joint moves
    /// with its link.
    fn of(graph: &'g Graph, robot: &Robot<'_>, inputs: &[Array]) -> Self {
        let n = robot.joints();
        let place = |name: &str| {
            let at = inputs.iter().position(|input| input.name == name)?;
            Some(inputs[..at].iter().map(|input| input.length).sum::<usize>())
        };
        let array = |name: &str| -> Vec<Symbol<'g>> {
            place(name).map_or_else(
                || vec![Symbol::ZERO; n],
                |at| (at..at + n).map(|index| graph.input(index)).collect(),
            )
        };
        let elements = place(ELEMENTS).map_or_else(Vec::new, |at| {
            let of_joint =
                |joint: usize| std::array::from_fn(|k| graph.input(at + joint * ALL_ELEMENTS + k));
            (0..n).map(of_joint).collect()
        });
        let motor = |name: &str, link: &[Symbol<'g>]| {
            let motor = array(name);
            let of = |i: usize| robot.motor_rows[i].map_or(link[i], |_| motor[i]);
            (0..n).map(of).collect()
        };
        let (q, dq, ddq) = (array(Q), array(DQ), array(DDQ));
        Self {
            phi: motor(PHI, &q),
            dphi: motor(DPHI, &dq),
            ddphi: motor(DDPHI, &ddq),
            elements,
            q,
            dq,
            ddq,
        }
    }

    /// Returns the motion of a joint, at the references of all covariates.
    fn drive(&self, joint: usize) -> Drive<Symbol<'g>> {
        Drive {
            deflection: self.phi[joint] - self.q[joint],
            deflection_rate: self.dphi[joint] - self.dq[joint],
            link_velocity: self.dq[joint],
            motor_velocity: self.dphi[joint],
            excess: [0.0; _],
            elements: self.elements.get(joint).copied(),
        }
    }
}

/// What acts on a joint.
#[derive(Clone, Copy, PartialEq, Eq)]
enum JointPart {
    Rotor,
    Spring,
    Friction(Side),
}

fn part(what: JointParameter) -> JointPart {
    match what {
        JointParameter::RotorInertia => JointPart::Rotor,
        JointParameter::Stiffness
        | JointParameter::CubicStiffness
        | JointParameter::Damping
        | JointParameter::Hysteresis(_)
        | JointParameter::Preload => JointPart::Spring,
        JointParameter::BackEmf | JointParameter::TorqueOffset => JointPart::Friction(Side::Motor),
        JointParameter::Friction(side, _) | JointParameter::Change(side, ..) => {
            JointPart::Friction(side)
        }
    }
}

impl Source<'_> {
    /// Returns the functions of the model.
    ///
    /// # Errors
    ///
    /// [`LengthError`] if the parameters do not fit the robot.
    pub(super) fn trace(&self) -> Result<Vec<Traced>, LengthError> {
        let drives = [Q, DQ, PHI, DPHI];
        Ok(vec![
            self.function(
                "gravity",
                "Torques that hold the links against gravity.",
                &[Q],
                &[TAU],
                |motion| self.links(&motion.q, &motion.dq, &motion.ddq, true),
            )?,
            self.function(
                "coriolis",
                "Coriolis and centrifugal torques C(q, dq) dq.",
                &[Q, DQ],
                &[TAU],
                |motion| self.links(&motion.q, &motion.dq, &motion.ddq, false),
            )?,
            self.function(
                "mass_matrix",
                "Mass matrix of the links and of the rotors of rigid joints, row by row.",
                &[Q],
                &[MASS],
                |motion| self.masses(&motion.q),
            )?,
            self.function(
                "spring",
                "Torques of the springs on the links; zero at rigid joints.",
                &drives,
                &[TAU],
                |motion| {
                    let n = self.robot.joints();
                    let of_springs = |part, row, _| part == JointPart::Spring && row >= n;
                    Ok(self.drives(motion, of_springs))
                },
            )?,
            self.function(
                "friction",
                "Friction torques against the motion of links and motors.",
                &drives,
                &[TAU_LINK, TAU_MOTOR],
                |motion| {
                    let of = |side| {
                        self.drives(motion, move |part, _, _| part == JointPart::Friction(side))
                    };
                    Ok([of(Side::Link), of(Side::Motor)].concat())
                },
            )?,
            self.function(
                INVERSE_DYNAMICS,
                "Torques of a motion: on the links from outside (zero at rigid joints), and of the motors.",
                &[Q, DQ, DDQ, PHI, DPHI, DDPHI],
                &[TAU_LINK, TAU_MOTOR],
                |motion| self.all(motion, |_, _| true),
            )?,
            self.function(
                REGRESSOR,
                "Regressor, row by row: times the parameters theta, it gives the torques of a motion.",
                &[Q, DQ, DDQ, PHI, DPHI, DDPHI],
                &[REGRESSOR],
                |motion| self.regressor(motion),
            )?,
        ])
    }

    /// Returns inverse dynamics with the memory of presliding friction and of hysteresis.
    ///
    /// # Errors
    ///
    /// [`LengthError`] if the parameters do not fit the robot.
    pub(super) fn with_memory(&self) -> Result<Traced, LengthError> {
        self.function(
            WITH_MEMORY,
            "Torques as of inverse_dynamics, with the elements of presliding friction and hysteresis.",
            &[Q, DQ, DDQ, PHI, DPHI, DDPHI, ELEMENTS],
            &[TAU_LINK, TAU_MOTOR],
            |motion| self.all(motion, |_, _| true),
        )
    }

    /// Returns inverse dynamics without the springs that have a torque sensor, for an observer; `None` without torque sensors.
    ///
    /// # Errors
    ///
    /// [`LengthError`] if the parameters do not fit the robot.
    pub(super) fn beside_sensors(&self) -> Result<Option<Traced>, LengthError> {
        if self.observer_dynamics() != BESIDE_SENSORS {
            return Ok(None);
        }
        let inputs = [Q, DQ, DDQ, PHI, DPHI, DDPHI, ELEMENTS];
        let used = inputs.len() - usize::from(!self.has_memory());
        let is_measured = self.has_sensor();
        let counted =
            |part: JointPart, joint: usize| part != JointPart::Spring || !is_measured[joint];
        let traced = self.function(
            BESIDE_SENSORS,
            "Torques as of inverse_dynamics, without the springs whose torque a sensor measures.",
            &inputs[..used],
            &[TAU_LINK, TAU_MOTOR],
            |motion| self.all(motion, counted),
        )?;
        Ok(Some(traced))
    }

    /// Returns the name of the dynamics of an observer.
    pub(super) fn observer_dynamics(&self) -> &'static str {
        if self.has_sensor().contains(&true) {
            BESIDE_SENSORS
        } else if self.has_memory() {
            WITH_MEMORY
        } else {
            INVERSE_DYNAMICS
        }
    }

    /// Returns whether code has a memory of presliding friction or hysteresis. That behind a coupled transmission it has not.
    pub(super) fn has_memory(&self) -> bool {
        self.robot.coupling.is_none() && !self.model.elements().is_empty()
    }

    /// Returns whether code has a memory of presliding friction.
    pub(super) fn has_presliding(&self) -> bool {
        self.has_memory() && self.model.elements().sets().any(|set| !set.is_of_spring)
    }

    /// Returns whether each joint has a torque sensor, \[n\].
    pub(super) fn has_sensor(&self) -> Vec<bool> {
        (0..self.robot.joints())
            .map(|joint| self.model.has_torque_sensor(joint))
            .collect()
    }

    fn function(
        &self,
        name: &'static str,
        about: &'static str,
        inputs: &[&'static str],
        outputs: &[&'static str],
        compute: impl for<'g> Fn(&Motion<'g>) -> Result<Vec<Symbol<'g>>, LengthError>,
    ) -> Result<Traced, LengthError> {
        let array = |name: &&'static str| self.array(name);
        let inputs: Vec<Array> = inputs.iter().map(array).collect();
        let graph = Graph::default();
        let results = compute(&Motion::of(&graph, &self.robot, &inputs))?;
        let results: Vec<Operand> = results.into_iter().map(Symbol::operand).collect();
        Ok(Traced {
            name,
            about,
            outputs: outputs.iter().map(array).collect(),
            inputs,
            operations: graph.needed(&results),
            results,
        })
    }

    /// Returns the array with a name.
    pub(super) fn array(&self, name: &'static str) -> Array {
        let n = self.robot.joints();
        let (shape, length) = match name {
            MASS => (Shape::Matrix, n * n),
            ELEMENTS => (Shape::Elements, n * ALL_ELEMENTS),
            REGRESSOR => (Shape::Regressor, self.robot.rows() * self.theta.len()),
            _ => (Shape::Vector, n),
        };
        Array {
            name,
            shape,
            length,
        }
    }

    /// Returns the torques of the links.
    fn links<S: Scalar>(
        &self,
        q: &[S],
        dq: &[S],
        ddq: &[S],
        heavy: bool,
    ) -> Result<Vec<S>, LengthError> {
        let n = self.robot.joints();
        let whole = self.robot.links.chain;
        let chain = if heavy {
            whole
        } else {
            Chain::checked(whole.joints(), [0.0; 3], whole.motions())
        };
        let mut torques = vec![S::ZERO; n];
        let mut steps = vec![Step::default(); n];
        inverse_dynamics(&chain, self.bodies, q, dq, ddq, &mut steps, &mut torques)?;
        Ok(torques)
    }

    fn masses<S: Scalar>(&self, q: &[S]) -> Result<Vec<S>, LengthError> {
        let n = self.robot.joints();
        let mut masses = vec![S::ZERO; n * n];
        let mut steps = vec![Step::default(); n];
        mass_matrix(
            &self.robot.links.chain,
            self.bodies,
            q,
            &mut steps,
            &mut masses,
        )?;
        for (joint, inertia) in self.rotors().into_iter().enumerate() {
            if self.robot.motor_rows[joint].is_none() {
                let at = joint * n + joint;
                masses[at] = masses[at] + S::constant(inertia);
            }
        }
        Ok(masses)
    }

    /// Returns the inertia of each rotor after the gear, \[n\].
    pub(super) fn rotors(&self) -> Vec<f64> {
        let mut rotors = vec![0.0; self.robot.joints()];
        for term in self.robot.terms {
            rotors[term.joint] += self.theta[term.column] * term.momentum(1.0);
        }
        rotors
    }

    /// Returns the reciprocal of the inertia of the rotor of each flexible joint, \[n\]; zero at rigid
    /// joints.
    pub(super) fn inverse_rotors(&self) -> Vec<f64> {
        let rotors = self.rotors().into_iter().enumerate();
        rotors
            .map(|(joint, inertia)| {
                let behind_spring = self.model.is_flexible(joint) && inertia > 0.0;
                if behind_spring { 1.0 / inertia } else { 0.0 }
            })
            .collect()
    }

    /// Returns the sum of the terms of a drive in each joint, \[n\].
    ///
    /// - `counts`: whether a part in a row counts at a joint.
    fn drives<'g>(
        &self,
        motion: &Motion<'g>,
        counts: impl Fn(JointPart, usize, usize) -> bool,
    ) -> Vec<Symbol<'g>> {
        let n = self.robot.joints();
        let mut torques = vec![Symbol::ZERO; n];
        for term in self.robot.terms {
            if !counts(part(term.what), term.row, term.joint) {
                continue;
            }
            let i = term.joint;
            let rest = term.rest(&motion.drive(i), &self.robot.shapes[i]);
            torques[i] = torques[i] + rest * self.theta[term.column];
        }
        torques
    }

    /// Returns the torques on the links and those of the motors.
    ///
    /// - `counts`: whether a part of a joint counts.
    fn all<'g>(
        &self,
        motion: &Motion<'g>,
        counts: impl Fn(JointPart, usize) -> bool,
    ) -> Result<Vec<Symbol<'g>>, LengthError> {
        let n = self.robot.joints();
        let mut links = self.links(&motion.q, &motion.dq, &motion.ddq, true)?;
        let drives = self.drives(motion, |part, row, joint| row < n && counts(part, joint));
        for (link, drive) in links.iter_mut().zip(drives) {
            *link = *link + drive;
        }
        let mut motors = self.drives(motion, |part, row, joint| row >= n && counts(part, joint));
        for (i, inertia) in self.rotors().into_iter().enumerate() {
            motors[i] = motors[i] + motion.ddphi[i] * inertia;
            if self.robot.motor_rows[i].is_none() {
                motors[i] = motors[i] + links[i];
                links[i] = Symbol::ZERO;
            }
        }
        debug_assert_eq!(links.len(), n);
        Ok([links, motors].concat())
    }

    /// Returns the regressor, row by row.
    fn regressor<'g>(&self, motion: &Motion<'g>) -> Result<Vec<Symbol<'g>>, LengthError> {
        let (n, width) = (self.robot.joints(), self.theta.len());
        let mut columns = vec![Symbol::ZERO; n * n * BODY];
        torque(
            &self.robot.links.chain,
            &motion.q,
            &motion.dq,
            &motion.ddq,
            &mut Workspace {
                joints: &mut vec![JointScratch::default(); n],
                steps: &mut vec![Step::default(); n],
                pairs: &mut vec![PairScratch::default(); n * n],
                numbers: &mut vec![Symbol::ZERO; numbers_len(n)],
            },
            &mut columns,
        )?;
        let mut entries = vec![Symbol::ZERO; self.robot.rows() * width];
        for column in 0..self.robot.links.selected.len() {
            // Bodies are linear in theta.
            let mut unit = vec![0.0; width];
            unit[column] = 1.0;
            let bodies = self.model.bodies(&unit).concat();
            for (row, of_row) in columns.chunks(n * BODY).enumerate() {
                let products = of_row.iter().zip(&bodies).map(|(x, y)| *x * *y);
                entries[row * width + column] = products.fold(Symbol::ZERO, |sum, x| sum + x);
            }
        }
        for term in self.robot.terms {
            let i = term.joint;
            let rest = term.rest(&motion.drive(i), &self.robot.shapes[i]);
            let contribution = rest + motion.ddphi[i] * term.momentum(1.0);
            let entry = &mut entries[term.row * width + term.column];
            *entry = *entry + contribution;
        }
        Ok(entries)
    }
}
