//! Accelerations of a robot at one instant, and their derivatives.

use sprung_core::drives::State;
use sprung_core::friction::Scale;
use sprung_core::linearized::{Derivatives, Partial, Partials};
use sprung_core::links::Step;
use sprung_core::robot::Values;
use sprung_core::scalar::Scalar;
use sprung_core::spatial::BODY;

use crate::model::{Model, Scratch, Theta};

/// The value of a scale of a joint's friction laws.
#[derive(Clone, Copy, Debug)]
pub(in crate::estimate::estimators::prediction_error) struct ScaleOfJoint {
    pub(in crate::estimate::estimators::prediction_error) joint: usize,
    pub(in crate::estimate::estimators::prediction_error) scale: Scale,
    pub(in crate::estimate::estimators::prediction_error) value: f64,
}

/// A robot with its parameters and work memory.
#[derive(Clone, Debug)]
pub(in crate::estimate::estimators::prediction_error) struct Dynamics {
    pub(super) model: Model,
    pub(super) theta: Theta,
    bodies: Vec<[f64; BODY]>,
    n: usize,
    pub(super) rows: usize,
    pub(super) motors: Vec<usize>,
    scratch: Scratch,
    // q, dq, phi, dphi.
    joints: Vec<f64>,
    pub(super) known: Known,
    /// Rate of the torque within a period, N·m/s (N/s), \[rows\]; empty if the torque is held.
    pub(super) ramp: Vec<f64>,
    pub(super) rate: Vec<f64>,
    pub(super) inverse: Vec<f64>,
    pub(super) slopes: Slopes,
    pub(super) regressor: Regressor,
    pub(super) within: WithinStep,
}

/// What friction depends on beside the state.
#[derive(Clone, Debug, Default)]
pub(super) struct Known {
    /// Covariates minus their references, \[n × covariates\]; empty if no friction depends on any.
    pub(super) excess: Vec<f64>,
    /// Elements of presliding friction and hysteresis, \[n × elements\]; empty if no joint has any.
    elements: Vec<f64>,
}

/// Derivatives of the accelerations by the state, and their work memory.
#[derive(Clone, Debug)]
pub(super) struct Slopes {
    pub(super) by_position: Vec<f64>,
    pub(super) by_velocity: Vec<f64>,
    partials: [Vec<Partial>; 4],
    steps: Vec<Step<Partial>>,
}

/// The entries of the regressor.
#[derive(Clone, Debug)]
pub(super) struct Regressor {
    pub(super) entries: Vec<f64>,
    /// Changes of the entries when the motion changes.
    pub(super) changes: Vec<f64>,
    /// Row of each entry, and its column of theta.
    pub(super) rows: Vec<usize>,
    pub(super) columns: Vec<usize>,
}

/// State within an integration step, and the sum of the rates.
#[derive(Clone, Debug)]
pub(super) struct WithinStep {
    pub(super) at: Vec<f64>,
    pub(super) sum: Vec<f64>,
}

impl Regressor {
    fn new(model: &Model) -> Self {
        let count = model.robot().entries;
        let mut all = Self {
            entries: vec![0.0; count],
            changes: Vec::new(),
            rows: vec![0; count],
            columns: vec![0; count],
        };
        for row in 0..model.robot().rows() {
            let columns = model.equation_columns(row).iter();
            for (entry, &column) in model.equation_entries(row).zip(columns) {
                all.columns[entry] = column;
                all.rows[entry] = row;
            }
        }
        all
    }
}

impl Dynamics {
    pub(in crate::estimate::estimators::prediction_error) fn new(
        model: &Model,
        theta: &[f64],
    ) -> Self {
        let robot = model.robot();
        let (n, rows) = (robot.joints(), robot.rows());
        Self {
            model: model.clone(),
            bodies: model.bodies(theta),
            theta: theta.to_vec(),
            n,
            rows,
            motors: (0..n).map(|joint| robot.motor_coordinate(joint)).collect(),
            scratch: Scratch::new(n),
            joints: vec![0.0; 4 * n],
            known: Known::default(),
            ramp: Vec::new(),
            inverse: vec![0.0; rows * rows],
            rate: vec![0.0; rows],
            slopes: Slopes {
                by_position: vec![0.0; rows * rows],
                by_velocity: vec![0.0; rows * rows],
                partials: std::array::from_fn(|_| vec![Partial::ZERO; n]),
                steps: vec![Step::default(); n],
            },
            regressor: Regressor::new(model),
            within: WithinStep {
                at: vec![0.0; 2 * rows],
                sum: vec![0.0; 2 * rows],
            },
        }
    }

    pub(in crate::estimate::estimators::prediction_error) fn rows(&self) -> usize {
        self.rows
    }

    /// Replaces the parameters.
    ///
    /// - `scales`: those that change.
    pub(in crate::estimate::estimators::prediction_error) fn set(
        &mut self,
        theta: &[f64],
        scales: impl IntoIterator<Item = ScaleOfJoint>,
    ) {
        self.theta.copy_from_slice(theta);
        self.bodies = self.model.bodies(theta);
        for of in scales {
            self.model.set_scale(of.joint, of.scale, of.value);
        }
    }

    /// Adds a payload to the parameters until they are replaced.
    ///
    /// - `change`: of the parameters, \[p\]; `None` without a payload.
    pub(in crate::estimate::estimators::prediction_error) fn carry(
        &mut self,
        change: Option<&[f64]>,
    ) {
        let Some(change) = change else {
            return;
        };
        for (value, by) in self.theta.iter_mut().zip(change) {
            *value += by;
        }
        self.bodies = self.model.bodies(&self.theta);
    }

    /// Replaces the rate of the torque within a period, N·m/s (N/s).
    pub(in crate::estimate::estimators::prediction_error) fn set_ramp(
        &mut self,
        ramp: impl Iterator<Item = f64>,
    ) {
        self.ramp.clear();
        self.ramp.extend(ramp);
    }

    /// Replaces what friction depends on beside the state: the covariates of the joints minus their references,
    /// \[n × covariates\], and the elements of presliding friction, \[n × elements\]. Both are empty if no friction depends
    /// on any.
    pub(in crate::estimate::estimators::prediction_error) fn set_known(
        &mut self,
        [excess, elements]: [&[f64]; 2],
    ) {
        self.known.excess.clear();
        self.known.excess.extend_from_slice(excess);
        self.known.elements.clear();
        self.known.elements.extend_from_slice(elements);
    }

    pub(super) fn unpack(&mut self, x: &[f64]) {
        let (positions, velocities) = x.split_at(self.rows);
        let n = self.n;
        self.joints[..n].copy_from_slice(&positions[..n]);
        self.joints[n..2 * n].copy_from_slice(&velocities[..n]);
        for (joint, &motor) in self.motors.iter().enumerate() {
            self.joints[2 * n + joint] = positions[motor];
            self.joints[3 * n + joint] = velocities[motor];
        }
    }

    /// Writes the accelerations at a state.
    pub(super) fn accelerate(&mut self, x: &[f64], torque: &[f64]) {
        self.unpack(x);
        let state = state(&self.joints, self.n, &self.known);
        let values = Values {
            theta: &self.theta,
            bodies: &self.bodies,
        };
        let robot = self.model.robot();
        let mut workspace = self.scratch.workspace();
        let fits = robot.acceleration(&values, &state, torque, &mut workspace, &mut self.rate);
        if fits.is_err() {
            // The work memory has the right size, so this branch is unreachable.
            self.rate.fill(f64::NAN);
        }
    }

    /// Writes the accelerations at a state and the inverse of the mass matrix.
    pub(super) fn accelerate_and_invert(&mut self, x: &[f64], torque: &[f64]) {
        self.unpack(x);
        let state = state(&self.joints, self.n, &self.known);
        let values = Values {
            theta: &self.theta,
            bodies: &self.bodies,
        };
        let robot = self.model.robot();
        let mut workspace = self.scratch.workspace();
        let (rate, inverse) = (&mut self.rate, &mut self.inverse);
        let fits = robot.motion(&values, &state, torque, &mut workspace, rate, inverse);
        if fits.is_err() {
            // The work memory has the right size, so this branch is unreachable.
            self.rate.fill(f64::NAN);
        }
    }

    /// Writes the accelerations at a state, their derivatives by the state, and the regressor's
    /// entries.
    pub(super) fn differentiate(&mut self, x: &[f64], torque: &[f64]) {
        self.accelerate_and_invert(x, torque);
        let state = state(&self.joints, self.n, &self.known);
        let values = Values {
            theta: &self.theta,
            bodies: &self.bodies,
        };
        let robot = self.model.robot();
        let mut workspace = self.scratch.workspace();
        let slopes = &mut self.slopes;
        let [q, dq, ddq, tau] = &mut slopes.partials;
        let mut partials = Partials {
            numbers: [q, dq, ddq, tau],
            steps: &mut slopes.steps,
        };
        let mut out = Derivatives {
            by_position: &mut slopes.by_position,
            by_velocity: &mut slopes.by_velocity,
        };
        let fits = robot.derivatives(
            &values,
            &state,
            &self.rate,
            &self.inverse,
            &mut workspace,
            &mut partials,
            &mut out,
        );
        if fits.is_err() {
            self.rate.fill(f64::NAN);
        }
        self.write_entries();
    }

    /// Writes the entries of the regressor at the state unpacked last.
    pub(super) fn write_entries(&mut self) {
        let state = state(&self.joints, self.n, &self.known);
        let mut workspace = self.scratch.workspace();
        let robot = self.model.robot();
        let entries = &mut self.regressor.entries;
        let fits = robot.torque_entries(&state, &self.rate, &mut workspace, entries);
        if fits.is_err() {
            entries.fill(f64::NAN);
        }
    }
}

impl Dynamics {
    /// Visits the derivatives of the torques by the logarithm of a scale of a joint's friction laws, at
    /// the state unpacked last. The arguments of `visit` are the row and the derivative, N·m (N).
    pub(super) fn visit_bent_torques(
        &self,
        (joint, scale): (usize, Scale),
        mut visit: impl FnMut(usize, f64),
    ) {
        let robot = self.model.robot();
        let drive = robot.drive(&state(&self.joints, self.n, &self.known), joint);
        for term in robot.terms.iter().filter(|term| term.joint == joint) {
            let by_log = term.by_log(scale, &drive, &robot.shapes[joint]);
            if by_log != 0.0 {
                visit(term.row, self.theta[term.column] * by_log);
            }
        }
    }
}

/// Returns positions and velocities of links and motors, each \[n\], with covariates and elements of presliding friction and hysteresis.
fn state<'s>(joints: &'s [f64], n: usize, known: &'s Known) -> State<'s> {
    let (link, motor) = joints.split_at(2 * n);
    State {
        q: &link[..n],
        dq: &link[n..],
        phi: &motor[..n],
        dphi: &motor[n..],
        excess: &known.excess,
        elements: &known.elements,
    }
}
