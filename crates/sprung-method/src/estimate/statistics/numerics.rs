//! Numbers of all searches and solutions of equations.

/// Relative size of a difference that is rounding. Rounding of a solution is 1e-16 times a condition number, which
/// is below 1e6 where the log determines the parameters, so it is smaller; every standard error is larger.
pub(in crate::estimate) const ROUNDING: f64 = 1e-9;

/// Iterations after which a search ends without a result. A search that arrives needs less than half of them.
pub(in crate::estimate) const MAX_ITERATIONS: usize = 30;

/// Iterations of a search inside another one, which calls it again.
pub(in crate::estimate) const MAX_ROUNDS: usize = 6;

/// Added to the diagonal of scaled normal equations, so that a direction that the log does not determine has a solution.
/// Rounding is 1e-16 and adds up over the unknowns; every determined direction has more.
pub(in crate::estimate) const RIDGE: f64 = 1e-13;
