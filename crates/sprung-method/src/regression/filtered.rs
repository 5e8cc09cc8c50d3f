//! The filtered regressor, one sample at a time.

use sprung_core::drives::State;
use sprung_core::filter::bank_len;
use sprung_core::filter::{Discretization, FilterBank, FilterError, FilterPair, FilterState};

use crate::description::DiscretizationName;
use crate::model::{Model, Scratch};

/// The filter pair of the regressor's entries and that of the torque.
///
/// # Source
///
/// Eqs. (10) and (23). The paper's discretisation holds every signal. The matched discretisation
/// holds only the torque, because a digital controller holds it, and treats all other signals as
/// continuous.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pairs {
    pub(super) entries: FilterPair,
    pub(super) torque: FilterPair,
    /// T, s.
    pub(super) period: f64,
}

impl Pairs {
    /// - `cutoff`: λ, rad/s; `period`: T, s.
    pub(super) fn new(
        cutoff: f64,
        period: f64,
        discretization: DiscretizationName,
    ) -> Result<Self, FilterError> {
        let torque = FilterPair::new(cutoff, period, Discretization::ZeroOrderHold)?;
        let entries = match discretization {
            DiscretizationName::Matched => FilterPair::new(cutoff, period, Discretization::Tustin)?,
            DiscretizationName::Paper => torque,
        };
        Ok(Self {
            entries,
            torque,
            period,
        })
    }
}

/// Relative step of a stiffness for its derivative. It moves a link by a hundredth of the deflection.
const STIFFNESS_STEP: f64 = 0.01;

/// Forms the regressor of one sample.
#[derive(Clone, Debug)]
pub(super) struct Evaluator {
    pub(super) model: Model,
    scratch: Scratch,
    // Whether to form the entries of the links.
    links: bool,
    // Joints whose link position follows from the torque of the spring, and buffers for the entries of
    // their stiffnesses.
    without_link: Vec<usize>,
    moved: [Vec<f64>; 4],
    // Link rows of joints with accelerometer, and a buffer for their entries.
    accelerated: Vec<usize>,
    torques: Vec<f64>,
}

impl Evaluator {
    pub(super) fn new(model: &Model) -> Self {
        Self {
            model: model.clone(),
            scratch: Scratch::new(model.joint_count()),
            links: true,
            without_link: model.joints_without_link(),
            moved: Default::default(),
            accelerated: model.joints_with_acceleration(),
            torques: Vec::new(),
        }
    }

    /// Returns an evaluator for the given rows; it skips the links' entries if no row contains
    /// them.
    pub(super) fn of_rows(model: &Model, rows: &[usize]) -> Self {
        Self {
            links: rows.iter().any(|row| *row < model.joint_count()),
            ..Self::new(model)
        }
    }

    /// Writes the entries of `Y_a` to `momentum` and those of `Y_b` to `rest`.
    ///
    /// - `acceleration`: of the links, \[n\], rad/s² (m/s²); empty if it is not measured.
    pub(super) fn entries(
        &mut self,
        state: &State<'_>,
        acceleration: &[f64],
        momentum: &mut [f64],
        rest: &mut [f64],
    ) {
        let mut workspace = self.scratch.workspace();
        let robot = self.model.regressor();
        // The buffers have the model's sizes, so no error is expected here.
        let written = if self.links {
            robot.regressor(state, &mut workspace, momentum, rest)
        } else {
            robot.drives(state, &mut workspace, momentum, rest)
        };
        if written.is_err() {
            momentum.fill(f64::NAN);
        }
        if self.links && !self.without_link.is_empty() {
            self.deflections(state, momentum, rest);
        }
        if self.links && !self.accelerated.is_empty() && !acceleration.is_empty() {
            self.by_acceleration(state, acceleration, momentum, rest);
        }
    }

    /// Writes the rows of joints with accelerometer: torques by the measured accelerations, and no momenta. The
    /// velocity by an accelerometer lacks slow changes of the deflection, the acceleration does not.
    fn by_acceleration(
        &mut self,
        state: &State<'_>,
        acceleration: &[f64],
        momentum: &mut [f64],
        rest: &mut [f64],
    ) {
        let mut all = acceleration.to_vec();
        // The rows of links do not contain the accelerations of motors.
        all.resize(self.model.coordinates(), 0.0);
        self.torques.resize(rest.len(), 0.0);
        let mut workspace = self.scratch.workspace();
        let robot = self.model.regressor();
        let written = robot.torque_entries(state, &all, &mut workspace, &mut self.torques);
        if written.is_err() {
            self.torques.fill(f64::NAN);
        }
        for &joint in &self.accelerated {
            let range = self.model.row_entries(joint);
            momentum[range.clone()].fill(0.0);
            rest[range.clone()].copy_from_slice(&self.torques[range]);
        }
    }

    /// Writes the entries of the stiffnesses that place links without encoder: the derivatives of the
    /// rows' momenta and torques by each stiffness, as differences.
    fn deflections(&mut self, state: &State<'_>, momentum: &mut [f64], rest: &mut [f64]) {
        for deflection in self.model.deflection_entries() {
            (momentum[deflection.entry], rest[deflection.entry]) = (0.0, 0.0);
        }
        let Some(theta) = self.model.springs().cloned() else {
            return;
        };
        let before = self.row_sums(&theta, momentum, rest);
        let [mut q, mut dq, mut moved, mut moved_rest] = std::mem::take(&mut self.moved);
        moved.resize(momentum.len(), 0.0);
        moved_rest.resize(rest.len(), 0.0);
        for &joint in &self.without_link {
            let Some(stiffness) = self.model.known_stiffness(joint) else {
                continue;
            };
            // A stiffness that is larger by this share moves the link by the same share of the
            // deflection towards the motor.
            q.clear();
            q.extend_from_slice(state.q);
            q[joint] += STIFFNESS_STEP * (state.phi[joint] - state.q[joint]);
            dq.clear();
            dq.extend_from_slice(state.dq);
            dq[joint] += STIFFNESS_STEP * (state.dphi[joint] - state.dq[joint]);
            let state = State {
                q: &q,
                dq: &dq,
                ..*state
            };
            let mut workspace = self.scratch.workspace();
            let robot = self.model.regressor();
            let written = robot.regressor(&state, &mut workspace, &mut moved, &mut moved_rest);
            if written.is_err() {
                moved.fill(f64::NAN);
            }
            let after = self.row_sums(&theta, &moved, &moved_rest);
            let step = STIFFNESS_STEP * stiffness;
            for deflection in self.model.deflection_entries() {
                if deflection.joint == joint {
                    momentum[deflection.entry] =
                        (after[deflection.row][0] - before[deflection.row][0]) / step;
                    rest[deflection.entry] =
                        (after[deflection.row][1] - before[deflection.row][1]) / step;
                }
            }
        }
        self.moved = [q, dq, moved, moved_rest];
    }

    /// Returns momentum and torque of each joint's row without the entries of
    /// [`Evaluator::deflections`].
    fn row_sums(&self, theta: &[f64], momentum: &[f64], rest: &[f64]) -> Vec<[f64; 2]> {
        let count = self.without_link.len();
        (0..self.model.joint_count())
            .map(|row| {
                let entries = self.model.row_entries(row);
                let range = entries.start..entries.end - count;
                let columns = self.model.row_columns(row);
                let product = |all: &[f64]| -> f64 {
                    (all[range.clone()].iter().zip(columns))
                        .map(|(entry, &column)| entry * theta[column])
                        .sum()
                };
                [product(momentum), product(rest)]
            })
            .collect()
    }
}

/// Forms and filters the regressor, one sample at a time.
#[derive(Clone, Debug)]
pub struct FilteredRegression {
    evaluator: Evaluator,
    pairs: Pairs,
    momentum: Vec<f64>,
    rest: Vec<f64>,
    bank: FilterBank<Vec<f64>>,
    torques: Vec<FilterState>,
    springs: Vec<FilterState>,
    // Torques of the motors, and of the springs.
    rhs: [Vec<f64>; 2],
}

impl FilteredRegression {
    /// Returns the regression at the start of a log.
    ///
    /// - `cutoff`: λ, rad/s; `period`: T, s.
    ///
    /// # Errors
    ///
    /// [`FilterError`] if λ or T is not positive.
    pub fn new(
        model: &Model,
        cutoff: f64,
        period: f64,
        discretization: DiscretizationName,
    ) -> Result<Self, FilterError> {
        let entries = model.entries();
        Ok(Self {
            evaluator: Evaluator::new(model),
            pairs: Pairs::new(cutoff, period, discretization)?,
            momentum: vec![0.0; entries],
            rest: vec![0.0; entries],
            bank: FilterBank::new(vec![0.0; bank_len(entries)]),
            torques: vec![FilterState::default(); model.joint_count()],
            springs: vec![FilterState::default(); model.joint_count()],
            rhs: [
                vec![0.0; model.joint_count()],
                vec![0.0; model.joint_count()],
            ],
        })
    }

    /// Resets the filters: the next sample begins a log.
    pub fn restart(&mut self) {
        self.bank.restart();
        self.torques.fill(FilterState::default());
        self.springs.fill(FilterState::default());
    }

    /// Processes the next sample; returns the entries of `Y_f`, row after row, and the filtered
    /// torques of motors and springs, each \[n\], N·m (N).
    ///
    /// - `tau`: torques of the motors, \[n\], N·m (N); `spring`: measured torques of the springs,
    ///   \[n\], N·m (N), of any value without torque sensor.
    pub fn process(
        &mut self,
        state: &State<'_>,
        tau: &[f64],
        spring: &[f64],
    ) -> (&[f64], [&[f64]; 2]) {
        self.evaluator
            .entries(state, &[], &mut self.momentum, &mut self.rest);
        let entries = (self.bank).process(&self.pairs.entries, &self.momentum, &self.rest);
        let [of_motors, of_springs] = &mut self.rhs;
        for ((rhs, memory), tau) in of_motors.iter_mut().zip(&mut self.torques).zip(tau) {
            *rhs = self.pairs.torque.process(memory, 0.0, *tau);
        }
        for ((rhs, memory), spring) in of_springs.iter_mut().zip(&mut self.springs).zip(spring) {
            *rhs = self.pairs.entries.process(memory, 0.0, *spring);
        }
        (entries, [of_motors, of_springs])
    }
}
