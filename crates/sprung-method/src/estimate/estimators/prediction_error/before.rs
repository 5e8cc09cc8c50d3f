//! Inputs of a refinement.

use super::retiming::Timing;
use crate::description::Experiment;
use crate::estimate::estimators::least_squares::PossibleFit;
use crate::finding::Finding;
use crate::fit::Fitted;
use crate::prepare::Excerpt;
use crate::regression::System;

/// Inputs of a refinement.
#[derive(Clone, Copy)]
pub(in crate::estimate) struct Before<'a> {
    pub(in crate::estimate) experiment: &'a Experiment,
    /// The beginning of the first log.
    pub(in crate::estimate) excerpt: &'a Excerpt,
    pub(in crate::estimate) system: &'a System,
    pub(in crate::estimate) fitted: &'a Fitted,
    /// Least squares over the robots that can exist; `None` without constraints.
    pub(in crate::estimate) possible: Option<&'a PossibleFit<'a>>,
    /// Start values instead of the fitted ones, \[p\].
    pub(in crate::estimate) nominal: Option<&'a [f64]>,
    pub(in crate::estimate) timing: Timing<'a>,
    /// Findings about the logs. If a log is faulty, the refinement is skipped, because it may take
    /// minutes to fail.
    pub(in crate::estimate) about_logs: &'a [Finding],
    /// What the errors of estimated gains add to the standard error of each parameter, \[p\].
    pub(in crate::estimate) by_gains: &'a [f64],
}
