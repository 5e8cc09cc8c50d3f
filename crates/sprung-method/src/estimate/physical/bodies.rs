//! Possible bodies of an estimate, before they are written.

use crate::estimate::result::{PhysicalResult, StandardParameter};
use crate::finding::Finding;
use crate::model::Theta;

/// Possible bodies of an estimate.
pub(in crate::estimate) struct Bodies {
    /// Theta of the possible bodies with possible drives, \[p\].
    pub(in crate::estimate) theta: Option<Theta>,
    pub(in crate::estimate) standard: Vec<StandardParameter>,
    pub(in crate::estimate) result: Option<PhysicalResult>,
    pub(in crate::estimate) findings: Vec<Finding>,
}
