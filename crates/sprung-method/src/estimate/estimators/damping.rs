//! Damping of the steps of a least-squares search.

use crate::estimate::statistics::ROUNDING;

/// Damping of the first step. If the model matches, all searches converge from it without a failed step.
const FIRST: f64 = 1e-3;

/// Growth after a failed step. Marquardt recommends a factor of about 10.
const GROWTH: f64 = 8.0;

/// Decrease after a successful step. Marquardt recommends a factor of about 10.
const DECREASE: f64 = 10.0;

/// Steps that are tried. The last of them is at most a hundredth of a Gauss-Newton step, so a cost that does not
/// decrease is at its minimum up to rounding.
pub(super) const MAX_TRIES: usize = 8;

/// Damping μ of a step: `(A + μ diag A) Δz = −g`.
///
/// # Source
///
/// Marquardt, An algorithm for least-squares estimation of nonlinear parameters, SIAM Journal 11 (1963).
#[derive(Clone, Copy, Debug)]
pub(super) struct Damping(f64);

impl Damping {
    /// Returns the damping of the first step.
    pub(super) fn first() -> Self {
        Self(FIRST)
    }

    /// Returns its value, relative to the diagonal of the information.
    pub(super) fn value(self) -> f64 {
        self.0
    }

    /// Grows after a step that did not decrease the cost. A damping far below that of the first step would repeat
    /// the step.
    pub(super) fn failed(&mut self) {
        self.0 = f64::max(GROWTH * self.0, FIRST / DECREASE);
    }

    /// Decreases after a step that decreased the cost.
    pub(super) fn succeeded(&mut self) {
        self.0 = f64::max(self.0 / DECREASE, ROUNDING);
    }
}
