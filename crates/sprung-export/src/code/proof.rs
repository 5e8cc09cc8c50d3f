//! Compares the operations of the code with the identified model, and draws the states of the self-test.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sprung_core::chain::{Chain, JointKind};
use sprung_core::drives::State;
use sprung_core::dynamics::inverse_dynamics;
use sprung_core::linear::{factor, solve};
use sprung_core::links::{LengthError, Step};
use sprung_core::robot::{Torques, Values};

use super::graph::values;
use super::trace::{DDPHI, DDQ, DPHI, DQ, PHI, Q, REGRESSOR, Source, Traced};
use crate::model::Scratch;
use crate::reload::{Proof, required, state, worst};

/// Number of random states.
const STATES: usize = 1000;

/// Number of states in the self-test.
const IN_TEST: usize = 5;

/// Ranges of random motions.
const DEFLECTION: f64 = 0.1;
const VELOCITY: f64 = 2.0;
const ACCELERATION: f64 = 10.0;
const TORQUE: f64 = 10.0;

/// Given torques of links and motors, and their accelerations.
#[derive(Clone, Debug, Default)]
struct Forward {
    tau_link: Vec<f64>,
    tau_motor: Vec<f64>,
    ddq: Vec<f64>,
    ddphi: Vec<f64>,
}

/// A state and the numbers of the identified model.
#[derive(Clone, Debug, Default)]
pub(super) struct Vector {
    q: Vec<f64>,
    dq: Vec<f64>,
    ddq: Vec<f64>,
    phi: Vec<f64>,
    dphi: Vec<f64>,
    ddphi: Vec<f64>,
    gravity: Vec<f64>,
    coriolis: Vec<f64>,
    mass: Vec<f64>,
    /// Torques of inverse dynamics.
    link: Vec<f64>,
    motor: Vec<f64>,
    forward: Forward,
    /// Regressor of the equations, row by row.
    regressor: Vec<f64>,
}

impl Vector {
    /// Returns all arrays, in the order of the self-tests.
    pub(super) fn all(&self) -> [&[f64]; 15] {
        [
            &self.q,
            &self.dq,
            &self.ddq,
            &self.phi,
            &self.dphi,
            &self.ddphi,
            &self.gravity,
            &self.coriolis,
            &self.mass,
            &self.link,
            &self.motor,
            &self.forward.tau_link,
            &self.forward.tau_motor,
            &self.forward.ddq,
            &self.forward.ddphi,
        ]
    }

    fn draw(source: &Source<'_>, random: &mut ChaCha8Rng) -> Self {
        let joints = source.robot.links.chain.joints();
        let n = joints.len();
        let mut some =
            |size: f64| -> Vec<f64> { (0..n).map(|_| random.random_range(-size..size)).collect() };
        let [mut q, deflection] = [some(1.0), some(DEFLECTION)];
        for (q, joint) in q.iter_mut().zip(joints) {
            if joint.kind == JointKind::Revolute {
                *q *= std::f64::consts::PI;
            }
        }
        let mut vector = Self {
            phi: (q.iter().zip(deflection)).map(|(q, e)| q + e).collect(),
            q,
            dq: some(VELOCITY),
            dphi: some(VELOCITY),
            ddq: some(ACCELERATION),
            ddphi: some(ACCELERATION),
            forward: Forward {
                tau_link: some(TORQUE),
                tau_motor: some(TORQUE),
                ..Forward::default()
            },
            ..Self::default()
        };
        for i in (0..n).filter(|i| source.robot.motor_rows[*i].is_none()) {
            (vector.phi[i], vector.dphi[i], vector.ddphi[i]) =
                (vector.q[i], vector.dq[i], vector.ddq[i]);
        }
        vector
    }

    /// Computes the numbers of the identified model.
    fn compute(&mut self, source: &Source<'_>) -> Result<(), LengthError> {
        let robot = &source.robot;
        let (n, rows) = (robot.joints(), robot.rows());
        let parameters = Values {
            theta: source.theta,
            bodies: source.bodies,
        };
        let mut steps = vec![Step::default(); n];
        let zeros = vec![0.0; n];
        self.gravity = vec![0.0; n];
        robot.link_torque(
            &parameters,
            &self.q,
            &zeros,
            &zeros,
            &mut steps,
            &mut self.gravity,
        )?;
        let chain = robot.links.chain;
        let weightless = Chain::checked(chain.joints(), [0.0; 3], chain.motions());
        self.coriolis = vec![0.0; n];
        inverse_dynamics(
            &weightless,
            source.bodies,
            &self.q,
            &self.dq,
            &zeros,
            &mut steps,
            &mut self.coriolis,
        )?;
        let motion = [
            &self.q,
            &self.dq,
            &self.ddq,
            &self.phi,
            &self.dphi,
            &self.ddphi,
        ];
        let torques = required(robot, &parameters, motion.map(Vec::as_slice))?;
        let is_motor = |i: usize| robot.motor_rows[i].is_some();
        let of_link = |i: usize| if is_motor(i) { torques[i] } else { 0.0 };
        self.link = (0..n).map(of_link).collect();
        self.motor = (0..n).map(|i| torques[robot.motor_coordinate(i)]).collect();

        let mut scratch = Scratch::new(n);
        let mut all = vec![0.0; rows * rows];
        robot.mass_matrix(&parameters, &self.q, &mut scratch.workspace(), &mut all)?;
        self.mass = (0..n * n).map(|at| all[at / n * rows + at % n]).collect();
        let mut torque = vec![0.0; rows];
        let given = Torques {
            motor: &self.forward.tau_motor,
            link: Some(&self.forward.tau_link),
        };
        robot.coordinate_torques(&given, &mut torque)?;
        let mut accelerations = vec![0.0; rows];
        robot.acceleration(
            &parameters,
            &self.state(),
            &torque,
            &mut scratch.workspace(),
            &mut accelerations,
        )?;
        self.forward.ddq = accelerations[..n].to_vec();
        self.forward.ddphi = (0..n)
            .map(|i| accelerations[robot.motor_coordinate(i)])
            .collect();
        self.compute_regressor(source)
    }

    fn state(&self) -> State<'_> {
        state([&self.q, &self.dq, &self.phi, &self.dphi])
    }

    fn compute_regressor(&mut self, source: &Source<'_>) -> Result<(), LengthError> {
        let (robot, model) = (&source.robot, source.model);
        let (n, rows, width) = (robot.joints(), robot.rows(), source.theta.len());
        let mut accelerations = vec![0.0; rows];
        accelerations[..n].copy_from_slice(&self.ddq);
        for i in 0..n {
            accelerations[robot.motor_coordinate(i)] = self.ddphi[i];
        }
        let mut entries = vec![0.0; robot.entries];
        let mut scratch = Scratch::new(n);
        let mut workspace = scratch.workspace();
        robot.torque_entries(&self.state(), &accelerations, &mut workspace, &mut entries)?;
        self.regressor = vec![0.0; rows * width];
        for row in 0..rows {
            let row_entries = &entries[model.equation_entries(row)];
            for (entry, column) in row_entries.iter().zip(model.equation_columns(row)) {
                self.regressor[row * width + column] = *entry;
            }
        }
        Ok(())
    }

    /// Returns the outputs of a function at this state.
    fn run(&self, traced: &Traced, still: bool) -> Vec<f64> {
        let zeros = vec![0.0; self.q.len()];
        let inputs: Vec<f64> = (traced.inputs.iter())
            .flat_map(|array| match array.name {
                Q => &self.q,
                DQ => &self.dq,
                PHI => &self.phi,
                DPHI => &self.dphi,
                DDQ if !still => &self.ddq,
                DDPHI if !still => &self.ddphi,
                _ => &zeros,
            })
            .copied()
            .collect();
        values(&traced.operations, &traced.results, &inputs)
    }
}

/// Returns the largest differences of functions from the identified model at random states, and the
/// states of the self-test.
///
/// # Errors
///
/// [`LengthError`] if the parameters do not fit the robot.
pub(super) fn prove(
    source: &Source<'_>,
    all: &[Traced],
) -> Result<(Proof, Vec<Vector>), LengthError> {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut proof = Proof {
        states: STATES,
        inverse_dynamics: 0.0,
        mass_matrix: 0.0,
        accelerations: 0.0,
    };
    let mut in_test = Vec::new();
    for _ in 0..STATES {
        let mut vector = Vector::draw(source, &mut random);
        vector.compute(source)?;
        compare(source, all, &vector, &mut proof);
        if in_test.len() < IN_TEST {
            in_test.push(vector);
        }
    }
    Ok((proof, in_test))
}

fn compare(source: &Source<'_>, all: &[Traced], vector: &Vector, proof: &mut Proof) {
    let n = vector.q.len();
    let of = |name: &str, still: bool| {
        let found = all.iter().find(|traced| traced.name == name);
        found.map_or_else(Vec::new, |traced| vector.run(traced, still))
    };
    let masses = of("mass_matrix", false);
    let known = [vector.link.as_slice(), &vector.motor].concat();
    worst(
        &mut proof.inverse_dynamics,
        &known,
        &of("inverse_dynamics", false),
    );
    let regressor = of(REGRESSOR, false);
    let (width, is_flexible) = (source.theta.len(), |i: &usize| {
        source.robot.motor_rows[*i].is_some()
    });
    let mut products = Vec::new();
    for (known, found) in vector.regressor.chunks(width).zip(regressor.chunks(width)) {
        worst(&mut proof.inverse_dynamics, known, found);
        products.push(
            found
                .iter()
                .zip(source.theta)
                .map(|(entry, value)| entry * value)
                .sum(),
        );
    }
    let motors = (0..n).filter(is_flexible).map(|i| vector.motor[i]);
    let links = (0..n).map(|i| {
        if is_flexible(&i) {
            vector.link[i]
        } else {
            vector.motor[i]
        }
    });
    let rows: Vec<f64> = links.chain(motors).collect();
    worst(&mut proof.inverse_dynamics, &rows, &products);
    // The parts together are the whole.
    let [gravity, coriolis, spring, friction] =
        ["gravity", "coriolis", "spring", "friction"].map(|name| of(name, false));
    let is_rigid = |i: usize| source.robot.motor_rows[i].is_none();
    let whole: Vec<f64> = (0..n)
        .map(|i| vector.link[i] + if is_rigid(i) { vector.motor[i] } else { 0.0 })
        .collect();
    let parts: Vec<f64> = (0..n)
        .map(|i| {
            let moved: f64 = (0..n).map(|k| masses[i * n + k] * vector.ddq[k]).sum();
            let motor = if is_rigid(i) { friction[n + i] } else { 0.0 };
            moved + gravity[i] + coriolis[i] - spring[i] + friction[i] + motor
        })
        .collect();
    worst(&mut proof.inverse_dynamics, &whole, &parts);
    worst(&mut proof.mass_matrix, &vector.mass, &masses);

    // Forward dynamics, as the code computes it.
    let still = of("inverse_dynamics", true);
    let left = |i: usize| vector.forward.tau_motor[i] - still[n + i];
    let mut ddq: Vec<f64> = (0..n)
        .map(|i| vector.forward.tau_link[i] - still[i] + if is_rigid(i) { left(i) } else { 0.0 })
        .collect();
    let mut factors = masses;
    if factor(&mut factors, n) {
        solve(&factors, &mut ddq);
    } else {
        ddq.fill(f64::NAN);
    }
    let rotors = source.rotors();
    let ddphi: Vec<f64> = (0..n)
        .map(|i| {
            if is_rigid(i) {
                ddq[i]
            } else {
                left(i) / rotors[i]
            }
        })
        .collect();
    worst(&mut proof.accelerations, &vector.forward.ddq, &ddq);
    worst(&mut proof.accelerations, &vector.forward.ddphi, &ddphi);
}
