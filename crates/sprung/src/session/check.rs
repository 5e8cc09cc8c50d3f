//! What is wrong with a log, before any fit.

use super::error::SessionError;
use super::load::Session;
use crate::check::{Checked, check};
use crate::estimate::late_channels;
use crate::log::LogSource;
use crate::progress::Listener;

/// How much a check may cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Depth {
    /// One pass over the logs.
    #[default]
    OnePass,
    /// Besides, delays to a fraction of a sample by the likelihood of the log, which takes as long
    /// as a few identifications. Of a log that is refused no likelihood says anything.
    Likelihood,
}

impl Session {
    /// Checks the logs that the experiment names.
    ///
    /// # Errors
    ///
    /// [`SessionError`] if they cannot be read or their description is wrong. A log that is wrong
    /// is a report.
    pub fn check(
        &self,
        depth: Depth,
        progress: &mut dyn Listener,
    ) -> Result<Checked, SessionError> {
        let mut logs = self.logs(None)?;
        self.check_with(&mut logs.sources(), depth, progress)
    }

    /// Checks other logs of the same columns.
    ///
    /// # Errors
    ///
    /// [`SessionError`] likewise.
    pub fn check_with(
        &self,
        sources: &mut [LogSource<'_>],
        depth: Depth,
        progress: &mut dyn Listener,
    ) -> Result<Checked, SessionError> {
        let (experiment, model) = (self.experiment(), self.model());
        let mut checked = check(experiment, model, sources, progress)?;
        if depth == Depth::Likelihood && !checked.report.refused {
            checked.with_delays(&late_channels(experiment, model, sources, progress)?);
        }
        Ok(checked)
    }
}
