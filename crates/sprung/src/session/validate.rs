//! Validates parameters on other logs.

use super::error::SessionError;
use super::load::Session;
use super::logs::Logs;
use super::parameters::Parameters;
use sprung_base::progress::Listener;
use sprung_log::LogSource;
use sprung_method::validate::{Validated, validate};
use sprung_robot::{Feature, Task, refuse};

impl Session {
    /// Validates parameters on the logs of the experiment's `[[validate]]` runs.
    ///
    /// If the parameters come from an identification, its delays, the timing of its torques, its signs, gains and cut-off
    /// are used where the description leaves them open.
    ///
    /// # Errors
    ///
    /// [`SessionError`] if a description or a log is wrong. A diverging loop gives a finding.
    pub fn validate(
        &self,
        parameters: &Parameters,
        progress: &mut dyn Listener,
    ) -> Result<Validated, SessionError> {
        self.allow_validation()?;
        let mut logs = (self.experiment().validate.iter())
            .map(|run| self.logs(run.log.as_ref()))
            .collect::<Result<Vec<Logs<'_>>, SessionError>>()?;
        let mut sources: Vec<Vec<LogSource<'_>>> = logs.iter_mut().map(Logs::sources).collect();
        self.validate_with(parameters, &mut sources, progress)
    }

    /// Validates parameters on other logs, one list of logs per `[[validate]]` run.
    ///
    /// # Errors
    ///
    /// The errors of [`validate`](Self::validate).
    pub fn validate_with(
        &self,
        parameters: &Parameters,
        sources: &mut [Vec<LogSource<'_>>],
        progress: &mut dyn Listener,
    ) -> Result<Validated, SessionError> {
        for source in sources
            .iter()
            .flatten()
            .filter(|source| source.has_unknown_payload())
        {
            refuse(Feature::UnknownPayload, &source.label(), Task::Validate)?;
        }
        let (mut experiment, model) = self.described_by(parameters)?;
        if let Some(found) = &parameters.identification {
            found.log.settle(&mut experiment);
        }
        let sets = &parameters.sets;
        let mut validated = validate(
            &experiment,
            &model,
            sets,
            &parameters.chosen(),
            sources,
            progress,
        )?;
        for run in &mut validated.validation.runs {
            self.complete(&mut run.findings);
        }
        Ok(validated)
    }
}
