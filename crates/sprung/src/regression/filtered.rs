//! The filtered regressor, sample by sample.

use sprung_core::filter::{Discretization, FilterError, FilterPair, FilterState};
use sprung_core::regressor::{ENTRIES, JointState, PlanarArm, ROW_COLUMNS};

use crate::description::DiscretizationName;
use crate::model::{JOINT_COUNT, ROWS, Theta};

/// One sample of the filtered regression `Y_f theta = rhs_f`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilteredSample {
    /// Time, s.
    pub time: f64,
    /// Entries of `Y_f` that can differ from zero, row after row.
    pub entries: [f64; ENTRIES],
    /// Filtered right-hand side: zero for links, torque for motors, N·m.
    pub rhs: [f64; ROWS],
}

impl FilteredSample {
    /// Returns each row's entries, in the order of the model's row columns.
    pub fn rows(&self) -> impl Iterator<Item = (&'static [usize], &[f64], f64)> {
        let mut entries = &self.entries[..];
        ROW_COLUMNS.iter().zip(self.rhs).map(move |(columns, rhs)| {
            let (row, rest) = entries.split_at(columns.len());
            entries = rest;
            (*columns, row, rhs)
        })
    }

    /// Returns `Y_f theta`, \[2n\], N·m.
    #[must_use]
    pub fn predicted(&self, theta: &Theta) -> [f64; ROWS] {
        let mut all = [0.0; ROWS];
        for (value, (columns, row, _)) in all.iter_mut().zip(self.rows()) {
            *value = columns
                .iter()
                .zip(row)
                .map(|(&c, entry)| theta[c] * entry)
                .sum();
        }
        all
    }
}

/// Forms the regressor of each sample and filters it.
///
/// # Source
///
/// Eqs. (10) and (23). The paper's discretisation holds every signal; the
/// matched one takes the torque as held, which a digital controller does, and
/// everything else as continuous.
#[derive(Clone, Debug)]
pub struct FilteredRegression {
    arm: PlanarArm,
    pair: FilterPair,
    torque_pair: FilterPair,
    entries: [FilterState; ENTRIES],
    torques: [FilterState; JOINT_COUNT],
}

impl FilteredRegression {
    /// Returns the regression of a log that starts at rest.
    ///
    /// - `cutoff`: λ, rad/s; `period`: T, s.
    ///
    /// # Errors
    ///
    /// [`FilterError`] if λ or T is not positive.
    pub fn new(
        arm: &PlanarArm,
        cutoff: f64,
        period: f64,
        discretization: DiscretizationName,
    ) -> Result<Self, FilterError> {
        let held = FilterPair::new(cutoff, period, Discretization::ZeroOrderHold)?;
        let pair = match discretization {
            DiscretizationName::Matched => FilterPair::new(cutoff, period, Discretization::Tustin)?,
            DiscretizationName::Paper => held,
        };
        Ok(Self {
            arm: *arm,
            pair,
            torque_pair: held,
            entries: [FilterState::default(); ENTRIES],
            torques: [FilterState::default(); JOINT_COUNT],
        })
    }

    /// Takes the next sample.
    pub fn process(
        &mut self,
        time: f64,
        state: &JointState,
        tau: &[f64; JOINT_COUNT],
    ) -> FilteredSample {
        let regressor = self.arm.regressor(state);
        let mut sample = FilteredSample {
            time,
            entries: [0.0; ENTRIES],
            rhs: [0.0; ROWS],
        };
        for ((value, entry), memory) in
            (sample.entries.iter_mut().zip(&regressor)).zip(&mut self.entries)
        {
            *value = self.pair.process(memory, entry.momentum, entry.rest);
        }
        for ((value, tau), memory) in
            (sample.rhs[JOINT_COUNT..].iter_mut().zip(tau)).zip(&mut self.torques)
        {
            *value = self.torque_pair.process(memory, 0.0, *tau);
        }
        sample
    }
}
