//! The motion that a reference causes, and the adjoint: from derivatives by the motion to those by the reference.

use super::followed::Followed;
use super::motion::{ByMotion, Moved};
use super::simulated::Simulated;

/// How a robot follows its reference.
#[derive(Clone, Debug)]
pub(super) enum Follows {
    /// The links follow the reference.
    Exactly(Followed),
    /// A PD controller of the motors closes the loop.
    Loop(Simulated),
}

impl Follows {
    /// Returns the motion of a reference; `None` if it runs away.
    ///
    /// - `coefficients`: of the series, \[n × (1 + 2 harmonics)\].
    pub(super) fn run(&mut self, coefficients: &[Vec<f64>]) -> Option<Moved> {
        match self {
            Self::Exactly(followed) => Some(followed.run(coefficients)),
            Self::Loop(simulated) => simulated.run(coefficients),
        }
    }

    /// Returns the derivatives by the coefficients.
    pub(super) fn pull(&mut self, moved: &Moved, by: ByMotion) -> Vec<Vec<f64>> {
        match self {
            Self::Exactly(followed) => followed.pull(moved, by),
            Self::Loop(simulated) => simulated.pull(moved, &by),
        }
    }
}
