//! The main job: one log in, parameters out.

use std::collections::BTreeMap;
use std::time::Instant;

use sprung_core::filter::FilterError;

use super::delay::{Excerpt, MotorRowFit, estimate_delays, fit_motor_rows};
use super::describe::{describe, fit_curves, trace_of};
use super::judge::{Suspicion, Verdict, judge, suspect};
use super::least_squares::{fit, trace};
use super::lsff::{Lsff, LsffError};
use super::result::{DelayUsed, EstimateResult, Identification, LogInfo, SettingsUsed};
use crate::curves::Curves;
use crate::description::{Delay, Estimator, Experiment, Identify, Log};
use crate::finding::{Finding, Severity};
use crate::log::{ChannelError, Channels, LogBlock, LogError, LogSource, Quantity, Summary, check};
use crate::model::{JOINT_COUNT, Model};
use crate::preprocess::{
    Aligner, Butterworth, Decimator, FilterDesignError, RawSample, Signal, Smoother,
};
use crate::regression::{FilteredRegression, FilteredSample, Reduction, System};

/// Points of the fit over time, at most.
const FIT_POINTS: usize = 2048;

/// Part of a residual that another reading of the log must stay below to be
/// mentioned.
const CLEARLY: f64 = 0.9;

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
    /// A filter does not fit the log.
    #[error(transparent)]
    FilterDesign(#[from] FilterDesignError),
    /// The filter pair cannot be built.
    #[error("{0}")]
    FilterPair(FilterError),
    /// LSFF cannot be built.
    #[error(transparent)]
    Lsff(#[from] LsffError),
    /// A delay cannot be estimated.
    #[error("{0}")]
    Delay(String),
    /// The log is wrong.
    #[error(transparent)]
    Log(#[from] LogError),
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

/// Identifies the parameters of a robot from a log.
///
/// The log is read once, block by block; memory does not grow with it. Delays
/// that are to be estimated, and suspicions about impossible results, cost a
/// second look at its beginning.
///
/// - `progress`: called with the number of samples read so far.
///
/// # Errors
///
/// [`IdentifyError`] if the description, the log or both together are wrong. A
/// poor fit is a result, not an error.
pub fn identify(
    experiment: &Experiment,
    model: &Model,
    source: &mut LogSource<'_>,
    progress: &mut dyn FnMut(u64),
) -> Result<Identified, IdentifyError> {
    let start = Instant::now();
    let log = experiment.log.as_ref().ok_or(IdentifyError::NoLog)?;
    let settings = &experiment.identify;
    let channels = Channels::new(&experiment.robot, log)?;
    let delays = delays(&channels, model, settings, source)?;

    let reduced = reduce(&channels, &delays, model, settings, source, progress)?;
    let mut findings = check(&source.name, &channels, model.joints(), &reduced.summary)?;
    let not_finite = || IdentifyError::NotFinite {
        file: source.name.clone(),
    };
    let fitted = fit(model, &reduced.system).ok_or_else(not_finite)?;
    if fitted.solution.x.iter().any(|value| !value.is_finite()) {
        return Err(not_finite());
    }

    findings.extend(delay_findings(&delays, &channels));
    let mut results = Vec::new();
    let mut trace_sets = Vec::new();
    let mut thetas = Vec::new();
    for &estimator in &settings.estimator {
        let (theta, errors, mut elapsed, set) = match (estimator, &reduced.lsff) {
            (Estimator::Lsff, Some((lsff, elapsed))) => (
                lsff.theta(),
                lsff.wandering().to_vec(),
                *elapsed,
                trace_of(
                    estimator,
                    lsff.trace().iter().map(|(t, x)| (*t, Some(x.to_vec()))),
                ),
            ),
            _ => (
                fitted.theta(),
                fitted.standard_error.clone(),
                0.0,
                trace_of(estimator, trace(model, &reduced.system)),
            ),
        };
        if estimator == Estimator::LeastSquares {
            elapsed = start.elapsed().as_secs_f64() - reduced.lsff.as_ref().map_or(0.0, |l| l.1);
        }
        let mut result = describe(model, estimator, &theta, &errors, &fitted, &reduced.system);
        result.elapsed_s = elapsed;
        let suspicions = suspicions(&channels, &delays, model, settings, source, &result)?;
        result.warnings = judge(
            model,
            &result,
            &fitted.solution.weakest_direction,
            &suspicions,
        );
        result.warnings.extend(notes(estimator, &reduced));
        result.verdict = Verdict::of(findings.iter().chain(&result.warnings));
        results.push(result);
        trace_sets.push(set);
        thetas.push((estimator, theta));
    }
    Ok(Identified {
        trace: Curves {
            columns: model.parameters().iter().map(|p| p.name.clone()).collect(),
            sets: trace_sets,
        },
        fit: fit_curves(model, &thetas, &reduced.fit),
        identification: Identification {
            format: 1,
            generator: concat!("sprung ", env!("CARGO_PKG_VERSION")).to_owned(),
            robot: experiment.robot.name.clone(),
            log: log_info(log, &source.name, &reduced, &delays, &channels),
            settings: SettingsUsed {
                filter_cutoff_rad_per_s: settings.filter_cutoff_rad_per_s,
                discretization: settings.discretization.name().to_owned(),
                position_cutoff_hz: settings.position_cutoff_hz,
                position_filter_order: settings.position_filter_order,
            },
            findings,
            results,
        },
    })
}

/// The log, read and reduced.
struct Reduced {
    system: System,
    summary: Summary,
    fit: Vec<FilteredSample>,
    lsff: Option<(Lsff, f64)>,
    period: f64,
    duration: f64,
    jitter: f64,
}

fn reduce(
    channels: &Channels,
    delays: &Delays,
    model: &Model,
    settings: &Identify,
    source: &mut LogSource<'_>,
    progress: &mut dyn FnMut(u64),
) -> Result<Reduced, IdentifyError> {
    let mut log = source.open(channels)?;
    let mut block = LogBlock::new(channels.all.len());
    log.read(&mut block)?;
    let period = log.clock().period().unwrap_or_default();

    let filter = Butterworth::new(
        settings.position_filter_order,
        settings.position_cutoff_hz,
        period,
    )?;
    let mut aligner = Aligner::new(channels, &delays.values, period);
    let mut smoother = Smoother::new(&filter, period);
    let mut regression = FilteredRegression::new(
        model.arm(),
        settings.filter_cutoff_rad_per_s,
        period,
        settings.discretization,
    )
    .map_err(IdentifyError::FilterPair)?;
    let mut lsff = if settings.estimator.contains(&Estimator::Lsff) {
        Some((Lsff::new(model, settings, period)?, 0.0))
    } else {
        None
    };
    let mut summary = Summary::new(channels);
    let mut reduction = Reduction::new(model);
    let mut fit = Decimator::new(FIT_POINTS);
    let mut take = |signals: &[Signal]| {
        for signal in signals {
            let sample = regression.process(signal.time, &signal.state, &signal.tau);
            reduction.push(&sample);
            fit.push(|| sample);
        }
    };
    let mut raw: Vec<RawSample> = Vec::new();
    let mut signals: Vec<Signal> = Vec::new();
    while !block.is_empty() {
        summary.take(&block);
        raw.clear();
        aligner.push(&block, &mut raw);
        if let Some((lsff, elapsed)) = &mut lsff {
            let start = Instant::now();
            for sample in &raw {
                lsff.process(sample);
            }
            *elapsed += start.elapsed().as_secs_f64();
        }
        signals.clear();
        smoother.push(&raw, &mut signals);
        take(&signals);
        progress(log.clock().samples());
        log.read(&mut block)?;
    }
    signals.clear();
    if !smoother.finish(&mut signals) {
        return Err(LogError::TooShort {
            file: source.name.clone(),
            found: log.clock().samples(),
            needed: (filter.padding() + aligner.lost()) as u64 + 3,
            why: format!(
                "three periods of position_cutoff_hz = {} pad each end of the zero-phase filter",
                settings.position_cutoff_hz
            ),
        }
        .into());
    }
    take(&signals);
    Ok(Reduced {
        system: reduction.finish(),
        summary,
        fit: fit.into_items(),
        lsff,
        period,
        duration: log.clock().duration(),
        jitter: log.clock().jitter(),
    })
}

/// Delays in use, s, one per channel, with errors of those estimated.
struct Delays {
    values: Vec<f64>,
    errors: Vec<Option<f64>>,
    gains: Vec<Option<(f64, f64)>>,
}

fn delays(
    channels: &Channels,
    model: &Model,
    settings: &Identify,
    source: &mut LogSource<'_>,
) -> Result<Delays, IdentifyError> {
    let count = channels.all.len();
    let mut delays = Delays {
        values: vec![0.0; count],
        errors: vec![None; count],
        gains: vec![None; count],
    };
    let mut wanted = Vec::new();
    for (i, channel) in channels.all.iter().enumerate() {
        match channel.delay {
            Some(Delay::Known(value)) => delays.values[i] = value,
            Some(Delay::Estimate) => wanted.push(i),
            None => {}
        }
    }
    if wanted.is_empty() {
        return Ok(delays);
    }
    for joint in 0..JOINT_COUNT {
        let mine = wanted.iter().filter(|&&i| channels.all[i].joint == joint);
        if mine.count() > 1 {
            return Err(IdentifyError::Delay(format!(
                "delay_s asks to estimate two channels of {}; only delays between channels show in \
                 a log, so estimate one of them",
                model.joints()[joint]
            )));
        }
    }
    let excerpt = excerpt(channels, source)?;
    let found = estimate_delays(&excerpt, channels, &wanted, model, settings).ok_or_else(|| {
        IdentifyError::Delay(format!(
            "{} is too short to estimate a delay from; give the delay as a number of seconds",
            source.name
        ))
    })?;
    for estimate in found {
        delays.values[estimate.channel] = estimate.delay;
        delays.errors[estimate.channel] = Some(estimate.standard_error);
        delays.gains[estimate.channel] = Some((
            estimate.without.relative_residual,
            estimate.with.relative_residual,
        ));
    }
    Ok(delays)
}

fn excerpt(channels: &Channels, source: &mut LogSource<'_>) -> Result<Excerpt, LogError> {
    let mut log = source.open(channels)?;
    let mut block = LogBlock::new(channels.all.len());
    let mut more = log.read(&mut block)?;
    let mut excerpt = Excerpt::new(log.clock().period().unwrap_or_default());
    while more {
        more = excerpt.push(&block) && log.read(&mut block)?;
    }
    Ok(excerpt)
}

fn delay_findings(delays: &Delays, channels: &Channels) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (i, channel) in channels.all.iter().enumerate() {
        if let (Some(error), Some((without, with))) = (delays.errors[i], delays.gains[i]) {
            findings.push(Finding::new(
                Severity::Info,
                "delay-estimated",
                format!(
                    "\"{}\" was recorded {:.4} s late (standard error {:.4} s): with that the motor \
                     row leaves {:.1} % of its torque unexplained, without it {:.1} % (root mean \
                     squares)",
                    channel.column,
                    delays.values[i],
                    error,
                    100.0 * with,
                    100.0 * without
                ),
                "give the delay as a number to keep it fixed",
            ));
        }
    }
    findings
}

/// Looks at the log again for joints whose parameters are impossible.
fn suspicions(
    channels: &Channels,
    delays: &Delays,
    model: &Model,
    settings: &Identify,
    source: &mut LogSource<'_>,
    result: &EstimateResult,
) -> Result<Vec<Suspicion>, IdentifyError> {
    let mut all = vec![Suspicion::default(); JOINT_COUNT];
    if !(0..JOINT_COUNT).any(|joint| suspect(result, joint)) {
        return Ok(all);
    }
    let excerpt = excerpt(channels, source)?;
    let now = fit_motor_rows(&excerpt, channels, &delays.values, model, settings);
    for (joint, suspicion) in all.iter_mut().enumerate() {
        let (true, Some(now)) = (suspect(result, joint), now) else {
            continue;
        };
        let better = |fit: &MotorRowFit| {
            let positive = fit.values.iter().all(|value| *value > 0.0);
            positive && fit.relative_residual < CLEARLY * now[joint].relative_residual
        };
        if let Some(exchanged) = channels.exchanged(joint) {
            suspicion.exchanged =
                fit_motor_rows(&excerpt, &exchanged, &delays.values, model, settings)
                    .map(|fits| fits[joint])
                    .filter(better);
        }
        if suspicion.exchanged.is_some() {
            continue;
        }
        let link = channels
            .index(Quantity::LinkPosition, joint)
            .or(channels.index(Quantity::LinkDeflection, joint));
        let Some(link) = link.filter(|&i| channels.all[i].delay.is_none()) else {
            continue;
        };
        suspicion.delay = estimate_delays(&excerpt, channels, &[link], model, settings)
            .and_then(|mut found| found.pop())
            .filter(|found| better(&found.with) && found.delay.abs() > 3.0 * found.standard_error)
            .map(|found| (channels.all[link].column.clone(), found));
    }
    Ok(all)
}

/// Says what the standard errors of an estimator are worth.
fn notes(estimator: Estimator, reduced: &Reduced) -> Vec<Finding> {
    let mut notes = vec![match estimator {
        Estimator::LeastSquares => Finding::new(
            Severity::Info,
            "standard-error-is-lower-bound",
            "the standard errors come from the scatter between stretches of the log; the bias that \
             quantised positions cause through the Coulomb transition is not in them"
                .to_owned(),
            "read them as lower bounds; compare cut-offs and repeated experiments",
        ),
        Estimator::Lsff => Finding::new(
            Severity::Info,
            "standard-error-is-wandering",
            "the standard errors of LSFF are how far the running estimate wandered over its last \
             memory; bias by the noise of on-line velocities is not in them"
                .to_owned(),
            "prefer least squares on filtered positions where the log is at hand",
        ),
    }];
    if let (Estimator::Lsff, Some((lsff, _))) = (estimator, &reduced.lsff)
        && lsff.paused() > 0.0
    {
        notes.push(Finding::new(
            Severity::Warning,
            "wind-up",
            format!(
                "forgetting was paused in {:.0} % of the samples, because directions without \
                 excitation wound the gain matrix up",
                100.0 * lsff.paused()
            ),
            "excite all joints, or choose a smaller lsff_forgetting_per_s",
        ));
    }
    notes
}

fn log_info(
    log: &Log,
    name: &str,
    reduced: &Reduced,
    delays: &Delays,
    channels: &Channels,
) -> LogInfo {
    let delay_s: BTreeMap<String, DelayUsed> = (channels.all.iter().enumerate())
        .filter(|(_, channel)| channel.delay.is_some())
        .map(|(i, channel)| {
            let used = DelayUsed {
                value: delays.values[i],
                standard_error: delays.errors[i].filter(|e| e.is_finite()),
            };
            (channel.column.clone(), used)
        })
        .collect();
    LogInfo {
        file: log
            .file
            .as_ref()
            .map_or_else(|| name.to_owned(), |file| file.display().to_string()),
        samples: reduced.summary.samples(),
        period_s: reduced.period,
        duration_s: reduced.duration,
        jitter_percent: 100.0 * reduced.jitter,
        delay_s,
    }
}
