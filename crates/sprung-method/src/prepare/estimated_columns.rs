//! Estimated signs and gains of columns, and the side of the torque constants.

use crate::description::Side;

/// An estimated sign of a column.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundSign {
    /// Name of the column.
    pub column: String,
    /// 1 or -1.
    pub value: f64,
    /// Logarithm of the likelihood ratio between this sign and the opposite sign.
    pub log_likelihood: f64,
    /// Reason for the sign, in words.
    pub because: String,
}

/// An estimated gain of a column.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundGain {
    /// Name of the column.
    pub column: String,
    /// Factor of the column's readings.
    pub value: f64,
    /// Standard error of the value.
    pub standard_error: f64,
}

/// What the errors of unknowns that were applied add to the standard error of a parameter.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Doubt {
    /// Of all unknowns.
    pub(crate) by_all: f64,
    /// Of the gains, which no estimator estimates again.
    pub(crate) by_gains: f64,
}

/// The side of the gearbox for which the torque constants hold, found from the motion.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundSide {
    /// The side.
    pub side: Side,
    /// Name of a column to which it applies.
    pub column: String,
    /// Reason for the side, in words.
    pub because: String,
}
