//! Logs in, parameters out.

use super::error::SessionError;
use super::load::Session;
use crate::estimate::{Identified, identify};
use crate::log::LogSource;
use crate::progress::Listener;

impl Session {
    /// Identifies from the logs that the experiment names.
    ///
    /// # Errors
    ///
    /// [`SessionError`] if the description, a log or both together are wrong. A poor fit is a
    /// result.
    pub fn identify(&self, progress: &mut dyn Listener) -> Result<Identified, SessionError> {
        let mut logs = self.logs(None)?;
        self.identify_with(&mut logs.sources(), progress)
    }

    /// Identifies from other logs of the same columns.
    ///
    /// # Errors
    ///
    /// [`SessionError`] likewise.
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
