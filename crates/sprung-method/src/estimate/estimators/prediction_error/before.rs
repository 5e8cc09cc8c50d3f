//! Inputs of a refinement.

use super::retiming::Timing;
use super::rung::Rung;
use crate::description::Experiment;
use crate::estimate::estimators::least_squares::PossibleFit;
use crate::finding::Finding;
use crate::fit::Fitted;
use crate::prepare::Excerpt;
use crate::regression::{Reading, System};

/// Inputs of a refinement.
#[derive(Clone, Copy)]
pub(in crate::estimate) struct Before<'a> {
    pub(in crate::estimate) experiment: &'a Experiment,
    /// The beginning of the first log.
    pub(in crate::estimate) excerpt: &'a Excerpt,
    pub(in crate::estimate) system: &'a System,
    /// The search that the refinement belongs to, if it is one for a late channel.
    pub(in crate::estimate) search: Option<DelaySearch<'a>>,
    pub(in crate::estimate) fitted: &'a Fitted,
    /// Least squares over the robots that can exist; `None` without constraints.
    pub(in crate::estimate) possible: Option<&'a PossibleFit<'a>>,
    /// Start values instead of the fitted ones, \[p\].
    pub(in crate::estimate) nominal: Option<&'a [f64]>,
    pub(in crate::estimate) timing: Timing<'a>,
    /// Findings about the logs. If a log is faulty, the refinement is skipped, because it may take
    /// minutes to fail.
    pub(in crate::estimate) about_logs: &'a [Finding],
}

/// A search for a late channel, whose delay may end far from its start.
#[derive(Clone, Copy)]
pub(in crate::estimate) struct DelaySearch<'a> {
    /// The samples of the system.
    pub(in crate::estimate) samples: &'a Excerpt,
    /// Number of rungs of the ladder to try.
    pub(in crate::estimate) rungs: usize,
}

impl Before<'_> {
    /// Returns the system with the delays at the end of a refinement, s; `None` if `system` has them.
    pub(super) fn reduced_again(&self, reading: &Reading, delays: &[f64]) -> Option<System> {
        let search = self.search.filter(|_| reading.delays() != delays)?;
        search.samples.reduce(&reading.with_delays(delays))
    }

    /// Returns the number of rungs to try.
    pub(super) fn rungs(&self) -> usize {
        self.search
            .map_or(Rung::ALL.len(), |search| search.rungs.min(Rung::ALL.len()))
    }
}
