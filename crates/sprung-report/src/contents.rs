//! Contents of a report.

use std::collections::BTreeMap;

use crate::curves::Curves;
use crate::estimate::Identification;
use crate::validate::Validation;

/// Contents of a report.
#[derive(Clone, Copy, Debug, Default)]
pub struct Contents<'a> {
    /// The identification.
    pub identification: Option<&'a Identification>,
    /// Every parameter over time.
    pub trace: Option<&'a Curves>,
    /// Filtered right-hand sides over time.
    pub fit: Option<&'a Curves>,
    /// The validation and its signals.
    pub validation: Option<(&'a Validation, &'a Curves)>,
    /// True parameters of a simulated robot, by name.
    pub truth: Option<&'a BTreeMap<String, f64>>,
    /// The command that made the report.
    pub command: &'a str,
    /// The experiment file.
    pub experiment: &'a str,
}
