//! The fifth step: the estimators that the settings name, and the payloads of logs.

use super::basis::{Basis, Estimates, Logs};
use crate::description::{Estimator, Payload};
use crate::estimate::errors::IdentifyError;
use crate::estimate::estimators::Found;
use crate::estimate::estimators::lsff::on_line;
use crate::estimate::estimators::prediction_error::{
    Before, Refinements, Retiming, prediction_error,
};
use crate::estimate::payload::{Loaded, payload_of};
use crate::estimate::result::PayloadResult;
use crate::finding::Finding;
use crate::log::LogSource;
use crate::prepare::PrepareError;
use crate::progress::{Listener, Phase};
use crate::regression::read_through;

/// End of the estimators.
pub(in crate::estimate) enum Refined {
    Estimates(Estimates),
    /// Repeat the steps from the pass on, with another timing.
    Retimed(Box<Retiming>),
}

/// Runs the estimators in the order of the settings, then estimates the payloads.
///
/// # Errors
///
/// [`IdentifyError`] if a log cannot be read again or the caller stops the run.
pub(in crate::estimate) fn refine(
    basis: &Basis<'_>,
    logs: &mut Logs<'_, '_>,
    progress: &mut dyn Listener,
) -> Result<Refined, IdentifyError> {
    let estimators = basis.estimators().iter();
    let mut robot: Vec<(Estimator, Found)> = Vec::new();
    for &estimator in estimators {
        match run(basis, estimator, logs.of_robot, progress)? {
            Refinements::Found(found) => robot.push((estimator, *found)),
            Refinements::Retimed(retiming) => return Ok(Refined::Retimed(retiming)),
        }
    }
    let payloads = payloads(basis, &robot, logs.loaded, progress)?;
    Ok(Refined::Estimates(Estimates { robot, payloads }))
}

/// Runs one estimator. Every estimator has an arm here.
///
/// # Errors
///
/// [`IdentifyError`] if a log cannot be read again or the caller stops the run.
fn run(
    basis: &Basis<'_>,
    estimator: Estimator,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<Refinements, IdentifyError> {
    let prepared = &basis.ready.prepared;
    let (reading, excerpt) = (prepared.reading(), prepared.excerpt());
    let fitted = &basis.linear.fitted;
    let found = match estimator {
        Estimator::LeastSquares => basis.least_squares(),
        Estimator::Lsff => on_line(basis.read.lsff.as_ref().ok_or(PrepareError::NoLog)?, fitted),
        Estimator::PredictionError => {
            let doubt = prepared.doubt();
            let by_gains: Vec<f64> = doubt.iter().map(|doubt| doubt.by_gains).collect();
            let before = Before {
                experiment: prepared.experiment(),
                excerpt,
                system: &basis.read.system,
                fitted,
                possible: basis.linear.possible.as_ref(),
                nominal: basis.ready.nominal.as_deref(),
                timing: basis.timing,
                about_logs: basis.findings,
                by_gains: &by_gains,
            };
            return Ok(prediction_error(reading, sources, before, progress)?);
        }
    };
    Ok(Refinements::Found(Box::new(found)))
}

/// Estimates the payloads of logs, each from all logs with it, beside the first estimate.
fn payloads(
    basis: &Basis<'_>,
    robot: &[(Estimator, Found)],
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<Vec<(PayloadResult, Vec<Finding>)>, IdentifyError> {
    let reading = basis.ready.prepared.reading();
    let name = |source: &LogSource<'_>| source.payload().map_or("", Payload::name).to_owned();
    sources.sort_by_key(name);
    let mut results = Vec::new();
    for logs in sources.chunk_by_mut(|a, b| name(a) == name(b)) {
        let passed = read_through(reading, logs, &mut (), Phase::Reading, progress)?;
        let payload = logs.first().and_then(LogSource::payload);
        let link = payload.and_then(|payload| reading.model().link_of_payload(payload).ok());
        let (Some(link), Some((estimator, found))) = (link, robot.first()) else {
            continue;
        };
        let loaded = Loaded {
            name: &name(&logs[0]),
            link,
            logs: logs.iter().map(LogSource::label).collect(),
            system: &passed.system,
        };
        let of_robot = (estimator.name(), &found.numbers);
        let without = (&basis.read.system, &basis.linear.fitted);
        results.extend(payload_of(reading.model(), &loaded, of_robot, without));
    }
    Ok(results)
}
