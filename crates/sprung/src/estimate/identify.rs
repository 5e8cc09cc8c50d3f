//! The main job: one log in, parameters out.

use std::collections::BTreeMap;
use std::time::Instant;

use super::describe::{describe, fit_curves, trace_of};
use super::judge::{Verdict, judge};
use super::least_squares::{fit, residual, trace};
use super::lsff::{Lsff, LsffError};
use super::result::{DelayUsed, GENERATOR, Identification, LogInfo, SettingsUsed};
use super::second_look::{Delays, suspicions};
use crate::curves::Curves;
use crate::description::{Estimator, Experiment, Identify};
use crate::finding::{Finding, Severity};
use crate::log::{ChannelError, Channels, LogSource, check};
use crate::model::Model;
use crate::preprocess::{Decimator, RawSample};
use crate::regression::{FilteredSample, Observer, PassError, Passed, Reading, read_through};

/// Points of the fit over time, at most.
const FIT_POINTS: usize = 2048;

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
    /// LSFF cannot be built.
    #[error(transparent)]
    Lsff(#[from] LsffError),
    /// A delay cannot be estimated.
    #[error("{0}")]
    Delay(String),
    /// The log is wrong, or does not fit the filters.
    #[error(transparent)]
    Pass(#[from] PassError),
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
    let delays = Delays::new(&channels, model, settings, source)?;
    let reading = Reading {
        model,
        settings,
        channels: &channels,
        delays: &delays.values,
    };
    let mut watch = Watch::new(model, settings);
    let passed = read_through(&reading, source, &mut watch, progress)?;
    let mut findings =
        check(&source.name, &channels, model.joints(), &passed.summary).map_err(PassError::from)?;
    findings.extend(delays.findings(&channels));

    let fitted = fit(model, &passed.system)
        .filter(|fitted| {
            let rows = residual(model, &passed.system, &fitted.theta());
            let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
            finite(&fitted.solution.x)
                && finite(&fitted.standard_error)
                && rows
                    .iter()
                    .all(|row| row.0.is_finite() && row.1.is_finite())
        })
        .ok_or_else(|| IdentifyError::NotFinite {
            file: source.name.clone(),
        })?;
    let lsff = watch.lsff.transpose()?;
    let mut results = Vec::new();
    let mut traces = Vec::new();
    let mut thetas = Vec::new();
    for &estimator in &settings.estimator {
        let (theta, errors, elapsed, curves) = match (estimator, &lsff) {
            (Estimator::Lsff, Some(lsff)) => {
                let points = lsff.trace().iter();
                (
                    lsff.theta(),
                    lsff.wandering().to_vec(),
                    watch.elapsed,
                    trace_of(estimator, points.map(|(t, x)| (*t, Some(x.to_vec())))),
                )
            }
            _ => (
                fitted.theta(),
                fitted.standard_error.clone(),
                start.elapsed().as_secs_f64() - watch.elapsed,
                trace_of(estimator, trace(model, &passed.system)),
            ),
        };
        let mut result = describe(model, estimator, &theta, &errors, &fitted, &passed.system);
        result.elapsed_s = elapsed;
        let suspicions = suspicions(&reading, source, &result).map_err(PassError::from)?;
        let weakest = &fitted.solution.weakest_direction;
        result.warnings = judge(model, &result, weakest, &suspicions);
        result.warnings.extend(notes(estimator, lsff.as_ref()));
        result.verdict = Verdict::of(findings.iter().chain(&result.warnings));
        results.push(result);
        traces.push(curves);
        thetas.push((estimator, theta));
    }
    Ok(Identified {
        trace: Curves {
            columns: model.parameters().iter().map(|p| p.name.clone()).collect(),
            sets: traces,
        },
        fit: fit_curves(model, &thetas, watch.fit.items()),
        identification: Identification {
            format: 1,
            generator: GENERATOR.to_owned(),
            robot: experiment.robot.name.clone(),
            log: log_info(&log.name(&source.name), &passed, &delays, &channels),
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

/// What is gathered besides the system while the log passes.
struct Watch<'a> {
    model: &'a Model,
    settings: &'a Identify,
    fit: Decimator<FilteredSample>,
    lsff: Option<Result<Lsff, LsffError>>,
    // Time that LSFF took, s.
    elapsed: f64,
}

impl<'a> Watch<'a> {
    fn new(model: &'a Model, settings: &'a Identify) -> Self {
        Self {
            model,
            settings,
            fit: Decimator::new(FIT_POINTS),
            lsff: None,
            elapsed: 0.0,
        }
    }
}

impl Observer for Watch<'_> {
    fn raw(&mut self, period: f64, samples: &[RawSample]) {
        if !self.settings.estimator.contains(&Estimator::Lsff) {
            return;
        }
        let start = Instant::now();
        let (model, settings) = (self.model, self.settings);
        let lsff = self
            .lsff
            .get_or_insert_with(|| Lsff::new(model, settings, period));
        if let Ok(lsff) = lsff {
            for sample in samples {
                lsff.process(sample);
            }
        }
        self.elapsed += start.elapsed().as_secs_f64();
    }

    fn filtered(&mut self, sample: &FilteredSample) {
        self.fit.push(|| *sample);
    }
}

/// Says what the standard errors of an estimator are worth.
fn notes(estimator: Estimator, lsff: Option<&Lsff>) -> Vec<Finding> {
    let mut notes = vec![match estimator {
        Estimator::LeastSquares => Finding::new(
            Severity::Info,
            "standard-error-of-stretches",
            "the standard errors say how much stretches of this log disagree; repeated runs scatter \
             less, and a bias that all stretches share, as by quantised positions through the \
             Coulomb transition, is not in them: on the digital twin it reaches three of them"
                .to_owned(),
            "compare cut-offs and repeated experiments",
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
    if let (Estimator::Lsff, Some(lsff)) = (estimator, lsff)
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

fn log_info(file: &str, passed: &Passed, delays: &Delays, channels: &Channels) -> LogInfo {
    let delay_s: BTreeMap<String, DelayUsed> = (channels.all.iter().enumerate())
        .filter(|(_, channel)| channel.delay.is_some())
        .map(|(i, channel)| (channel.column.clone(), delays.used(i)))
        .collect();
    LogInfo {
        file: file.to_owned(),
        samples: passed.summary.samples(),
        period_s: passed.period,
        duration_s: passed.duration,
        jitter_percent: 100.0 * passed.jitter,
        delay_s,
    }
}
