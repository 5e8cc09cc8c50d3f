//! Identifies parameters from logs.

use super::error::SessionError;
use super::load::Session;
use sprung_base::finding::Finding;
use sprung_base::progress::Listener;
use sprung_log::LogSource;
use sprung_method::estimate::{Identified, IdentifyError, identify_and_tell};
use sprung_robot::{Estimator, Task};

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

    /// Identifies the parameters from the logs that the experiment names, and returns the result of
    /// least squares before a refinement begins, because a refinement may take minutes.
    ///
    /// - `first`: receives the result of least squares. It is not called if no refinement is
    ///   requested.
    ///
    /// # Errors
    ///
    /// The errors of [`identify`](Self::identify).
    pub fn identify_and_tell(
        &self,
        progress: &mut dyn Listener,
        first: &mut dyn FnMut(&Identified),
    ) -> Result<Identified, SessionError> {
        let mut logs = self.logs(None)?;
        self.run_identify(&mut logs.sources(), progress, first)
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
        self.run_identify(sources, progress, &mut |_| ())
    }

    fn run_identify(
        &self,
        sources: &mut [LogSource<'_>],
        progress: &mut dyn Listener,
        first: &mut dyn FnMut(&Identified),
    ) -> Result<Identified, SessionError> {
        self.no_servo(Task::Identify(Estimator::LeastSquares))?;
        let (experiment, model) = (self.experiment(), self.model());
        let mut first = |found: &Identified| match &self.earlier_laws[..] {
            [] => first(found),
            _ => first(&self.with_earlier_laws(found.clone())),
        };
        let mut found = identify_and_tell(experiment, model, sources, progress, &mut first)
            .map_err(|mut error| {
                if let IdentifyError::Refused(refusal) = &mut error {
                    self.complete(&mut refusal.0);
                }
                error
            })?;
        self.complete(&mut found.identification.findings);
        for result in &mut found.identification.results {
            self.complete(&mut result.warnings);
        }
        self.with_design(self.with_earlier_laws(found))
    }

    /// Completes the lines that findings propose by those of the experiment.
    pub(super) fn complete(&self, findings: &mut [Finding]) {
        for finding in findings {
            finding.complete(|setting| self.experiment().completed(setting));
        }
    }

    /// Adds the laws of earlier identifications, which the model has, to the results.
    fn with_earlier_laws(&self, mut found: Identified) -> Identified {
        if self.earlier_laws.is_empty() {
            return found;
        }
        let identification = &mut found.identification;
        let earlier = self.earlier_laws.iter().cloned();
        let found_now = std::mem::take(&mut identification.unknowns);
        identification.unknowns = earlier.chain(found_now).collect();
        found
    }
}
