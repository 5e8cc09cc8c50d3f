//! Samples with the elements of presliding friction and hysteresis.

use sprung_core::covariate::Covariate;
use sprung_core::drives::State;

use crate::model::Model;
use crate::preprocess::SignalBlock;

/// A segment with the elements of presliding friction and hysteresis.
pub(super) struct Sliding<'a> {
    pub(super) signals: &'a SignalBlock,
    /// \[samples × n × elements\]; empty if no joint has any.
    elements: Vec<f64>,
}

impl<'a> Sliding<'a> {
    pub(super) fn new(model: &Model, signals: &'a SignalBlock) -> Self {
        Self {
            elements: signals.elements(&mut model.elements()),
            signals,
        }
    }

    /// Returns positions, velocities, covariates and elements of one sample.
    pub(super) fn state_at(&self, k: usize) -> Vec<f64> {
        let signals = self.signals;
        let n = signals.q.len();
        let mut state = Vec::with_capacity((4 + Covariate::COUNT) * n);
        for columns in [&signals.q, &signals.dq, &signals.phi, &signals.dphi] {
            state.extend(columns.iter().map(|column| column[k]));
        }
        let excess = signals.excess.iter();
        state.extend(excess.map(|column| column.get(k).copied().unwrap_or_default()));
        let per_sample = self.elements.len() / signals.len();
        state.extend_from_slice(&self.elements[k * per_sample..(k + 1) * per_sample]);
        state
    }
}

/// Returns the parts of a state as [`Sliding::state_at`] has it.
pub(super) fn state_of(state: &[f64], n: usize) -> State<'_> {
    let (link, behind) = state.split_at(2 * n);
    let (excess, elements) = behind[2 * n..].split_at(n * Covariate::COUNT);
    State {
        q: &link[..n],
        dq: &link[n..],
        phi: &behind[..n],
        dphi: &behind[n..2 * n],
        excess,
        elements,
    }
}
