//! The main task: logs in, parameters out.

use super::about_effects::after_estimation;
use super::about_logs::LogInfo;
use super::at_rest::at_rest;
use super::confirmed::confirmed;
use super::decide::decide;
use super::describe::{Linear, describe, fit_curves, over_time, trace_of};
use super::error::IdentifyError;
use super::estimators::Basis;
use super::found::Found;
use super::in_frequency::{in_frequency, springs_of_motors};
use super::inputs::EstimatorInputs;
use super::judge::{judge, tilt_is_possible, tilted};
use super::laws::{Chosen, LAWS_MISSING, choose_laws, laws_of, open_delays, with_open_delays};
use super::least_squares::{
    Parts, add_instruments, cross_checks, cutoff_choice, least_squares, widened,
};
use super::lsff::Lsff;
use super::on_line::OnLine;
use super::payload::{Loaded, PayloadResult, payload_of};
use super::prediction_error::likely;
use super::promise::HeldOutRatio;
use super::read_logs::ReadLogs;
use super::result::{CutoffChoice, EstimateResult, GENERATOR, Identification, SettingsUsed};
use crate::check::{Refusal, examine};
use crate::curves::Curves;
use crate::description::{
    Estimator, Experiment, Identify, Instruments, Laws, OnCheckError, Payload,
};
use crate::finding::{Finding, Severity};
use crate::fit::{Fitted, fit, residual};
use crate::frequency::Record;
use crate::log::LogSource;
use crate::model::Model;
use crate::prepare::{Likely, PrepareError, Prepared, prepare};
use crate::progress::{Listener, Phase};
use crate::regression::{Reading, read_through};
use crate::stopwatch::Stopwatch;

/// Steps of the phase `Examining`: first instruments and gravity, then other cut-offs.
const EXAMINATION_STEPS: u64 = 2;

/// Result of an identification.
#[derive(Clone, Debug)]
pub struct Identified {
    /// The results.
    pub identification: Identification,
    /// Every parameter over time, one set of curves per estimator.
    pub trace: Curves,
    /// Filtered right-hand sides: the measured ones and those predicted with each estimate.
    pub fit: Curves,
}

/// Identifies the parameters of a robot from its logs.
///
/// Each log is read block by block, so memory does not grow with the length of a log. The beginning
/// of the first log is enough for searches (cut-off, delays, Stribeck velocities) and for further
/// tests of suspicious results. The refinement reads the beginning of every log again.
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

/// Identifies the parameters as [`identify`], and hands over the result of least squares before a
/// refinement begins, because a refinement may take minutes.
///
/// - `first`: receives the result of least squares. It is not called if no refinement is asked for.
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
    sources.sort_by_key(LogSource::has_unknown_payload);
    let empty = sources.partition_point(|source| !source.has_unknown_payload());
    let (sources, loaded) = sources.split_at_mut(empty);
    // A missing input is reported before a log is read.
    EstimatorInputs::new(experiment, model)?;
    let prepared = prepare_to_estimate(experiment, model, sources, progress)?;
    let (prepared, mut chosen) = with_chosen_laws(prepared, sources, progress)?;
    let described = prepared.experiment().clone();
    let inputs = EstimatorInputs::new(&described, prepared.reading().model())?;
    let (read, on_line, record) = pass(&prepared, sources, progress)?;
    let about_logs = all_about_logs(&prepared, chosen.as_ref(), &read)?;
    let linear = fit_all(&prepared, &read)?;
    let basis = Basis {
        prepared: &prepared,
        system: &read.system,
        linear: &linear,
        fit_seconds: clock.seconds() - on_line.seconds,
        lsff: on_line.lsff.as_ref().map(|lsff| (lsff, on_line.seconds)),
        inputs: &inputs,
        about_logs: &about_logs,
        record: &record,
    };
    if (prepared.reading().settings().estimator).contains(&Estimator::PredictionError) {
        let mut early = before_refinement(&basis, &read)?;
        early.identification.laws = chosen.as_ref().map(|chosen| chosen.result.clone());
        first(&early);
    }
    let estimates = refine(&basis, sources, progress)?;
    let payloads = payloads(&basis, &estimates, loaded, progress)?;
    let mut identified = describe_all(&basis, &read, estimates, progress)?;
    for (payload, findings) in payloads {
        identified.identification.payloads.push(payload);
        identified.identification.findings.extend(findings);
    }
    let mut results = identified.identification.results.iter();
    let refined = results.find_map(EstimateResult::refined);
    if let (Some(chosen), Some(refined)) = (&mut chosen, refined) {
        let velocities = refined.stribeck_velocities.iter();
        chosen.set_velocities(
            velocities.map(|own| (own.joint.as_str(), own.velocity, own.standard_error)),
        );
    }
    identified.identification.laws = chosen.map(|chosen| chosen.result);
    Ok(identified)
}

/// Prepares the logs for a refinement, with the laws that the settings ask to choose by hold-out.
pub(super) fn prepare_with_laws(
    experiment: &Experiment,
    model: &Model,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<Prepared, IdentifyError> {
    let auto = (0..model.joint_count()).any(|joint| laws_of(experiment, joint) == Laws::Auto);
    if !auto {
        return Ok(prepare(experiment, model, sources, progress)?.weighted(progress)?);
    }
    let prepared = prepare_to_estimate(experiment, model, sources, progress)?;
    Ok(with_chosen_laws(prepared, sources, progress)?.0)
}

/// Chooses the laws by hold-out. If laws are added, prepares the logs again with them, estimates
/// Stribeck velocities and the delays of torques by likelihood, and keeps the delays that are
/// significant.
pub(super) fn with_chosen_laws(
    prepared: Prepared,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<(Prepared, Option<Chosen>), IdentifyError> {
    let Some(mut chosen) = choose_laws(&prepared) else {
        return Ok((prepared, None));
    };
    let richer = chosen.experiment.as_ref();
    let described = richer.unwrap_or(prepared.experiment()).clone();
    let columns = open_delays(&prepared, &described);
    if richer.is_none() && columns.is_empty() {
        return Ok((prepared, Some(chosen)));
    }
    // Delays change no equation, so one model serves all of them.
    let Ok(model) = Model::new(&described) else {
        return Ok((prepared, Some(chosen)));
    };
    let model = model.with_open_stribeck(&chosen.open_velocities);
    let open = with_open_delays(&described, &columns);
    let (with_delays, likely) = search(&open, &model, sources, progress)?;
    let joints = model.joints();
    let velocities = (likely.velocities.iter()).filter(|own| with_delays.uses(own));
    chosen.set_velocities(
        velocities.map(|own| (joints[own.joint].as_str(), own.velocity, own.standard_error)),
    );
    let mut again = |experiment: &Experiment| -> Result<Prepared, IdentifyError> {
        Ok(prepare(experiment, &model, sources, progress)?.with_likely(&likely))
    };
    let without_delays = again(&described)?;
    let added = chosen.add_delays(&without_delays, &with_delays, &columns);
    let prepared = match added.len() {
        0 => without_delays,
        all if all == columns.len() => with_delays,
        _ => again(&with_open_delays(&described, &added))?,
    };
    Ok((prepared.weighted(progress)?, Some(chosen)))
}

/// Prepares the logs as a check does. Then estimates the requested delays and open Stribeck
/// velocities by likelihood, and determines the weights of the samples.
pub(super) fn prepare_to_estimate(
    experiment: &Experiment,
    model: &Model,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<Prepared, IdentifyError> {
    let (prepared, _) = search(experiment, model, sources, progress)?;
    Ok(prepared.weighted(progress)?)
}

/// Prepares the logs, and estimates the requested delays and open Stribeck velocities by likelihood.
fn search(
    experiment: &Experiment,
    model: &Model,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<(Prepared, Likely), IdentifyError> {
    let prepared = prepare(experiment, model, sources, progress)?;
    let settings = prepared.reading().settings();
    refuse(settings, prepared.wrong_time_unit())?;
    let likely = likely(prepared.reading(), sources, prepared.excerpt(), progress)?;
    Ok((prepared.with_likely(&likely), likely))
}

/// State of the on-line estimator after the pass.
struct OnLineState {
    lsff: Option<Lsff>,
    // Computing time, s.
    seconds: f64,
}

/// Reads the logs once and feeds every consumer of samples.
fn pass(
    prepared: &Prepared,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<(ReadLogs, OnLineState, Record), IdentifyError> {
    let reading = prepared.reading();
    let on_line = OnLine::new(reading.model(), reading.settings());
    let mut observers = (on_line, Record::new(reading.model().joint_count()));
    let passed = read_through(reading, sources, &mut observers, Phase::Reading, progress)?;
    let (on_line, record) = observers;
    let left = OnLineState {
        lsff: on_line.lsff.transpose()?,
        seconds: on_line.seconds,
    };
    Ok((ReadLogs::new(prepared, passed), left, record))
}

/// Returns all findings about the logs. Refuses logs that contradict the experiment file.
pub(super) fn all_about_logs(
    prepared: &Prepared,
    chosen: Option<&Chosen>,
    read: &ReadLogs,
) -> Result<Vec<Finding>, IdentifyError> {
    let mut about_logs = examine_or_refuse(prepared, read)?;
    // A faulty log looks like missing laws.
    let is_faulty = (about_logs.iter()).any(|finding| finding.severity > Severity::Info);
    let about_laws = chosen.and_then(|chosen| chosen.finding.clone());
    about_logs.extend(about_laws.filter(|finding| !(is_faulty && finding.code == LAWS_MISSING)));
    about_logs.extend(at_rest(prepared, &read.system));
    Ok(about_logs)
}

/// Returns the findings about the logs. Refuses logs that contradict the experiment file.
fn examine_or_refuse(prepared: &Prepared, read: &ReadLogs) -> Result<Vec<Finding>, IdentifyError> {
    let examined = examine(prepared, &read.examined);
    refuse(prepared.reading().settings(), &examined.findings)?;
    let mut findings = prepared.findings();
    findings.extend(examined.findings);
    Ok(findings)
}

/// Refuses the logs if a finding is an error, unless the settings say to go on.
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

/// Solves the regression of all logs by least squares, by other routes and from parts of the logs.
pub(super) fn fit_all(prepared: &Prepared, read: &ReadLogs) -> Result<Linear, IdentifyError> {
    let (model, system) = (prepared.reading().model(), &read.system);
    let is_finite = |fitted: &Fitted| {
        let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
        finite(&fitted.theta)
            && finite(&fitted.standard_error)
            && (residual(model, system, &fitted.theta).iter())
                .all(|row| row.0.is_finite() && row.1.is_finite())
    };
    let fitted = fit(model, system, prepared.reading().memory()).filter(is_finite);
    let fitted = fitted.ok_or_else(|| IdentifyError::NotFinite {
        file: prepared.names().join(", "),
    })?;
    let routes = cross_checks(model, system);
    let parts = Parts::new(model, (system, &read.spans), &fitted);
    Ok(Linear {
        held_out: HeldOutRatio::new(model, system, &fitted.theta),
        fitted: widened(prepared, fitted, &routes, &parts),
        routes,
        parts,
    })
}

/// Runs the estimators in the order of the settings.
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

/// Estimates the payloads of logs, each from all logs with it, beside the first estimate.
fn payloads(
    basis: &Basis<'_>,
    estimates: &[(Estimator, Found)],
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<Vec<(PayloadResult, Vec<Finding>)>, IdentifyError> {
    let reading = basis.prepared.reading();
    let name = |source: &LogSource<'_>| source.payload().map_or("", Payload::name).to_owned();
    sources.sort_by_key(name);
    let mut results = Vec::new();
    for logs in sources.chunk_by_mut(|a, b| name(a) == name(b)) {
        let passed = read_through(reading, logs, &mut (), Phase::Reading, progress)?;
        let payload = logs.first().and_then(LogSource::payload);
        let link = payload.and_then(|own| reading.model().link_of_payload(own).ok());
        let (Some(link), Some((estimator, found))) = (link, estimates.first()) else {
            continue;
        };
        let loaded = Loaded {
            name: &name(&logs[0]),
            link,
            logs: logs.iter().map(LogSource::label).collect(),
            system: &passed.system,
        };
        let of_robot = (estimator.name(), &found.numbers);
        let without = (basis.system, &basis.linear.fitted);
        results.extend(payload_of(reading.model(), &loaded, of_robot, without));
    }
    Ok(results)
}

/// Judges the estimates, examines suspicious results again, and assembles the identification.
pub(super) fn describe_all(
    basis: &Basis<'_>,
    read: &ReadLogs,
    estimates: Vec<(Estimator, Found)>,
    progress: &mut dyn Listener,
) -> Result<Identified, IdentifyError> {
    let mut results: Vec<EstimateResult> = (estimates.iter())
        .map(|(estimator, found)| judged(basis, *estimator, found))
        .collect();
    progress.tell(Phase::Examining, 1, Some(EXAMINATION_STEPS))?;
    let mut findings = basis.about_logs.to_vec();
    findings.extend(look_again(basis, &mut results));
    after_estimation(&mut findings, &results);
    let response = in_frequency(basis, &estimates, &mut results);
    let (springs, about_springs) = springs_of_motors(basis);
    findings.extend(about_springs);
    for result in &mut results {
        decide(result, &findings);
    }
    progress.tell(Phase::Examining, EXAMINATION_STEPS, Some(EXAMINATION_STEPS))?;
    let mut identified = assemble(basis, read, estimates, results, findings)?;
    identified.identification.frequency_response = response;
    identified.identification.springs_from_motor = springs;
    Ok(identified)
}

/// Returns the result of least squares as it is before a refinement, without the examinations that
/// follow an estimation.
fn before_refinement(basis: &Basis<'_>, read: &ReadLogs) -> Result<Identified, IdentifyError> {
    let model = basis.prepared.reading().model();
    let found = least_squares(model, basis.system, &basis.linear.fitted, basis.fit_seconds);
    let mut result = judged(basis, Estimator::LeastSquares, &found);
    let mut findings = basis.about_logs.to_vec();
    findings.push(Finding::new(
        Severity::Info,
        "refinement-pending",
        "these are the values of least squares, written before the refinement. The refinement has \
         not ended, or it was stopped"
            .to_owned(),
        "let sprung identify end, or set estimator = \"least-squares\"",
    ));
    decide(&mut result, &findings);
    let estimates = vec![(Estimator::LeastSquares, found)];
    assemble(basis, read, estimates, vec![result], findings)
}

/// Assembles the identification and its curves.
///
/// - `results`: one per estimate.
fn assemble(
    basis: &Basis<'_>,
    read: &ReadLogs,
    estimates: Vec<(Estimator, Found)>,
    results: Vec<EstimateResult>,
    findings: Vec<Finding>,
) -> Result<Identified, IdentifyError> {
    let prepared = basis.prepared;
    let reading = prepared.reading();
    let model = reading.model();
    let with_choices = |info: &LogInfo| info.clone().with_choices(prepared);
    let mut infos = read.infos.iter().map(with_choices);
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
            settings: settings_used(reading, cutoff_choice(prepared)),
            laws: None,
            frequency_response: None,
            springs_from_motor: Vec::new(),
            payloads: Vec::new(),
            findings,
            results,
        },
    })
}

/// Returns the result of an estimator with all its findings.
fn judged(basis: &Basis<'_>, estimator: Estimator, found: &Found) -> EstimateResult {
    let (reading, linear) = (basis.prepared.reading(), basis.linear);
    let (model, channels) = (reading.model(), reading.channels());
    let choice = (estimator, &reading.settings().physical);
    let mut result = describe(model, choice, &found.numbers, linear, basis.system);
    let judged = judge(model, &result, linear, basis.prepared.sweep(), channels);
    result.warnings.extend(judged);
    let findings = found.findings.iter().cloned();
    result
        .warnings
        .extend(findings.map(|finding| confirmed(finding, basis.prepared)));
    (result.warnings).sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    result
}

/// Examines the beginning of the first log again: adds instrumental variables if the settings ask
/// for them, and tests whether gravity is tilted.
fn look_again(basis: &Basis<'_>, results: &mut [EstimateResult]) -> Option<Finding> {
    let prepared = basis.prepared;
    let (reading, excerpt) = (prepared.reading(), prepared.excerpt());
    match reading.settings().instruments {
        Instruments::None => {}
        Instruments::Simulated => add_instruments(reading, excerpt, &basis.linear.fitted, results),
    }
    if tilt_is_possible(prepared.experiment(), worst_residual(results)) {
        return tilted(prepared.experiment(), reading, excerpt);
    }
    None
}

/// Returns the largest relative residual of the torque rows of the first result.
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
