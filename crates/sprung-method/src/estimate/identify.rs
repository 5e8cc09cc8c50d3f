//! The main task: logs in, parameters out.

use crate::description::{Estimator, Experiment};
use crate::estimate::errors::IdentifyError;
use crate::estimate::estimators::prediction_error::Timing;
use crate::estimate::springs::{Sensed, Undetermined};
use crate::estimate::steps::{
    Basis, Identified, Logs, ReadLogs, Ready, Refined, before_refinement, describe, examine, fit,
    make_ready, pass, refine,
};
use crate::estimate::sums::Sums;
use crate::log::LogSource;
use crate::model::Model;
use crate::progress::Listener;
use crate::stopwatch::Stopwatch;

/// Identifies the parameters of a robot from its logs.
///
/// Each log is read block by block, so memory does not grow with the length of a log. The beginning
/// of the first log suffices for searches (cut-off, delays, Stribeck velocities) and for further
/// tests of doubtful results. The refinement reads the beginning of every log again.
///
/// - `sources`: the logs, all with the same columns.
/// - `progress`: receives the choices made, the samples read, the runs of the filter and the
///   simulations.
///
/// # Errors
///
/// [`IdentifyError`] if the description or a log is faulty, or if the two contradict each other. A
/// poor fit is a result, not an error.
///
/// # Source
///
/// Section 2.3: prepare, pass, examine, fit, refine, describe.
pub fn identify(
    experiment: &Experiment,
    model: &Model,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<Identified, IdentifyError> {
    identify_and_tell(experiment, model, sources, progress, &mut |_| ())
}

/// Identifies the parameters as [`identify`], and returns the result of least squares before a
/// refinement begins, because a refinement may take minutes.
///
/// - `first`: receives the result of least squares. It is not called if no refinement is requested.
///
/// # Errors
///
/// The errors of [`identify`].
pub fn identify_and_tell(
    experiment: &Experiment,
    model: &Model,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
    first: &mut dyn FnMut(&Identified),
) -> Result<Identified, IdentifyError> {
    let clock = Stopwatch::start();
    let mut logs = Logs::new(sources);
    let ready = make_ready(experiment, model, logs.of_robot, progress)?;
    let read = pass(&ready, logs.of_robot, progress)?;
    conclude(
        &ready,
        &read,
        &mut logs,
        (&clock, Timing::Open),
        progress,
        first,
    )
}

/// Makes the steps after the pass.
///
/// - `logs`: the logs, for estimators that read them again.
/// - `clock`: started before the first step; `timing`: of the torques.
///
/// # Errors
///
/// The errors of [`identify`].
fn conclude(
    prepared: &Ready,
    read: &ReadLogs,
    logs: &mut Logs<'_, '_>,
    (clock, timing): (&Stopwatch, Timing<'_>),
    progress: &mut dyn Listener,
    first: &mut dyn FnMut(&Identified),
) -> Result<Identified, IdentifyError> {
    let reading = prepared.prepared.reading();
    let springs = &Undetermined::new(reading, &read.system);
    let of_springs = springs.settled(reading.model());
    let sums = &Sums::new(of_springs.as_ref().unwrap_or(reading.model()), &read.system);
    let settled = sums.settled(of_springs.as_ref().unwrap_or(reading.model()));
    let settled = (settled.or(of_springs))
        .map(|model| prepared.with_model(model))
        .transpose()?;
    let ready = settled.as_ref().unwrap_or(prepared);
    let findings = &examine(ready, read)?;
    let linear = &fit(ready, read, timing)?;
    let on_line_seconds = read.lsff.as_ref().map_or(0.0, |(_, seconds)| *seconds);
    let basis = Basis {
        ready,
        read,
        findings,
        springs,
        sums,
        linear,
        timing,
        fit_seconds: clock.seconds() - on_line_seconds,
    };
    let refines = basis.estimators().contains(&Estimator::PredictionError);
    if refines && matches!(timing, Timing::Open) {
        first(&before_refinement(&basis)?);
    }
    match refine(&basis, logs, progress)? {
        Refined::Estimates(estimates) => {
            let sensed = Sensed::new(ready.prepared.experiment(), logs.of_robot, progress)?;
            describe(&basis, estimates, sensed, progress)
        }
        Refined::Retimed(retiming) => {
            let retimed = prepared.retimed(&retiming)?;
            let read = pass(&retimed, logs.of_robot, progress)?;
            let timing = (clock, Timing::Found(&retiming));
            conclude(&retimed, &read, logs, timing, progress, first)
        }
    }
}
