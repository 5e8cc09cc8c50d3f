//! The equations of one robot with values, and their derivatives, one state at a time.

use sprung_core::drives::State;
use sprung_core::linearized::{Derivatives, Partial, Partials};
use sprung_core::links::{JointScratch, PairScratch, Step, Workspace, numbers_len};
use sprung_core::parameters::JointParameter;
use sprung_core::pull::Gradient;
use sprung_core::robot::Values;
use sprung_core::scalar::Scalar;
use sprung_core::spatial::BODY;

use crate::model::{Model, Scratch, Theta};

/// Positions, velocities and accelerations of links, then of motors, \[n\] each.
#[derive(Clone, Debug)]
pub(super) struct MotionAt {
    pub(super) link: [Vec<f64>; 3],
    pub(super) motor: [Vec<f64>; 3],
}

impl MotionAt {
    pub(super) fn zero(joints: usize) -> Self {
        let zeros = || std::array::from_fn(|_| vec![0.0; joints]);
        Self {
            link: zeros(),
            motor: zeros(),
        }
    }

    pub(super) fn clear(&mut self) {
        for values in self.link.iter_mut().chain(&mut self.motor) {
            values.fill(0.0);
        }
    }

    fn state(&self) -> State<'_> {
        State {
            q: &self.link[0],
            dq: &self.link[1],
            phi: &self.motor[0],
            dphi: &self.motor[1],
            excess: &[],
            elements: &[],
        }
    }
}

/// Work memory for numbers with derivatives.
#[derive(Clone, Debug)]
struct DualScratch {
    joints: Vec<JointScratch<Partial>>,
    steps: Vec<Step<Partial>>,
    pairs: Vec<PairScratch<Partial>>,
    numbers: Vec<Partial>,
}

impl DualScratch {
    fn new(joints: usize) -> Self {
        Self {
            joints: vec![JointScratch::default(); joints],
            steps: vec![Step::default(); joints],
            pairs: vec![PairScratch::default(); joints * joints],
            numbers: vec![Partial::ZERO; numbers_len(joints)],
        }
    }

    fn workspace(&mut self) -> Workspace<'_, Partial> {
        Workspace {
            joints: &mut self.joints,
            steps: &mut self.steps,
            pairs: &mut self.pairs,
            numbers: &mut self.numbers,
        }
    }
}

/// A robot with values and work memory.
#[derive(Clone, Debug)]
pub(super) struct Physics {
    pub(super) model: Model,
    pub(super) theta: Theta,
    bodies: Vec<[f64; BODY]>,
    scratch: Scratch,
    dual: DualScratch,
    partials: [Vec<Partial>; 4],
    accelerations: Vec<f64>,
    weights: Vec<f64>,
    /// Stiffness of each joint; `None` for a rigid joint.
    pub(super) stiffness: Vec<Option<f64>>,
    /// Entries of inertial parameters, with row and column.
    inertial: Vec<(usize, usize, usize)>,
    pub(super) by_position: Vec<f64>,
    pub(super) by_velocity: Vec<f64>,
    pub(super) inverse: Vec<f64>,
    pub(super) rate: Vec<f64>,
}

impl Physics {
    pub(super) fn new(model: &Model, theta: &[f64]) -> Self {
        let (n, rows) = (model.joint_count(), model.coordinates());
        let mut inertial = Vec::new();
        for row in 0..n {
            let columns = model.equation_columns(row).iter();
            for (entry, &column) in model.equation_entries(row).zip(columns) {
                if model.parameters()[column].joint.is_none() {
                    inertial.push((entry, row, column));
                }
            }
        }
        let stiffness = |joint: usize| {
            let index = model.index(JointParameter::Stiffness, joint)?;
            model.is_flexible(joint).then(|| theta[index])
        };
        Self {
            bodies: model.bodies(theta),
            theta: theta.to_vec(),
            scratch: Scratch::new(n),
            dual: DualScratch::new(n),
            partials: std::array::from_fn(|_| vec![Partial::ZERO; n]),
            accelerations: vec![0.0; rows],
            weights: vec![0.0; model.robot().entries],
            stiffness: (0..n).map(stiffness).collect(),
            inertial,
            by_position: vec![0.0; rows * rows],
            by_velocity: vec![0.0; rows * rows],
            inverse: vec![0.0; rows * rows],
            rate: vec![0.0; rows],
            model: model.clone(),
        }
    }

    fn accelerations(&mut self, at: &MotionAt) {
        let n = at.link[2].len();
        self.accelerations[..n].copy_from_slice(&at.link[2]);
        for joint in 0..n {
            let row = self.model.torque_row(joint);
            if row >= n {
                self.accelerations[row] = at.motor[2][joint];
            }
        }
    }

    /// Writes the entries of the regressor of a motion.
    pub(super) fn entries(&mut self, at: &MotionAt, out: &mut [f64]) {
        self.accelerations(at);
        let mut workspace = self.scratch.workspace();
        let robot = self.model.robot();
        let computed = robot.torque_entries(&at.state(), &self.accelerations, &mut workspace, out);
        if computed.is_err() {
            out.fill(f64::NAN);
        }
    }

    /// Adds the gradient of weighted entries by the motion.
    pub(super) fn pull(
        &mut self,
        at: &MotionAt,
        weights: impl Iterator<Item = f64>,
        out: &mut MotionAt,
    ) {
        for (target, weight) in self.weights.iter_mut().zip(weights) {
            *target = weight;
        }
        self.pull_weights(at, out);
    }

    fn pull_weights(&mut self, at: &MotionAt, out: &mut MotionAt) {
        self.accelerations(at);
        let mut workspace = self.dual.workspace();
        let [q, dq, ddq, _] = &mut self.partials;
        let MotionAt { link, motor } = out;
        let mut gradient = Gradient {
            link: link.each_mut().map(Vec::as_mut_slice),
            motor: motor.each_mut().map(Vec::as_mut_slice),
        };
        let computed = self.model.robot().pull(
            &at.state(),
            &self.accelerations,
            &mut self.weights,
            &mut workspace,
            [q, dq, ddq],
            &mut gradient,
        );
        if computed.is_err() {
            out.link[0].fill(f64::NAN);
        }
    }

    /// Writes the deflections with which springs carry the links without friction.
    ///
    /// - `entries`: of the regressor at the motion of the links.
    pub(super) fn deflections(&self, entries: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        for &(entry, row, column) in &self.inertial {
            if let Some(stiffness) = self.stiffness[row] {
                out[row] += entries[entry] * self.theta[column] / stiffness;
            }
        }
    }

    /// Adds the gradient of weighted deflections by the motion of the links.
    pub(super) fn pull_deflections(&mut self, at: &MotionAt, by: &[f64], out: &mut MotionAt) {
        self.weights.fill(0.0);
        for &(entry, row, column) in &self.inertial {
            if let Some(stiffness) = self.stiffness[row] {
                self.weights[entry] = by[row] * self.theta[column] / stiffness;
            }
        }
        self.pull_weights(at, out);
    }

    /// Writes the accelerations of all coordinates to `rate`.
    pub(super) fn accelerate(&mut self, at: &MotionAt, torque: &[f64]) {
        let values = Values {
            theta: &self.theta,
            bodies: &self.bodies,
        };
        let robot = self.model.robot();
        let mut workspace = self.scratch.workspace();
        let state = at.state();
        let fits = robot.acceleration(&values, &state, torque, &mut workspace, &mut self.rate);
        if fits.is_err() {
            self.rate.fill(f64::NAN);
        }
    }

    /// Writes the accelerations, the inverse of the mass matrix and the derivatives by the state.
    pub(super) fn differentiate(&mut self, at: &MotionAt, torque: &[f64]) {
        let values = Values {
            theta: &self.theta,
            bodies: &self.bodies,
        };
        let robot = self.model.robot();
        let mut workspace = self.scratch.workspace();
        let state = at.state();
        let [q, dq, ddq, tau] = &mut self.partials;
        let mut partials = Partials {
            numbers: [q, dq, ddq, tau],
            steps: &mut self.dual.steps,
        };
        let (rate, inverse) = (&mut self.rate, &mut self.inverse);
        let moved = robot.motion(&values, &state, torque, &mut workspace, rate, inverse);
        let mut out = Derivatives {
            by_position: &mut self.by_position,
            by_velocity: &mut self.by_velocity,
        };
        let fits = moved.and_then(|()| {
            robot.derivatives(
                &values,
                &state,
                &self.rate,
                &self.inverse,
                &mut workspace,
                &mut partials,
                &mut out,
            )
        });
        if fits.is_err() {
            self.rate.fill(f64::NAN);
        }
    }
}
