//! Prediction-error refinement: maximum likelihood on the innovations of an extended Kalman filter.
//!
//! The refinement needs neither controller nor reference, and only a rough start. Torques and links
//! may be disturbed. The levels of the disturbances are estimated from the log.
//!
//! # Source
//!
//! Ljung, System Identification, chapters 7 and 10; Åström, Automatica 1980: "Maximum likelihood
//! and prediction error methods".

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use super::channel_updates::ChannelUpdate;
use super::descent::{Descent, descend};
use super::dynamics::ScaleOfJoint;
use super::effects::TorquesTiming;
use super::expected_time::expected_seconds;
use super::finish::finish;
use super::levels::{Levels, UnknownLevels};
use super::measurements::{Extent, Measurements, RawSegment, build, read};
use super::presliding_levels::PreslidingLevel;
use super::problem::Problem;
use super::refined::Refined;
use super::residual_ratio::Guard;
use super::rung::Rung;
use super::start_levels::{Searches, TorqueNoise, levels_after, start_levels, with_sensor_noise};
use super::unknowns::Unknowns;
use crate::estimate::estimators::feasible::feasible;
use crate::estimate::estimators::least_squares::PossibleFit;
use crate::estimate::statistics::MAX_ROUNDS;
use crate::log::LogSource;
use crate::model::Theta;
use crate::prepare::Excerpt;
use crate::progress::{Listener, Phase, Stopped};
use crate::regression::{PassError, Reading};

/// Mean squared whitened innovation above which encoders get additional noise: their lines are
/// uneven, or the joint is not at the position of the model.
const MAX_COST_OF_EXACT_ENCODERS: f64 = 2.0;

/// Change without effect on an estimate: of a delay, in standard errors, and of the logarithm of a prior level.
const SETTLED: f64 = 0.1;

/// Largest change of a delay in a round, in samples or standard errors; its effect is linear only for small moves.
const MAX_DELAY_MOVE: f64 = 10.0;

/// Runs of the filter after which no further round or rung begins. A refinement of a log that the model explains ends after 6 to 30.
const MAX_RUNS: usize = 90;

/// Start of a refinement.
pub(super) struct Start<'a> {
    /// A parameter vector, \[p\].
    pub(super) theta: &'a [f64],
    /// Indices of the parameters to be refined.
    pub(super) free: Vec<usize>,
    pub(super) torque_noise: TorqueNoise,
    /// Treatment of the delay of all torques.
    pub(super) torques: TorquesTiming,
    /// Channels whose delays are to be estimated.
    pub(super) delays: Vec<usize>,
}

/// The inputs of all rungs.
pub(super) struct Refinery<'a> {
    pub(super) reading: &'a Reading,
    /// The beginning of the first log, for the noise of its channels.
    pub(super) excerpt: &'a Excerpt,
    pub(super) start: &'a Start<'a>,
    theta: Theta,
    phase: Phase,
    guard: Option<Guard<'a>>,
    /// Least squares over the robots that can exist; `None` without constraints.
    pub(super) possible: Option<&'a PossibleFit<'a>>,
    raw: Vec<RawSegment>,
    left_out: bool,
    /// The measurements that were used last, with the delays of their channels, s.
    made: Mutex<Option<(Vec<f64>, Arc<Measurements>)>>,
    /// Runs of the filter until now.
    runs: AtomicUsize,
}

/// End of the refinement on one rung.
pub(super) struct End {
    pub(super) refined: Refined,
    /// Values of the unknowns.
    pub(super) z: Vec<f64>,
    pub(super) levels: Levels,
    /// Delay of each channel, s.
    pub(super) delays: Vec<f64>,
    /// Prior levels of presliding friction.
    pub(super) presliding: Vec<PreslidingLevel>,
}

impl End {
    /// Returns the scales of friction laws that were estimated.
    pub(super) fn scales(&self) -> Vec<ScaleOfJoint> {
        (self.refined.scales.iter())
            .map(|scale| ScaleOfJoint {
                joint: scale.joint,
                scale: scale.scale,
                value: scale.value,
            })
            .collect()
    }
}

impl<'a> Refinery<'a> {
    /// Reads the logs.
    ///
    /// - `extent`: samples that are used.
    ///
    /// Returns `None` if no robot has parameters near the start.
    ///
    /// # Errors
    ///
    /// [`PassError`] if a log cannot be read.
    pub(super) fn new(
        reading: &'a Reading,
        sources: &mut [LogSource<'_>],
        excerpt: &'a Excerpt,
        start: &'a Start<'a>,
        (phase, extent): (Phase, Extent),
    ) -> Result<Option<Self>, PassError> {
        let (model, channels) = (reading.model(), reading.channels());
        let Ok(theta) = feasible(model, start.theta) else {
            return Ok(None);
        };
        let (raw, left_out) = read(channels, sources, extent)?;
        Ok(Some(Self {
            reading,
            excerpt,
            start,
            theta,
            phase,
            guard: None,
            possible: None,
            raw,
            left_out,
            made: Mutex::new(None),
            runs: AtomicUsize::new(0),
        }))
    }

    /// Returns the measurements with some delays of the channels, s; `None` if there are too few samples. Those that were
    /// used last are kept.
    ///
    /// # Errors
    ///
    /// [`PassError`] if the filter of positions does not fit a log.
    pub(super) fn measurements(
        &self,
        delays: &[f64],
    ) -> Result<Option<Arc<Measurements>>, PassError> {
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, measurements)) = made.as_ref().filter(|(of, _)| of == delays) {
            return Ok(Some(measurements.clone()));
        }
        // Two at a time would need twice the memory.
        *made = None;
        let reading = self.reading.with_delays(delays);
        let measurements = build(&reading, self.excerpt, &self.raw, self.left_out)?.map(Arc::new);
        *made = measurements
            .clone()
            .map(|measurements| (delays.to_vec(), measurements));
        Ok(measurements)
    }

    /// Returns whether no further round or rung may begin.
    pub(super) fn has_run_enough(&self) -> bool {
        self.runs.load(Ordering::Relaxed) > MAX_RUNS
    }

    /// Adds a comparison with least squares, which ends hopeless descents.
    pub(super) fn with_guard(self, guard: Option<Guard<'a>>) -> Self {
        Self { guard, ..self }
    }

    /// Keeps the parameters to those of robots that can exist.
    pub(super) fn with_possible(self, possible: Option<&'a PossibleFit<'a>>) -> Self {
        Self { possible, ..self }
    }

    /// Refines the parameters on one rung: measurements, start levels, descent, result. Repeats this while open delays
    /// or prior levels of presliding friction change.
    ///
    /// - `before`: end of an earlier rung, from which this one starts.
    /// - `progress`: is called before each run of the filter.
    ///
    /// Returns `None` if the logs are too short or the filter does not follow them from this start.
    ///
    /// # Errors
    ///
    /// [`PassError`] if the filter of positions does not fit a log, or the listener requests a
    /// stop.
    pub(super) fn climb(
        &self,
        rung: Rung,
        before: Option<&End>,
        progress: &mut dyn Listener,
    ) -> Result<Option<End>, PassError> {
        let (model, start) = (self.reading.model(), self.start);
        let mut delays = before
            .map_or(self.reading.delays(), |end| &end.delays)
            .to_vec();
        let mut last: Option<Descent> = None;
        let mut presliding = before.map(|end| end.presliding.clone());
        let noisy_rows = start.torque_noise.rows(model);
        for round in 1..=MAX_ROUNDS {
            let reading = self.reading.with_delays(&delays);
            let Some(measurements) = self.measurements(&delays)? else {
                return Ok(None);
            };
            let measurements = &*measurements;
            let mut unknowns = self.unknowns(measurements);
            if let Some(levels) = presliding.take() {
                unknowns = unknowns.with_presliding_levels(levels);
            }
            let (z, levels) = match last {
                None => self.first(rung, before, &unknowns, measurements),
                Some(descent) => (descent.z, descent.levels),
            };
            let searches = Searches::new(model, measurements, start.torque_noise, rung, &levels);
            let problem = Problem {
                model,
                measurements,
                unknowns: &unknowns,
                levels: &searches.shown,
                noisy_rows: &noisy_rows,
                // No lower rung follows the last one.
                guard: self.guard.as_ref().filter(|_| rung != Rung::Flat),
                robots: self.possible.map(|possible| &possible.robots),
            };
            if round == 1
                && before.is_none()
                && let Some(seconds) = expected_seconds(&problem, (&z, &levels))
            {
                progress.tell_expected(self.phase, seconds)?;
            }
            let every_sensor = &searches.every_sensor;
            let found =
                descend_with_noise(problem, every_sensor, (z, levels), self.phase, progress)?;
            let Some((descent, problem)) = found else {
                return Ok(None);
            };
            self.runs.fetch_add(descent.runs, Ordering::Relaxed);
            let Some(refined) =
                finish(&problem, &reading, (&start.delays, start.torques), &descent)
            else {
                return Ok(None);
            };
            let used = delays.clone();
            let moved = self.move_delays(&refined, &mut delays);
            let (levels, settled) = presliding_levels(&unknowns.presliding, &refined);
            if round == MAX_ROUNDS || self.has_run_enough() || !moved && settled {
                return Ok(Some(End {
                    refined,
                    z: descent.z,
                    levels: descent.levels,
                    delays: used,
                    presliding: levels,
                }));
            }
            presliding = Some(levels);
            last = Some(descent);
        }
        Ok(None)
    }

    /// Moves the delays that are to be estimated. Returns whether a delay was still far from its
    /// estimate.
    ///
    /// - `delays`: of all channels, s.
    fn move_delays(&self, refined: &Refined, delays: &mut [f64]) -> bool {
        let period = self.excerpt.period();
        let updates = || {
            (refined
                .channels
                .delays
                .iter()
                .chain(&refined.channels.torques_delay))
            .filter(|delay| delay.estimated)
        };
        let far =
            |update: &ChannelUpdate| update.correction.abs() > SETTLED * update.standard_error;
        for update in updates() {
            let reach = MAX_DELAY_MOVE * period.max(update.standard_error);
            let by = update.correction.clamp(-reach, reach);
            for (channel, delay) in delays.iter_mut().enumerate() {
                if update.place.contains(channel, self.reading.channels()) {
                    *delay += by;
                }
            }
        }
        updates().any(far)
    }

    fn unknowns(&self, measurements: &Measurements) -> Unknowns {
        let (model, channels) = (self.reading.model(), self.reading.channels());
        let free = self.start.free.clone();
        Unknowns::new(model, channels, measurements, &self.theta, free)
    }

    /// Returns unknowns and levels at the start of a rung.
    fn first(
        &self,
        rung: Rung,
        before: Option<&End>,
        unknowns: &Unknowns,
        measurements: &Measurements,
    ) -> (Vec<f64>, Levels) {
        let model = self.reading.model();
        let usual = start_levels(model, measurements, self.start.torque_noise, rung);
        match before {
            Some(end) if end.refined.free == unknowns.free && end.z.len() == unknowns.values() => {
                (end.z.clone(), levels_after(&end.levels, &usual, rung))
            }
            Some(_) | None => (unknowns.point(&self.theta), usual),
        }
    }
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

/// Returns the prior levels of presliding friction after a refinement, and whether they have settled.
fn presliding_levels(
    before: &[PreslidingLevel],
    refined: &Refined,
) -> (Vec<PreslidingLevel>, bool) {
    let values: Vec<f64> = refined.free.iter().map(|&i| refined.theta[i]).collect();
    let mut settled = true;
    let after = (before.iter())
        .map(|known| {
            let level = known.evidence(&values, &refined.covariance, values.len());
            settled &= (level / known.level).ln().abs() < SETTLED;
            PreslidingLevel {
                level,
                ..known.clone()
            }
        })
        .collect();
    (after, settled)
}
