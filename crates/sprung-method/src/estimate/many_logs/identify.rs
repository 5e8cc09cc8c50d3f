//! The steps of an identification by map and reduce.

use super::choices::{Choices, for_factors};
use super::factors::{LogFactors, OneLog};
use crate::description::{Experiment, Feature, Task, refuse};
use crate::estimate::errors::{FactorsError, IdentifyError};
use crate::estimate::estimators::prediction_error::Timing;
use crate::estimate::identify::conclude;
use crate::estimate::steps::{Identified, Logs, Ready, make_ready, reduce};
use crate::log::LogSource;
use crate::model::Model;
use crate::progress::Listener;
use crate::stopwatch::Stopwatch;

/// Makes the choices that hold for all logs of a robot from the beginning of its first log.
///
/// They are those of an identification by least squares, for any estimators of the experiment.
///
/// # Errors
///
/// The errors of [`identify`](crate::estimate::identify).
pub fn choices(
    experiment: &Experiment,
    model: &Model,
    first: LogSource<'_>,
    progress: &mut dyn Listener,
) -> Result<Choices, IdentifyError> {
    let ready = ready_for_factors(experiment, model, first, progress)?;
    Ok(Choices::new(experiment, &ready))
}

/// Prepares the first log for least squares.
fn ready_for_factors(
    experiment: &Experiment,
    model: &Model,
    first: LogSource<'_>,
    progress: &mut dyn Listener,
) -> Result<Ready, IdentifyError> {
    make_ready(&for_factors(experiment), model, &mut [first], progress)
}

/// Reduces one log.
///
/// - `(order, name)`: its number in the order of all logs, and its name in results; `None` for that of
///   the source.
///
/// # Errors
///
/// [`IdentifyError`] if the log cannot be read or does not fit the filters, or if the choices are those
/// of another experiment.
pub fn factors(
    experiment: &Experiment,
    choices: &Choices,
    (order, name): (usize, Option<String>),
    log: LogSource<'_>,
    progress: &mut dyn Listener,
) -> Result<LogFactors, IdentifyError> {
    let label = log.label();
    if log.has_unknown_payload() {
        refuse(Feature::UnknownPayload, &label, Task::SeveralMachines)
            .map_err(FactorsError::from)?;
    }
    let reading = choices.reading(experiment)?;
    let names = [name.unwrap_or(label)];
    let read = reduce(&reading, (&mut [log], &names), &mut (), progress)?;
    let one = OneLog::new(order, read).ok_or(FactorsError::None)?;
    Ok(LogFactors::new(choices, one))
}

/// Identifies the parameters by least squares from the factors of all logs.
///
/// - `first`: the log from which the choices were made; its beginning is read again.
///
/// # Errors
///
/// [`IdentifyError`] as for [`identify`](crate::estimate::identify), or if the factors are those of
/// another experiment, version or first log.
pub fn identify_factors(
    experiment: &Experiment,
    model: &Model,
    first: LogSource<'_>,
    factors: &LogFactors,
    progress: &mut dyn Listener,
) -> Result<Identified, IdentifyError> {
    let clock = Stopwatch::start();
    let ready = ready_for_factors(experiment, model, first, progress)?;
    factors.check(experiment, &Choices::new(experiment, &ready))?;
    let read = factors.read(ready.prepared.reading().model())?;
    // Least squares needs the logs no more.
    let mut logs = Logs::new(&mut []);
    conclude(
        &ready,
        &read,
        &mut logs,
        (&clock, Timing::Kept),
        progress,
        &mut |_| (),
    )
}
