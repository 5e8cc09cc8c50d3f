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

/// Forms the regressor of one sample.
#[derive(Clone, Debug)]
pub(super) struct Evaluator {
    pub(super) model: Model,
    scratch: Scratch,
    // Whether to form the entries of the links.
    links: bool,
}

impl Evaluator {
    pub(super) fn new(model: &Model) -> Self {
        Self {
            model: model.clone(),
            scratch: Scratch::new(model.joint_count()),
            links: true,
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
    pub(super) fn entries(&mut self, state: &State<'_>, momentum: &mut [f64], rest: &mut [f64]) {
        let mut workspace = self.scratch.workspace();
        let robot = self.model.robot();
        // The buffers have the model's sizes, so no error is expected here.
        let written = if self.links {
            robot.regressor(state, &mut workspace, momentum, rest)
        } else {
            robot.drives(state, &mut workspace, momentum, rest)
        };
        if written.is_err() {
            momentum.fill(f64::NAN);
        }
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
    rhs: Vec<f64>,
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
            rhs: vec![0.0; model.joint_count()],
        })
    }

    /// Resets the filters: the next sample begins a log.
    pub fn restart(&mut self) {
        self.bank.restart();
        self.torques.fill(FilterState::default());
    }

    /// Processes the next sample; returns the entries of `Y_f`, row after row, and the filtered
    /// motor torques, \[n\], N·m (N).
    pub fn process(&mut self, state: &State<'_>, tau: &[f64]) -> (&[f64], &[f64]) {
        self.evaluator
            .entries(state, &mut self.momentum, &mut self.rest);
        let entries = (self.bank).process(&self.pairs.entries, &self.momentum, &self.rest);
        for ((rhs, memory), tau) in self.rhs.iter_mut().zip(&mut self.torques).zip(tau) {
            *rhs = self.pairs.torque.process(memory, 0.0, *tau);
        }
        (entries, &self.rhs)
    }
}
