//! Prediction-error refinement: maximum likelihood on the innovations of an extended Kalman filter.
//!
//! The refinement needs neither controller nor reference, and only a fair start. Torques and links
//! may be disturbed. The levels of the disturbances are estimated from the log.
//!
//! # Source
//!
//! Ljung, System Identification, chapters 7 and 10; Åström, Automatica 1980: "Maximum likelihood
//! and prediction error methods".

use super::delay_updates::DelayUpdate;
use super::descent::{Descent, descend};
use super::finish::finish;
use super::levels::{Levels, UnknownLevels};
use super::measurements::{build, max_samples, read};
use super::problem::Problem;
use super::refined::Refined;
use super::start_levels::{Searches, TorqueNoise, start_levels, with_sensor_noise};
use super::unknowns::Unknowns;
use crate::estimate::start::feasible;
use crate::log::LogSource;
use crate::prepare::Excerpt;
use crate::progress::{Listener, Phase, Stopped};
use crate::regression::{PassError, Reading};

/// Mean squared whitened innovation above which encoders get additional noise: their lines are
/// uneven, or the joint is not where the model has it.
const MAX_COST_OF_EXACT_ENCODERS: f64 = 2.0;

/// Maximum number of rounds in which delays are estimated; maximum remaining error of a delay, in
/// standard errors; and maximum move of a delay in one round, in samples or standard errors. The
/// effect of a delay is linear only for small moves.
const MAX_DELAY_ROUNDS: usize = 6;
const DELAY_TOLERANCE_SIGMAS: f64 = 0.1;
const MAX_DELAY_MOVE: f64 = 10.0;

/// Start of a refinement.
pub(super) struct Start<'a> {
    /// A parameter vector, \[p\].
    pub(super) theta: &'a [f64],
    /// Indices of the parameters to be refined.
    pub(super) free: Vec<usize>,
    pub(super) torque_noise: TorqueNoise,
    /// Channels whose delays are to be estimated.
    pub(super) delays: Vec<usize>,
}

/// Refines parameters from a start: measurements, start levels, descent, result. Repeats this while
/// delays that are to be estimated move.
///
/// - `excerpt`: the beginning of the first log, for the noise of its channels.
/// - `progress`: is called before each run of the filter, with `phase`.
///
/// Returns `None` if the logs are too short or the filter does not follow them from this start.
///
/// # Errors
///
/// [`PassError`] if a log cannot be read, the filter of positions does not fit it, or the listener
/// asks to stop.
pub(super) fn refine(
    reading: &Reading,
    sources: &mut [LogSource<'_>],
    excerpt: &Excerpt,
    start: &Start<'_>,
    phase: Phase,
    progress: &mut dyn Listener,
) -> Result<Option<Refined>, PassError> {
    let (model, channels) = (reading.model(), reading.channels());
    let (raw, left_out) = read(channels, sources, max_samples(model.rows()))?;
    let Ok((theta, _)) = feasible(model, start.theta) else {
        return Ok(None);
    };
    let mut delays = reading.delays().to_vec();
    let mut before: Option<Descent> = None;
    for round in 1.. {
        let reading = reading.with_delays(&delays);
        let Some(measurements) = build(&reading, excerpt, &raw, left_out)? else {
            return Ok(None);
        };
        let unknowns = Unknowns::new(model, channels, &measurements, &theta, start.free.clone());
        let (z, levels) = match before {
            None => (
                unknowns.point(&theta),
                start_levels(model, &measurements, start.torque_noise),
            ),
            Some(descent) => (descent.z, descent.levels),
        };
        let searches = Searches::new(model, &measurements, start.torque_noise, &levels);
        let problem = Problem {
            model,
            measurements: &measurements,
            unknowns: &unknowns,
            levels: &searches.shown,
        };
        let every_sensor = &searches.every_sensor;
        let found = descend_with_noise(problem, every_sensor, (z, levels), phase, progress)?;
        let Some((descent, problem)) = found else {
            return Ok(None);
        };
        let Some(found) = finish(&problem, &reading, &start.delays, &descent) else {
            return Ok(None);
        };
        if round == MAX_DELAY_ROUNDS || !move_delays(&found.delays, excerpt.period(), &mut delays) {
            return Ok(Some(found));
        }
        before = Some(descent);
    }
    Ok(None)
}

/// Descends with noise only of the sensors that show noise. If the filter then does not follow the
/// log, descends with noise of every sensor. Returns the end of the descent with its problem.
fn descend_with_noise<'p>(
    problem: Problem<'p>,
    every_sensor: &'p UnknownLevels,
    start: (Vec<f64>, Levels),
    phase: Phase,
    progress: &mut dyn Listener,
) -> Result<Option<(Descent, Problem<'p>)>, Stopped> {
    let descent = descend(&problem, start.clone(), phase, progress)?;
    let fits_badly = |d: &Descent| d.cost > MAX_COST_OF_EXACT_ENCODERS * d.measurements as f64;
    let same = problem.levels.all.len() == every_sensor.all.len();
    if same || !descent.as_ref().is_none_or(fits_badly) {
        return Ok(descent.map(|descent| (descent, problem)));
    }
    let problem = Problem {
        levels: every_sensor,
        ..problem
    };
    let (z, levels) = descent.map_or(start, |d| (d.z, d.levels));
    let levels = with_sensor_noise(levels, problem.measurements);
    let descent = descend(&problem, (z, levels), phase, progress)?;
    Ok(descent.map(|descent| (descent, problem)))
}

/// Moves the delays that are to be estimated. Returns whether a delay was still far from its
/// estimate.
///
/// - `period`: s; `delays`: delays of all channels, s.
fn move_delays(updates: &[DelayUpdate], period: f64, delays: &mut [f64]) -> bool {
    let estimated = || updates.iter().filter(|update| update.estimated);
    let far = |update: &DelayUpdate| {
        update.correction.abs() > DELAY_TOLERANCE_SIGMAS * update.standard_error
    };
    for update in estimated() {
        let reach = MAX_DELAY_MOVE * period.max(update.standard_error);
        delays[update.channel] += update.correction.clamp(-reach, reach);
    }
    estimated().any(far)
}
