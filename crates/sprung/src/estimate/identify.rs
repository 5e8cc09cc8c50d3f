//! The main job: one log in, parameters out.

use super::about_logs::log_infos;
use super::beginning::Beginning;
use super::describe::{OfEstimator, describe, fit_curves, trace_of};
use super::judge::{judge, tilted, worth_a_look};
use super::least_squares::{add_instruments, sweep};
use super::lsff::{Lsff, LsffError};
use super::output_error::output_error;
use super::prediction_error::{Before, prediction_error};
use super::result::{CutoffChoice, EstimateResult, GENERATOR, Identification, SettingsUsed};
use super::verdict::Verdict;
use super::watch::{Watch, of_lsff};
use crate::check::{Refusal, examine};
use crate::curves::{CurveSet, Curves};
use crate::description::{
    Controller, ControllerKind, Cutoff, Estimator, Experiment, Feedforward, Identify, OnCheckError,
    StartName, Weights,
};
use crate::finding::{Finding, Severity};
use crate::fit::{Fitted, fit, residual, trace};
use crate::log::{ChannelError, Channels, LogSource, time_unit};
use crate::model::{Model, ModelError, Theta};
use crate::prepare::{
    DelayError, Delays, FactorError, choose_cutoff, find_factors, find_stribeck, find_weights,
};
use crate::progress::{Listener, Phase, Stopped};
use crate::regression::{PassError, Passed, Reading, System, TransitionWeights, read_through};
use crate::stopwatch::Stopwatch;

/// What is chosen before an estimate: cut-off, delays, Stribeck velocities and weights.
const CHOICES: u64 = 4;

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

/// What keeps a log from being identified.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IdentifyError {
    /// The experiment names no log.
    #[error("the experiment has no [log]; say which file to identify from")]
    NoLog,
    /// The description of the log is not complete.
    #[error(transparent)]
    Channel(#[from] ChannelError),
    /// Output error has no controller to simulate.
    #[error(
        "estimator \"output-error\" simulates the closed loop, and {0}; or use \"least-squares\", which \
         needs no controller"
    )]
    Controller(&'static str),
    /// The refinement is to start from values that the file does not give.
    #[error("[identify] start = \"nominal\" needs nominal values: {0}")]
    Start(ModelError),
    /// LSFF cannot be built.
    #[error(transparent)]
    Lsff(#[from] LsffError),
    /// A delay cannot be estimated.
    #[error(transparent)]
    Delay(#[from] DelayError),
    /// A sign or a gain cannot be estimated.
    #[error(transparent)]
    Factor(FactorError),
    /// The log is wrong, or does not fit the filters.
    #[error(transparent)]
    Pass(PassError),
    /// The caller stopped it.
    #[error(transparent)]
    Stopped(#[from] Stopped),
    /// The log is not what the experiment file says.
    #[error("{0}; to go on nevertheless set on_check_error = \"go-on\" in [identify]")]
    Refused(Refusal),
    /// The numbers leave the range that can be computed with.
    #[error(
        "the regression of {file} holds numbers that are not finite; are the units of its columns \
         right?"
    )]
    NotFinite {
        /// Name of the log.
        file: String,
    },
}

impl From<PassError> for IdentifyError {
    fn from(error: PassError) -> Self {
        match error {
            PassError::Stopped(stopped) => Self::Stopped(stopped),
            error => Self::Pass(error),
        }
    }
}

impl From<FactorError> for IdentifyError {
    fn from(error: FactorError) -> Self {
        match error {
            FactorError::Log(error) => Self::Pass(error.into()),
            error => Self::Factor(error),
        }
    }
}

/// Returns the model with the Stribeck velocities that it leaves open.
fn shape(
    reading: &Reading<'_>,
    beginning: &mut Beginning<'_, '_>,
    findings: &mut Vec<Finding>,
) -> Result<Model, PassError> {
    if reading.model.unknown_stribeck().is_empty() {
        return Ok(reading.model.clone());
    }
    Ok(match beginning.get(reading.channels)? {
        None => reading.model.clone(),
        Some(excerpt) => {
            let (model, found) = find_stribeck(reading, excerpt);
            findings.extend(found);
            model
        }
    })
}

/// Sets the cut-off of the position filter; returns why, if it is chosen.
fn choose(
    reading: &mut Reading<'_>,
    beginning: &mut Beginning<'_, '_>,
) -> Result<Option<String>, PassError> {
    match reading.settings.position_cutoff_hz {
        Cutoff::Fixed(cutoff) => {
            reading.position_cutoff_hz = cutoff;
            Ok(None)
        }
        Cutoff::Auto => Ok(beginning.get(reading.channels)?.map(|excerpt| {
            let (cutoff, reason) = choose_cutoff(
                reading.model,
                reading.channels,
                reading.settings.weights,
                excerpt,
            );
            reading.position_cutoff_hz = cutoff;
            reason
        })),
    }
}

/// Returns the weights of the samples; nothing if all count alike.
fn weights(
    reading: &Reading<'_>,
    beginning: &mut Beginning<'_, '_>,
) -> Result<Option<TransitionWeights>, PassError> {
    match reading.settings.weights {
        Weights::None => Ok(None),
        Weights::Transition => {
            Ok((beginning.get(reading.channels)?)
                .and_then(|excerpt| find_weights(reading, excerpt)))
        }
    }
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
pub fn identify(
    experiment: &Experiment,
    model: &Model,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<Identified, IdentifyError> {
    let start = Stopwatch::start();
    let (experiment, factors) = find_factors(experiment, model, sources)?;
    let experiment = &*experiment;
    let log = experiment.log.as_ref().ok_or(IdentifyError::NoLog)?;
    let settings = &experiment.identify;
    let controller = loop_controller(experiment)?;
    let nominal = nominal_start(model, settings)?;
    let channels = Channels::new(&experiment.robot, log)?;
    let names: Vec<String> = sources.iter().map(|source| source.name.clone()).collect();
    let file = names.join(", ");
    let mut beginning = Beginning {
        sources,
        excerpt: None,
    };
    let none = vec![0.0; channels.all.len()];
    let mut reading = Reading {
        model,
        settings,
        position_cutoff_hz: 0.0,
        channels: &channels,
        delays: &none,
        weights: None,
    };
    let mut choosing = |choice| progress.tell(Phase::Preparing, choice, Some(CHOICES));
    choosing(1)?;
    refuse_rate(settings, &mut beginning, &channels, &names)?;
    let chosen = choose(&mut reading, &mut beginning)?;
    let mut findings = factors.findings(names.first().map_or("", String::as_str));
    choosing(2)?;
    let mut delays = Delays::new(&reading, beginning.for_delays(&channels)?, &file)?;
    let searched = delays.values.clone();
    reading.delays = &searched;
    choosing(3)?;
    let shaped = shape(&reading, &mut beginning, &mut findings)?;
    reading.model = &shaped;
    beginning.refine_delays(&reading, &mut delays, progress)?;
    reading.delays = &delays.values;
    let model = &shaped;
    progress.tell(Phase::Preparing, CHOICES, Some(CHOICES))?;
    let weights = weights(&reading, &mut beginning)?;
    reading.weights = weights.as_ref();

    let mut watch = Watch::new(model, settings);
    let sources = &mut *beginning.sources;
    let passed = read_through(&reading, sources, &mut watch, Phase::Reading, progress)?;
    let excerpt = beginning.get(&channels).map_err(PassError::from)?;
    let examined = examine(experiment, &reading, &delays, &names, &passed.logs, excerpt);
    refuse(settings, &examined.findings)?;
    findings.extend(examined.findings);

    let fitted = fit(model, &passed.system)
        .filter(|fitted| is_finite(model, &passed.system, fitted))
        .ok_or(IdentifyError::NotFinite { file })?;
    let lsff = watch.lsff.transpose()?;
    let mut results = Vec::new();
    let mut traces = Vec::new();
    let mut thetas = Vec::new();
    for &estimator in &settings.estimator {
        let job = Job {
            reading: &reading,
            passed: &passed,
            fitted: &fitted,
            lsff: lsff.as_ref().map(|lsff| (lsff, watch.elapsed)),
            controller,
            nominal: nominal.as_deref(),
            findings: &findings,
            elapsed: start.seconds() - watch.elapsed,
        };
        let of_estimator = job.run(estimator, &mut beginning, progress)?;
        results.push(job.judged(estimator, &of_estimator));
        if !of_estimator.points.is_empty() {
            traces.push(trace_of(model, estimator, of_estimator.points));
        }
        thetas.push((estimator, of_estimator.theta));
    }
    progress.tell(Phase::Examining, 1, Some(LOOKS))?;
    look_again(
        experiment,
        &reading,
        &mut beginning,
        &fitted,
        &mut results,
        &mut findings,
    )?;
    for result in &mut results {
        result.verdict = Verdict::of(findings.iter().chain(&result.warnings));
    }
    progress.tell(Phase::Examining, LOOKS, Some(LOOKS))?;
    let excerpt = beginning.excerpt.as_ref();
    let position_cutoff_choice =
        (chosen.zip(excerpt)).map(|(reason, excerpt)| sweep(&reading, excerpt, reason));
    let mut infos =
        log_infos(log, &names, &passed.logs, (&delays, &factors), &channels).into_iter();
    Ok(Identified {
        trace: over_time(model, &passed.system, traces),
        fit: fit_curves(model, &thetas, &passed.system),
        identification: Identification {
            format: 1,
            generator: GENERATOR.to_owned(),
            robot: experiment.robot.name.clone(),
            log: infos.next().ok_or(IdentifyError::NoLog)?,
            further_logs: infos.collect(),
            settings: settings_used(&reading, position_cutoff_choice),
            findings,
            results,
        },
    })
}

/// Returns parameters over time, of least squares if no estimator has any.
fn over_time(model: &Model, system: &System, mut traces: Vec<CurveSet>) -> Curves {
    if traces.is_empty() {
        let points = trace(model, system).collect();
        traces.push(trace_of(model, Estimator::LeastSquares, points));
    }
    Curves {
        columns: model.parameters().iter().map(|p| p.name.clone()).collect(),
        sets: traces,
    }
}

/// Looks at the beginning again: what instruments say, and whether gravity is tilted.
fn look_again(
    experiment: &Experiment,
    reading: &Reading<'_>,
    beginning: &mut Beginning<'_, '_>,
    fitted: &Fitted,
    results: &mut [EstimateResult],
    findings: &mut Vec<Finding>,
) -> Result<(), PassError> {
    if reading.weights.is_some()
        && let Some(excerpt) = beginning.get(reading.channels)?
    {
        add_instruments(reading, excerpt, fitted, results);
    }
    if worth_a_look(experiment, worst_residual(results))
        && let Some(excerpt) = beginning.get(reading.channels)?
    {
        findings.extend(tilted(experiment, reading, excerpt));
    }
    Ok(())
}

/// What estimators are made of.
struct Job<'a> {
    reading: &'a Reading<'a>,
    passed: &'a Passed,
    fitted: &'a Fitted,
    /// LSFF and the time that it took, s.
    lsff: Option<(&'a Lsff, f64)>,
    controller: Option<&'a Controller>,
    nominal: Option<&'a [f64]>,
    findings: &'a [Finding],
    /// Time that least squares took, s.
    elapsed: f64,
}

impl Job<'_> {
    fn run(
        &self,
        estimator: Estimator,
        beginning: &mut Beginning<'_, '_>,
        progress: &mut dyn Listener,
    ) -> Result<OfEstimator, IdentifyError> {
        let (reading, fitted) = (self.reading, self.fitted);
        Ok(match (estimator, self.lsff, self.controller) {
            (Estimator::Lsff, Some((lsff, elapsed)), _) => of_lsff(lsff, fitted, elapsed),
            (Estimator::OutputError, _, Some(controller)) => {
                let excerpt = beginning.get(reading.channels).map_err(PassError::from)?;
                let excerpt = excerpt.ok_or(IdentifyError::NoLog)?;
                output_error(reading, controller, excerpt, fitted, progress)?
            }
            (Estimator::PredictionError, ..) => {
                beginning.get(reading.channels).map_err(PassError::from)?;
                let excerpt = beginning.excerpt.as_ref().ok_or(IdentifyError::NoLog)?;
                let before = Before {
                    excerpt,
                    system: &self.passed.system,
                    fitted,
                    nominal: self.nominal,
                    about_logs: self.findings,
                };
                prediction_error(reading, beginning.sources, before, progress)?
            }
            _ => of_least_squares(reading.model, &self.passed.system, fitted, self.elapsed),
        })
    }

    /// Returns what an estimator found with all that is to be said of it.
    fn judged(&self, estimator: Estimator, found: &OfEstimator) -> EstimateResult {
        let (reading, fitted) = (self.reading, self.fitted);
        let mut result = describe(reading.model, estimator, found, fitted, &self.passed.system);
        result.warnings = judge(
            reading.model,
            &result,
            &fitted.weakest_direction,
            reading.channels,
        );
        result.warnings.extend(found.findings.iter().cloned());
        result
            .warnings
            .sort_by_key(|finding| std::cmp::Reverse(finding.severity));
        result
    }
}

/// Refuses logs that are not what the experiment file says.
fn refuse(settings: &Identify, findings: &[Finding]) -> Result<(), IdentifyError> {
    let errors: Vec<Finding> = (findings.iter())
        .filter(|finding| finding.severity == Severity::Error)
        .cloned()
        .collect();
    if errors.is_empty() || settings.on_check_error == OnCheckError::GoOn {
        return Ok(());
    }
    Err(IdentifyError::Refused(Refusal(errors)))
}

/// Refuses a log of which the time has another unit, for no filter could be built.
fn refuse_rate(
    settings: &Identify,
    beginning: &mut Beginning<'_, '_>,
    channels: &Channels,
    names: &[String],
) -> Result<(), IdentifyError> {
    let excerpt = beginning.get(channels).map_err(PassError::from)?;
    let (Some(excerpt), Some(name)) = (excerpt, names.first()) else {
        return Ok(());
    };
    let wrong = time_unit(name, channels, excerpt.period());
    refuse(settings, wrong.as_slice())
}

fn settings_used(reading: &Reading<'_>, choice: Option<CutoffChoice>) -> SettingsUsed {
    let settings = reading.settings;
    SettingsUsed {
        filter_cutoff_rad_per_s: settings.filter_cutoff_rad_per_s,
        discretization: settings.discretization.name().to_owned(),
        weights: settings.weights.name().to_owned(),
        position_cutoff_hz: reading.position_cutoff_hz,
        position_cutoff_choice: choice,
        position_filter_order: settings.position_filter_order,
    }
}

/// Returns the controller that output error simulates, if it is asked for.
fn loop_controller(experiment: &Experiment) -> Result<Option<&Controller>, IdentifyError> {
    if !(experiment.identify.estimator).contains(&Estimator::OutputError) {
        return Ok(None);
    }
    let controller = experiment.controller.as_ref();
    let controller = controller.ok_or(IdentifyError::Controller(
        "the experiment has no [controller]; give gains and reference of what ran during the log",
    ))?;
    if controller.kind == ControllerKind::StateFeedback
        && controller.feedforward == Feedforward::Identified
    {
        return Err(IdentifyError::Controller(
            "the feedforward of a controller that ran before cannot have used the parameters to be \
             identified; set feedforward = \"nominal\" in [controller]",
        ));
    }
    Ok(Some(controller))
}

/// Returns the values that a refinement starts from, if not those of least squares.
fn nominal_start(model: &Model, settings: &Identify) -> Result<Option<Theta>, IdentifyError> {
    match settings.start {
        StartName::LeastSquares => Ok(None),
        StartName::Nominal => model.nominal().map(Some).map_err(IdentifyError::Start),
    }
}

fn of_least_squares(model: &Model, system: &System, fitted: &Fitted, elapsed: f64) -> OfEstimator {
    OfEstimator {
        theta: fitted.theta.clone(),
        errors: fitted.standard_error.clone(),
        seen: fitted.identifiable.clone(),
        elapsed,
        points: trace(model, system).collect(),
        simulation: None,
        refinement: None,
        fallback: false,
        findings: vec![standard_error_of_stretches()],
    }
}

fn is_finite(model: &Model, system: &System, fitted: &Fitted) -> bool {
    let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
    finite(&fitted.theta)
        && finite(&fitted.standard_error)
        && (residual(model, system, &fitted.theta).iter())
            .all(|row| row.0.is_finite() && row.1.is_finite())
}

/// Returns the largest residual of a torque's row, as a part of its torque.
fn worst_residual(results: &[EstimateResult]) -> f64 {
    let first = results.first().into_iter();
    first
        .flat_map(|result| result.relative_residual.iter())
        .fold(0.0, |worst, (_, share)| worst.max(share))
}

fn standard_error_of_stretches() -> Finding {
    Finding::new(
        Severity::Info,
        "standard-error-of-stretches",
        "the standard errors say how much stretches of this log disagree; a bias that all \
         stretches share, as by quantised positions through the Coulomb transition or by a \
         disturbance, is not in them: ci95 is a lower bound of the interval"
            .to_owned(),
        "compare cut-offs and repeated experiments",
    )
}
