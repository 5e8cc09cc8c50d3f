//! Checks logs before any fit.

use super::error::SessionError;
use super::load::Session;
use sprung_base::progress::Listener;
use sprung_log::LogSource;
use sprung_method::check::{Checked, check};
use sprung_robot::Task;

impl Session {
    /// Checks the logs that the experiment names.
    ///
    /// # Errors
    ///
    /// [`SessionError`] if a log cannot be read or its description is wrong. A faulty log is not an
    /// error: the report contains findings about it.
    pub fn check(&self, progress: &mut dyn Listener) -> Result<Checked, SessionError> {
        let mut logs = self.logs(None)?;
        self.check_with(&mut logs.sources(), progress)
    }

    /// Checks other logs with the same columns.
    ///
    /// # Errors
    ///
    /// The errors of [`check`](Self::check).
    pub fn check_with(
        &self,
        sources: &mut [LogSource<'_>],
        progress: &mut dyn Listener,
    ) -> Result<Checked, SessionError> {
        self.no_servo(Task::Check)?;
        let (experiment, model) = (self.experiment(), self.model());
        let mut checked = check(experiment, model, sources, progress)?;
        self.check_design(sources, &mut checked)?;
        self.complete(&mut checked.report.findings);
        Ok(checked)
    }
}
