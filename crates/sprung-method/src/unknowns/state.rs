//! What a search for unknowns has applied.

use crate::prepare::Doubt;

/// What is applied.
#[derive(Clone, Debug, Default)]
pub(super) struct State {
    pub(super) chosen: Vec<usize>,
    /// Size of each unknown; of laws the coefficient.
    pub(super) sizes: Vec<f64>,
    pub(super) errors: Vec<f64>,
    pub(super) gains: Vec<f64>,
    pub(super) theta: Vec<f64>,
    /// Of each free parameter; empty without delays, and without gains that are asked for.
    pub(super) doubt: Vec<Doubt>,
}

impl State {
    /// Returns the start of a search: nothing is applied.
    pub(super) fn new(unknowns: usize) -> Self {
        Self {
            sizes: vec![0.0; unknowns],
            errors: vec![0.0; unknowns],
            gains: vec![0.0; unknowns],
            ..Self::default()
        }
    }
}
