//! The main job: logs in, parameters out.

use super::about_logs::log_infos;
use super::asked::Asked;
use super::describe::{describe, fit_curves, over_time, trace_of};
use super::error::IdentifyError;
use super::estimators::Basis;
use super::found::Found;
use super::judge::{judge, tilted, worth_a_look};
use super::least_squares::{add_instruments, sweep};
use super::lsff::Lsff;
use super::on_line::OnLine;
use super::prediction_error::likely_delays;
use super::result::{CutoffChoice, EstimateResult, GENERATOR, Identification, SettingsUsed};
use super::verdict::Verdict;
use crate::check::{Refusal, examine};
use crate::curves::Curves;
use crate::description::{Estimator, Experiment, Identify, Instruments, OnCheckError};
use crate::finding::{Finding, Severity};
use crate::fit::{Fitted, fit, residual};
use crate::log::LogSource;
use crate::model::Model;
use crate::prepare::{PrepareError, Prepared, prepare};
use crate::progress::{Listener, Phase};
use crate::regression::{Passed, Reading, read_through};
use crate::stopwatch::Stopwatch;

/// Looks at what was found: instruments and gravity, then other cut-offs.
const LOOKS: u64 = 2;

/// What an identification leaves.
#[derive(Clone, Debug)]
pub struct Identified {
    /// The results.
    pub identification: Identification,
    /// Every parameter over time, one set per estimator.
    pub trace: Curves,
    /// Filtered right-hand sides, measured and by each estimator.
    pub fit: Curves,
}

/// Identifies the parameters of a robot from its logs.
///
/// Each log is read block by block; memory does not grow with it. What is to be
/// chosen or searched (cut-off, delays, Stribeck velocities), and suspicions about
/// impossible results, cost a look at the beginning of the first; the refinement
/// reads the beginnings of all again.
///
/// - `sources`: the logs, all with the same columns.
/// - `progress`: told of what is chosen, of samples as they are read, of runs of a filter and of
///   simulations.
///
/// # Errors
///
/// [`IdentifyError`] if the description, a log or both together are wrong. A
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
    let clock = Stopwatch::start();
    let asked = Asked::new(experiment, model)?;
    let prepared = prepare_to_estimate(experiment, model, sources, progress)?;
    let (passed, on_line) = pass(&prepared, sources, progress)?;
    let about_logs = examine_or_refuse(&prepared, &passed)?;
    let fitted = fit_all(&prepared, &passed)?;
    let basis = Basis {
        prepared: &prepared,
        system: &passed.system,
        fitted: &fitted,
        fit_seconds: clock.seconds() - on_line.seconds,
        lsff: on_line.lsff.as_ref().map(|lsff| (lsff, on_line.seconds)),
        asked: &asked,
        about_logs: &about_logs,
    };
    let estimates = refine(&basis, sources, progress)?;
    describe_all(&basis, &passed, estimates, progress)
}

/// Prepares the logs as a check does, then asks the likelihood for delays that are to be
/// estimated, and finds the weights of samples.
fn prepare_to_estimate(
    experiment: &Experiment,
    model: &Model,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<Prepared, IdentifyError> {
    let prepared = prepare(experiment, model, sources, progress)?;
    let settings = prepared.reading().settings();
    refuse(settings, prepared.wrong_time_unit())?;
    let likely = likely_delays(prepared.reading(), sources, prepared.excerpt(), progress)?;
    Ok(prepared.with_likely_delays(likely).weighted(progress)?)
}

/// What the on-line estimator left of the pass.
struct LeftOnLine {
    lsff: Option<Lsff>,
    // Time that it took, s.
    seconds: f64,
}

/// Reads the logs once, past all that takes samples as they come.
fn pass(
    prepared: &Prepared,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<(Passed, LeftOnLine), IdentifyError> {
    let reading = prepared.reading();
    let mut on_line = OnLine::new(reading.model(), reading.settings());
    let passed = read_through(reading, sources, &mut on_line, Phase::Reading, progress)?;
    let left = LeftOnLine {
        lsff: on_line.lsff.transpose()?,
        seconds: on_line.seconds,
    };
    Ok((passed, left))
}

/// Returns what there is to know about the logs; refuses those that are not what the
/// experiment file says.
fn examine_or_refuse(prepared: &Prepared, passed: &Passed) -> Result<Vec<Finding>, IdentifyError> {
    let examined = examine(prepared, &passed.logs);
    refuse(prepared.reading().settings(), &examined.findings)?;
    let mut findings = prepared.findings();
    findings.extend(examined.findings);
    Ok(findings)
}

/// Refuses logs that are not what the experiment file says.
fn refuse<'a>(
    settings: &Identify,
    findings: impl IntoIterator<Item = &'a Finding>,
) -> Result<(), IdentifyError> {
    let errors: Vec<Finding> = (findings.into_iter())
        .filter(|finding| finding.severity == Severity::Error)
        .cloned()
        .collect();
    if errors.is_empty() || settings.on_check_error == OnCheckError::GoOn {
        return Ok(());
    }
    Err(IdentifyError::Refused(Refusal(errors)))
}

/// Solves the regression of all logs by least squares.
fn fit_all(prepared: &Prepared, passed: &Passed) -> Result<Fitted, IdentifyError> {
    let (model, system) = (prepared.reading().model(), &passed.system);
    let is_finite = |fitted: &Fitted| {
        let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
        finite(&fitted.theta)
            && finite(&fitted.standard_error)
            && (residual(model, system, &fitted.theta).iter())
                .all(|row| row.0.is_finite() && row.1.is_finite())
    };
    (fit(model, system).filter(is_finite)).ok_or_else(|| IdentifyError::NotFinite {
        file: prepared.names().join(", "),
    })
}

/// Runs the estimators that the settings name, in their order.
fn refine(
    basis: &Basis<'_>,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<Vec<(Estimator, Found)>, IdentifyError> {
    let estimators = basis.prepared.reading().settings().estimator.iter();
    estimators
        .map(|&estimator| Ok((estimator, basis.run(estimator, sources, progress)?)))
        .collect()
}

/// Judges estimates, looks again at what is suspicious, and puts all of it together.
fn describe_all(
    basis: &Basis<'_>,
    passed: &Passed,
    estimates: Vec<(Estimator, Found)>,
    progress: &mut dyn Listener,
) -> Result<Identified, IdentifyError> {
    let prepared = basis.prepared;
    let (reading, excerpt) = (prepared.reading(), prepared.excerpt());
    let model = reading.model();
    let mut results: Vec<EstimateResult> = (estimates.iter())
        .map(|(estimator, found)| judged(basis, *estimator, found))
        .collect();
    progress.tell(Phase::Examining, 1, Some(LOOKS))?;
    let mut findings = basis.about_logs.to_vec();
    findings.extend(look_again(basis, &mut results));
    for result in &mut results {
        result.verdict = Verdict::of(findings.iter().chain(&result.warnings));
    }
    progress.tell(Phase::Examining, LOOKS, Some(LOOKS))?;
    let choice = prepared.cutoff_reason();
    let choice = choice.map(|reason| sweep(reading, excerpt, reason.to_owned()));
    let mut infos = log_infos(prepared, &passed.logs).into_iter();
    let thetas = (estimates.iter()).map(|(estimator, found)| (*estimator, &found.numbers.theta));
    let fit = fit_curves(model, thetas, basis.system);
    let traces = (estimates.into_iter())
        .filter(|(_, found)| !found.numbers.points.is_empty())
        .map(|(estimator, found)| trace_of(model, estimator, found.numbers.points))
        .collect();
    Ok(Identified {
        trace: over_time(model, basis.system, traces),
        fit,
        identification: Identification {
            format: 1,
            generator: GENERATOR.to_owned(),
            robot: prepared.experiment().robot.name.clone(),
            log: infos.next().ok_or(PrepareError::NoLog)?,
            further_logs: infos.collect(),
            settings: settings_used(reading, choice),
            findings,
            results,
        },
    })
}

/// Returns what an estimator found with all that is to be said of it.
fn judged(basis: &Basis<'_>, estimator: Estimator, found: &Found) -> EstimateResult {
    let (reading, fitted) = (basis.prepared.reading(), basis.fitted);
    let (model, channels) = (reading.model(), reading.channels());
    let mut result = describe(model, estimator, &found.numbers, fitted, basis.system);
    result.warnings = judge(model, &result, &fitted.weakest_direction, channels);
    result.warnings.extend(found.findings.iter().cloned());
    (result.warnings).sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    result
}

/// Looks at the beginning again: what instruments say if they are asked for, and whether
/// gravity is tilted.
fn look_again(basis: &Basis<'_>, results: &mut [EstimateResult]) -> Option<Finding> {
    let prepared = basis.prepared;
    let (reading, excerpt) = (prepared.reading(), prepared.excerpt());
    match reading.settings().instruments {
        Instruments::None => {}
        Instruments::Simulated => add_instruments(reading, excerpt, basis.fitted, results),
    }
    if worth_a_look(prepared.experiment(), worst_residual(results)) {
        return tilted(prepared.experiment(), reading, excerpt);
    }
    None
}

/// Returns the largest residual of a torque's row, as a part of its torque.
fn worst_residual(results: &[EstimateResult]) -> f64 {
    let first = results.first().into_iter();
    first
        .flat_map(|result| result.relative_residual.iter())
        .fold(0.0, |worst, (_, share)| worst.max(share))
}

fn settings_used(reading: &Reading, choice: Option<CutoffChoice>) -> SettingsUsed {
    let settings = reading.settings();
    SettingsUsed {
        filter_cutoff_rad_per_s: settings.filter_cutoff_rad_per_s,
        discretization: settings.discretization.name().to_owned(),
        weights: settings.weights.name().to_owned(),
        position_cutoff_hz: reading.position_cutoff_hz(),
        position_cutoff_choice: choice,
        position_filter_order: settings.position_filter_order,
    }
}
