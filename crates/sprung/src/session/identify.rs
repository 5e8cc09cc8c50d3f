//! Identifies parameters from logs.

use super::error::SessionError;
use super::load::Session;
use crate::estimate::{Identified, identify};
use crate::log::LogSource;
use crate::progress::Listener;

impl Session {
    /// Identifies the parameters from the logs that the experiment names.
    ///
    /// # Errors
    ///
    /// [`SessionError`] if the description or a log is wrong, or if they contradict each other. A
    /// poor fit is a result, not an error.
    pub fn identify(&self, progress: &mut dyn Listener) -> Result<Identified, SessionError> {
        let mut logs = self.logs(None)?;
        self.identify_with(&mut logs.sources(), progress)
    }

    /// Identifies the parameters from other logs with the same columns.
    ///
    /// # Errors
    ///
    /// The errors of [`identify`](Self::identify).
    pub fn identify_with(
        &self,
        sources: &mut [LogSource<'_>],
        progress: &mut dyn Listener,
    ) -> Result<Identified, SessionError> {
        Ok(identify(
            self.experiment(),
            self.model(),
            sources,
            progress,
        )?)
    }
}
