//! The steps of an identification by map and reduce.

use super::choices::{Choices, for_factors};
use super::error::FactorsError;
use super::factors::{LogFactors, OneLog};
use crate::check::OfLog;
use crate::description::{Estimator, Experiment};
use crate::estimate::about_logs::LogInfo;
use crate::estimate::error::IdentifyError;
use crate::estimate::estimators::Basis;
use crate::estimate::identify::{
    Identified, all_about_logs, describe_all, fit_all, prepare_to_estimate, with_chosen_laws,
};
use crate::estimate::inputs::EstimatorInputs;
use crate::estimate::laws::Chosen;
use crate::estimate::least_squares::least_squares;
use crate::frequency::Record;
use crate::log::LogSource;
use crate::model::Model;
use crate::prepare::Prepared;
use crate::progress::{Listener, Phase};
use crate::regression::{StoredSystem, read_through};
use crate::stopwatch::Stopwatch;

/// Makes the choices that hold for all logs of a robot from the beginning of its first log.
///
/// They are those of an identification by least squares, whichever estimators the experiment names.
///
/// # Errors
///
/// The errors of [`identify`](crate::estimate::identify).
pub(crate) fn choices(
    experiment: &Experiment,
    model: &Model,
    first: LogSource<'_>,
    progress: &mut dyn Listener,
) -> Result<Choices, IdentifyError> {
    let (prepared, chosen) = prepared(experiment, model, first, progress)?;
    let laws = chosen.as_ref().map(|chosen| &chosen.result);
    Ok(Choices::new(experiment, &prepared, laws))
}

/// Prepares the first log for least squares.
fn prepared(
    experiment: &Experiment,
    model: &Model,
    first: LogSource<'_>,
    progress: &mut dyn Listener,
) -> Result<(Prepared, Option<Chosen>), IdentifyError> {
    let (described, mut sources) = (for_factors(experiment), [first]);
    let prepared = prepare_to_estimate(&described, model, &mut sources, progress)?;
    with_chosen_laws(prepared, &mut sources, progress)
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
pub(crate) fn factors(
    experiment: &Experiment,
    choices: &Choices,
    (order, name): (usize, Option<String>),
    log: LogSource<'_>,
    progress: &mut dyn Listener,
) -> Result<LogFactors, IdentifyError> {
    let label = log.label();
    if log.has_unknown_payload() {
        return Err(FactorsError::UnknownPayload { log: label }.into());
    }
    let reading = choices.reading(experiment)?;
    let passed = read_through(&reading, &mut [log], &mut (), Phase::Reading, progress)?;
    let (Some(figures), Some(&span)) = (passed.logs.first(), passed.spans.first()) else {
        return Err(FactorsError::None.into());
    };
    let one = OneLog {
        order,
        info: LogInfo::of(name.as_ref().unwrap_or(&label), figures),
        examined: OfLog::new(&label, reading.channels(), reading.model(), figures),
        span,
        system: StoredSystem::new(passed.system),
    };
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
pub(crate) fn identify_factors(
    experiment: &Experiment,
    model: &Model,
    first: LogSource<'_>,
    factors: &LogFactors,
    progress: &mut dyn Listener,
) -> Result<Identified, IdentifyError> {
    let clock = Stopwatch::start();
    let (prepared, chosen) = prepared(experiment, model, first, progress)?;
    let laws = chosen.as_ref().map(|chosen| &chosen.result);
    factors.check(experiment, &Choices::new(experiment, &prepared, laws))?;
    let described = prepared.experiment().clone();
    let model = prepared.reading().model();
    let inputs = EstimatorInputs::new(&described, model)?;
    let read = factors.read(model)?;
    let about_logs = all_about_logs(&prepared, chosen.as_ref(), &read)?;
    let linear = fit_all(&prepared, &read)?;
    let basis = Basis {
        prepared: &prepared,
        system: &read.system,
        linear: &linear,
        fit_seconds: clock.seconds(),
        lsff: None,
        inputs: &inputs,
        about_logs: &about_logs,
        record: &Record::new(model.joint_count()),
    };
    let found = least_squares(model, basis.system, &linear.fitted, basis.fit_seconds);
    let estimates = vec![(Estimator::LeastSquares, found)];
    let mut identified = describe_all(&basis, &read, estimates, progress)?;
    identified.identification.laws = chosen.map(|chosen| chosen.result);
    Ok(identified)
}
