//! Least squares of many logs of one robot by map and reduce.

use super::error::SessionError;
use super::load::Session;
use sprung_base::progress::Listener;
use sprung_log::LogSource;
use sprung_method::estimate::{
    Choices, Identified, LogFactors, choices, factors, identify_factors,
};
use sprung_robot::Task;

/// Identifies one robot from any number of logs, which any number of machines reduce.
///
/// [`choices`](Self::choices) reads the beginning of the first log. [`factors`](Self::factors) reduces
/// one log with these choices; it is the map, and each log may be reduced on another machine.
/// [`LogFactors::merge`] is the reduce, and [`identify_factors`](Self::identify_factors) gives the
/// parameters. They are those of [`identify`](Self::identify) with least squares and all logs. A result
/// of factors has no frequency responses and no estimated payloads, its curves have fewer points, and the
/// promised errors and residuals come from these points.
impl Session {
    /// Makes the choices that hold for all logs of the robot, from the first log that the experiment
    /// names.
    ///
    /// # Errors
    ///
    /// The errors of [`identify`](Self::identify).
    pub fn choices(&self, progress: &mut dyn Listener) -> Result<Choices, SessionError> {
        let mut logs = self.logs(None)?;
        self.choices_with(first_log(logs.sources())?, progress)
    }

    /// Makes the choices from another log with the same columns.
    ///
    /// # Errors
    ///
    /// The errors of [`identify`](Self::identify).
    pub fn choices_with(
        &self,
        first: LogSource<'_>,
        progress: &mut dyn Listener,
    ) -> Result<Choices, SessionError> {
        self.allow(Task::SeveralMachines)?;
        Ok(choices(self.experiment(), self.model(), first, progress)?)
    }

    /// Reduces one of the logs that the experiment names.
    ///
    /// - `index`: its place in the list, from 0.
    ///
    /// # Errors
    ///
    /// [`SessionError`] if there is no such log, if it cannot be read, or if the choices are those of
    /// another experiment.
    pub fn factors(
        &self,
        choices: &Choices,
        index: usize,
        progress: &mut dyn Listener,
    ) -> Result<LogFactors, SessionError> {
        let mut logs = self.logs(None)?;
        let mut sources = logs.sources();
        if index >= sources.len() {
            return Err(SessionError::NoSuchLog {
                index,
                count: sources.len(),
            });
        }
        let source = sources.swap_remove(index);
        let files = (self.experiment().log.iter()).flat_map(|log| log.file.iter().flatten());
        let log = (index, files.map(ToString::to_string).nth(index));
        Ok(factors(self.experiment(), choices, log, source, progress)?)
    }

    /// Reduces another log with the same columns.
    ///
    /// - `order`: its number among all logs of the robot. Merged logs are in the order of their numbers.
    ///
    /// # Errors
    ///
    /// The errors of [`factors`](Self::factors).
    pub fn factors_with(
        &self,
        choices: &Choices,
        (order, log): (usize, LogSource<'_>),
        progress: &mut dyn Listener,
    ) -> Result<LogFactors, SessionError> {
        let experiment = self.experiment();
        Ok(factors(experiment, choices, (order, None), log, progress)?)
    }

    /// Identifies the parameters from the merged factors of all logs.
    ///
    /// The beginning of the first log is read again.
    ///
    /// # Errors
    ///
    /// The errors of [`identify`](Self::identify), and [`SessionError`] if the factors are those of
    /// another robot, experiment, version or first log.
    pub fn identify_factors(
        &self,
        factors: &LogFactors,
        progress: &mut dyn Listener,
    ) -> Result<Identified, SessionError> {
        let mut logs = self.logs(None)?;
        self.identify_factors_with(first_log(logs.sources())?, factors, progress)
    }

    /// Identifies the parameters from merged factors, with choices from another log.
    ///
    /// - `first`: the log that was given to [`choices_with`](Self::choices_with).
    ///
    /// # Errors
    ///
    /// The errors of [`identify_factors`](Self::identify_factors).
    pub fn identify_factors_with(
        &self,
        first: LogSource<'_>,
        factors: &LogFactors,
        progress: &mut dyn Listener,
    ) -> Result<Identified, SessionError> {
        self.allow(Task::SeveralMachines)?;
        let (experiment, model) = (self.experiment(), self.model());
        Ok(identify_factors(
            experiment, model, first, factors, progress,
        )?)
    }
}

/// Returns the first log for the parameters of the robot.
fn first_log(sources: Vec<LogSource<'_>>) -> Result<LogSource<'_>, SessionError> {
    let mut logs = sources.into_iter().filter(|log| !log.has_unknown_payload());
    logs.next().ok_or(SessionError::NoLogFile)
}
