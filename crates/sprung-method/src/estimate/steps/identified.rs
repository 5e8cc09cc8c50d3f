//! The result of an identification.

use crate::curves::Curves;
use crate::estimate::result::Identification;

/// Result of an identification.
#[derive(Clone, Debug)]
pub struct Identified {
    /// The results.
    pub identification: Identification,
    /// Every parameter over time, one set of curves per estimator.
    pub trace: Curves,
    /// Filtered right-hand sides: the measured ones and those predicted with each estimate.
    pub fit: Curves,
}
