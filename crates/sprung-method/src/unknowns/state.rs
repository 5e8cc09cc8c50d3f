//! What a search for unknowns has applied.

/// What is applied.
#[derive(Clone, Debug, Default)]
pub(super) struct State {
    pub(super) chosen: Vec<usize>,
    /// Size of each unknown; of laws the coefficient.
    pub(super) sizes: Vec<f64>,
    pub(super) errors: Vec<f64>,
    pub(super) gains: Vec<f64>,
    pub(super) theta: Vec<f64>,
    /// What the errors of delays add to the standard error of each free parameter; empty without delays.
    pub(super) doubt: Vec<f64>,
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
