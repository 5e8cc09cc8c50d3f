//! Prediction-error refinement: maximum likelihood on the innovations of an
//! extended Kalman filter.
//!
//! It needs no controller, no reference and no more than a fair start. Torque and
//! links may be disturbed; how much, the log says.
//!
//! # Source
//!
//! Ljung, System Identification, chapters 7 and 10; Åström, Automatica 1980:
//! "Maximum likelihood and prediction error methods".

use super::descent::{Descent, Problem};
use super::dynamics::Dynamics;
use super::filter::{Levels, Wanted, run};
use super::levels::Search;
use super::measurements::{Noise, Raw, Record};
use super::unknowns::Unknowns;
use super::{dynamics, filter, levels as level, measurements, solve};
use crate::estimate::start::feasible;
use crate::log::LogSource;
use crate::model::{Model, Theta};
use crate::prepare::{Excerpt, noise as noise_of};
use crate::preprocess::Butterworth;
use crate::progress::{Listener, Phase, Stopped};
use crate::regression::{PassError, Reading};

/// Samples times rows times rows that the filter goes through, at most: its work
/// grows with the rows, and more would take minutes and tell little.
const MOST: usize = 2_400_000;

/// Returns how many samples the filter goes through at most.
pub(super) fn most_samples(rows: usize) -> usize {
    MOST / (rows * rows).max(1)
}

/// Levels that the search starts from, as parts of the torque's standard deviation:
/// of motor torques, and of torques on links.
const START_MOTOR: f64 = 0.01;
const START_LINK: f64 = 0.003;

/// Noise of a sensor without counts that the search starts from, as a part of what
/// it shows, and innovations over their standard deviations (squares, mean) beyond
/// which counters have noise as well: their lines are not even, or the joint is not
/// where the model has it.
const START_SENSOR: f64 = 1e-3;
const ROUGH: f64 = 2.0;

/// White noise of a torque that is said to be exact, likewise.
const EXACT: f64 = 1e-3;

/// Noise of positions that show none, rad (m).
const FINEST: f64 = 1e-9;

/// Rounds in which delays are found, the part of its standard error that a delay
/// may be off after the last, and how far it may move in one, in samples or
/// standard errors.
const ROUNDS: usize = 6;
const CLOSE: f64 = 0.1;
const REACH: f64 = 10.0;

/// Points of a trace, at most.
const TRACE: usize = 60;

/// What a refinement finds.
#[derive(Clone, Debug)]
pub(super) struct Refined {
    /// The parameter vector, known values included, \[p\].
    pub(super) theta: Theta,
    /// Standard error of each parameter; zero for known ones, infinite where the
    /// log says nothing.
    pub(super) standard_error: Vec<f64>,
    /// Indices in theta of the parameters that were refined.
    pub(super) free: Vec<usize>,
    /// Covariance of these, \[free × free\].
    pub(super) covariance: Vec<f64>,
    /// Whether the search ended by itself.
    pub(super) converged: bool,
    /// Runs of the filter.
    pub(super) runs: usize,
    /// The parameters, index in theta, that moved last, and by how many standard
    /// errors, the largest first.
    pub(super) moved: Vec<(usize, f64)>,
    /// Minus the logarithm of the likelihood, without its constant.
    pub(super) loss: f64,
    /// Measurements that were used.
    pub(super) measurements: u64,
    /// Samples that were used.
    pub(super) samples: usize,
    /// Time that they span, s.
    pub(super) duration: f64,
    /// Whether the logs hold more.
    pub(super) left_out: bool,
    /// Levels of noise and disturbances, one per row of the regressor.
    pub(super) levels: Vec<RowLevel>,
    /// Corner of the disturbances' spectrum, Hz.
    pub(super) corner: f64,
    /// Noise of sensors beyond what their samples show: channel, standard
    /// deviation, and that of what they show, rad (m).
    pub(super) sensors: Vec<(usize, f64, f64)>,
    /// Whitened innovations squared, mean.
    pub(super) cost: f64,
    /// By how much a sensor reads too much: joint, channel, value and standard
    /// error, rad (m).
    pub(super) offsets: Vec<(usize, usize, f64, f64)>,
    /// What the log says of delays, one per channel.
    pub(super) delays: Vec<ChannelDelay>,
    /// Parameter vectors of growing parts of the log, by their end in s.
    pub(super) trace: Vec<(f64, Theta)>,
    /// What each of several logs says alone: value and standard error of each
    /// refined parameter.
    pub(super) logs: Vec<Vec<(f64, f64)>>,
}

/// Noise and disturbance of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RowLevel {
    /// Standard deviation of white torque noise, N·m (N); zero in link rows.
    pub(super) white: f64,
    /// Standard deviation of the disturbance, N·m (N).
    pub(super) drift: f64,
    /// Standard deviation of the torque of the row's joint, N·m (N).
    pub(super) torque: f64,
    /// Whether the disturbance ended at its upper bound.
    pub(super) at_bound: bool,
}

/// What the likelihood says of the delay of a channel against the others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ChannelDelay {
    /// Index in [`Channels::all`].
    pub(super) channel: usize,
    /// What was assumed, s.
    pub(super) assumed: f64,
    /// How much later than that it was recorded, s.
    pub(super) beyond: f64,
    /// Its standard error, s.
    pub(super) standard_error: f64,
    /// Whether it was to be estimated.
    pub(super) wanted: bool,
}

/// What there is to refine from.
pub(super) struct Start<'a> {
    /// A parameter vector, \[p\].
    pub(super) theta: &'a [f64],
    /// Indices of the parameters to refine.
    pub(super) free: Vec<usize>,
    /// Whether the logged torque is what acted.
    pub(super) exact_torque: bool,
    /// Channels whose delays are to be found.
    pub(super) delays: Vec<usize>,
}

/// Refines parameters from a start.
///
/// - `excerpt`: the beginning of the first log, for the noise of its channels.
/// - `progress`: told of each run of the filter, as part of a phase.
///
/// Returns nothing if the logs are too short, or the filter does not follow them
/// from this start.
///
/// # Errors
///
/// [`PassError`] if a log cannot be read, or the filter does not fit it.
pub(super) fn refine(
    reading: &Reading,
    sources: &mut [LogSource<'_>],
    excerpt: &Excerpt,
    start: &Start<'_>,
    phase: Phase,
    progress: &mut dyn Listener,
) -> Result<Option<Refined>, PassError> {
    let (model, channels) = (reading.model(), reading.channels());
    let limit = most_samples(model.rows());
    let (raw, left_out) = measurements::read(channels, sources, limit)?;
    let Ok((theta, _)) = feasible(model, start.theta) else {
        return Ok(None);
    };
    let mut delays = reading.delays().to_vec();
    let mut before: Option<Descent> = None;
    for round in 1.. {
        let reading = reading.with_delays(&delays);
        let Some(record) = build(&reading, excerpt, &raw, left_out)? else {
            return Ok(None);
        };
        let unknowns = Unknowns::new(model, channels, &record, &theta, start.free.clone());
        let (z, levels) = match &before {
            None => (
                unknowns.point(&theta),
                first_levels(model, &record, start.exact_torque),
            ),
            Some(descent) => (descent.z.clone(), descent.levels.clone()),
        };
        let searches = searches(model, &record, start.exact_torque, &levels);
        let problem = |search| Problem {
            model,
            record: &record,
            unknowns: &unknowns,
            search,
        };
        let Some((descent, search)) = descend(&problem, &searches, (z, levels), phase, progress)?
        else {
            return Ok(None);
        };
        let problem = problem(search);
        let found = finish(&problem, &reading, start, &descent);
        let Some(found) = found else { return Ok(None) };
        // What a delay does is linear nearby only.
        let far = |d: &&ChannelDelay| d.wanted && d.beyond.abs() > CLOSE * d.standard_error;
        if round == ROUNDS || !found.delays.iter().any(|d| far(&d)) {
            return Ok(Some(found));
        }
        for delay in found.delays.iter().filter(|d| d.wanted) {
            let reach = REACH * excerpt.period().max(delay.standard_error);
            delays[delay.channel] += delay.beyond.clamp(-reach, reach);
        }
        before = Some(descent);
    }
    Ok(None)
}

/// Returns the levels to search: with noise of the sensors that show some, and of
/// every sensor.
fn searches(model: &Model, record: &Record, exact_torque: bool, levels: &Levels) -> [Search; 2] {
    let torques: Vec<bool> = (0..model.rows())
        .map(|row| model.is_torque_row(row) && !exact_torque)
        .collect();
    let sensors: Vec<bool> = (record.sensors.iter().zip(&levels.sensor))
        .map(|(sensor, level)| matches!(sensor.noise, Noise::White(_)) || *level > 0.0)
        .collect();
    let every = vec![true; sensors.len()];
    [&sensors, &every].map(|sensors| Search::new(record, &torques, sensors))
}

/// Descends with the noise that sensors show, and if the filter then does not follow,
/// with noise of every sensor; returns where it ended and with which levels.
fn descend<'p>(
    problem: &impl Fn(&'p Search) -> Problem<'p>,
    [shown, every]: &'p [Search; 2],
    (z, levels): (Vec<f64>, Levels),
    phase: Phase,
    progress: &mut dyn Listener,
) -> Result<Option<(Descent, &'p Search)>, Stopped> {
    let first = problem(shown);
    let scales = first.record.sensors.iter().map(|sensor| sensor.scale);
    let descent = first.descend(&z, &levels, phase, progress)?;
    let rough = |d: &Descent| d.cost > ROUGH * d.measurements as f64;
    if !descent.as_ref().is_none_or(rough) || shown.all.len() == every.all.len() {
        return Ok(descent.map(|descent| (descent, shown)));
    }
    let (z, mut levels) = descent.map_or((z, levels), |d| (d.z, d.levels));
    for (level, scale) in levels.sensor.iter_mut().zip(scales) {
        *level = level.max(START_SENSOR * scale);
    }
    let descent = problem(every).descend(&z, &levels, phase, progress)?;
    Ok(descent.map(|descent| (descent, every)))
}

pub(super) fn build(
    reading: &Reading,
    excerpt: &Excerpt,
    raw: &[Raw],
    left_out: bool,
) -> Result<Option<Record>, PassError> {
    let (model, channels) = (reading.model(), reading.channels());
    let of_channel = |i: usize| match noise_of(excerpt, i) {
        Some((_, Some(step))) => Noise::Counts(step),
        Some((deviation, None)) => Noise::White(deviation.max(FINEST)),
        None => Noise::White(FINEST),
    };
    let sensors = measurements::sensors(model, channels, raw, of_channel);
    let order = reading.settings().position_filter_order;
    let mut stretches = Vec::new();
    for raw in raw {
        let filter = Butterworth::new(order, reading.position_cutoff_hz(), raw.period())?;
        let delays = reading.delays();
        stretches.extend(measurements::stretch(
            raw, model, channels, &sensors, delays, &filter,
        ));
    }
    if stretches.is_empty() {
        return Ok(None);
    }
    let torque_scale = measurements::torque_scale(model, &stretches);
    Ok(Some(Record {
        sensors,
        stretches,
        torque_scale,
        left_out,
    }))
}

fn first_levels(model: &Model, record: &Record, exact_torque: bool) -> Levels {
    let scales = record.torque_scale.iter().enumerate();
    let of = |torque: f64, link: f64| -> Vec<f64> {
        (scales.clone())
            .map(|(row, scale)| {
                scale
                    * if model.is_torque_row(row) {
                        torque
                    } else {
                        link
                    }
            })
            .collect()
    };
    Levels {
        white: of(if exact_torque { EXACT } else { START_MOTOR }, 0.0),
        drift: of(START_MOTOR, START_LINK),
        corner: level::CORNER,
        sensor: (record.sensors.iter())
            .map(|sensor| match sensor.noise {
                Noise::Counts(_) => 0.0,
                Noise::White(_) => START_SENSOR * sensor.scale,
            })
            .collect(),
    }
}

/// Turns the end of a descent into a result.
fn finish(
    problem: &Problem<'_>,
    reading: &Reading,
    start: &Start<'_>,
    descent: &Descent,
) -> Option<Refined> {
    let (model, record) = (problem.model, problem.record);
    let all =
        (problem.unknowns.clone()).with_delays(model, reading.channels(), record, &start.delays);
    let mut dynamics = Dynamics::new(model, &all.theta(&descent.z));
    let wanted = Wanted {
        transitions: 0,
        growing: TRACE,
    };
    let (mut outcome, _) = run(
        record,
        &mut dynamics,
        &all,
        &descent.z,
        &descent.levels,
        wanted,
    )?;
    problem.with_prior(&descent.z, &mut outcome.normal);
    dynamics::add(&mut outcome.normal.gradient, -1.0, &descent.by_noise);
    // Delays that were found cost the others precision.
    let values = all.values();
    let count = values + start.delays.len();
    let normal = outcome.normal.first(count);
    let covariance = solve::covariance(&normal.information, count)?;
    let free = all.free.clone();
    let theta = all.theta(&descent.z);
    let mut standard_error = vec![f64::INFINITY; theta.len()];
    for (index, parameter) in model.parameters().iter().enumerate() {
        if parameter.fixed.is_some() {
            standard_error[index] = 0.0;
        }
    }
    let error = |place: usize| covariance[place * (count + 1)].sqrt();
    for (place, &index) in free.iter().enumerate() {
        standard_error[index] = error(place);
    }
    let trace = (outcome.growing.iter())
        .filter_map(|(time, so_far)| {
            let share = time / record.duration();
            let (z, _) = alone(problem, descent, so_far, share)?;
            Some((*time, all.theta(&z)))
        })
        .collect();
    let logs = (outcome.logs.iter().enumerate())
        .filter_map(|(log, own)| {
            let (z, covariance) = alone(problem, descent, own, record.share(log))?;
            let error = |i: usize| covariance[i * (values + 1)].sqrt();
            Some((0..free.len()).map(|i| (z[i], error(i))).collect())
        })
        .collect();
    let mut moved: Vec<(usize, f64)> = free.iter().copied().zip(descent.moved.clone()).collect();
    moved.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    let width = free.len();
    Some(Refined {
        covariance: (0..width * width)
            .map(|at| covariance[at / width * count + at % width])
            .collect(),
        theta,
        standard_error,
        converged: descent.converged,
        runs: descent.runs,
        moved,
        loss: outcome.loss,
        measurements: outcome.measurements,
        samples: record.samples(),
        duration: record.duration(),
        left_out: record.left_out,
        levels: row_levels(problem, &descent.levels),
        corner: descent.levels.corner,
        sensors: (record.sensors.iter().zip(&descent.levels.sensor))
            .filter(|(_, level)| **level > 0.0)
            .map(|(sensor, level)| (sensor.channel, *level, sensor.scale))
            .collect(),
        cost: outcome.cost / outcome.measurements.max(1) as f64,
        offsets: (all.offsets.iter().enumerate())
            .map(|(i, offset)| {
                let channel = record.sensors[offset.sensor].channel;
                let at = width + i;
                (offset.joint, channel, descent.z[at], error(at))
            })
            .collect(),
        delays: delays(&all, &outcome.normal, &covariance, count, reading.delays()),
        trace,
        logs,
        free,
    })
}

/// Returns what part of the measurements says: one step from where all lead, and
/// its covariance.
///
/// - `share`: of all samples.
fn alone(
    problem: &Problem<'_>,
    descent: &Descent,
    part: &filter::Normal,
    share: f64,
) -> Option<(Vec<f64>, Vec<f64>)> {
    let values = problem.unknowns.values();
    let mut part = part.first(values);
    problem.with_prior(&descent.z, &mut part);
    dynamics::add(&mut part.gradient, -share, &descent.by_noise);
    let step = solve::damped_step(&part.information, &part.gradient, 0.0)?;
    let z = descent.z.iter().zip(&step).map(|(x, d)| x + d).collect();
    Some((z, solve::covariance(&part.information, values)?))
}

fn row_levels(problem: &Problem<'_>, levels: &Levels) -> Vec<RowLevel> {
    let bound: Vec<level::Level> = problem.search.at_bound(levels).collect();
    (0..levels.drift.len())
        .map(|row| RowLevel {
            white: levels.white[row],
            drift: levels.drift[row],
            torque: problem.record.torque_scale[row],
            // Positions may show so little of the white noise that any level will do; what
            // a model lacks is slower.
            at_bound: bound.contains(&level::Level::Drift(row)),
        })
        .collect()
}

/// Returns what one step of Gauss-Newton says of each delay, the other unknowns
/// following; of those that were not wanted, each alone.
fn delays(
    unknowns: &Unknowns,
    normal: &filter::Normal,
    covariance: &[f64],
    count: usize,
    assumed: &[f64],
) -> Vec<ChannelDelay> {
    let values = unknowns.values();
    (unknowns.delayed().enumerate())
        .map(|(i, channel)| {
            let at = values + i;
            let wanted = at < count;
            // Those that follow: all but itself.
            let mut information = normal.information[at * (normal.count + 1)];
            let mut gradient = normal.gradient[at];
            if wanted {
                let row = &covariance[at * count..(at + 1) * count];
                let step: f64 = row.iter().zip(&normal.gradient).map(|(c, g)| c * g).sum();
                information = covariance[at * (count + 1)].recip();
                gradient = step * information;
            } else {
                let cross = &normal.information[at * normal.count..at * normal.count + count];
                for (j, a) in cross.iter().enumerate() {
                    let row = &covariance[j * count..(j + 1) * count];
                    for (k, factor) in row.iter().enumerate() {
                        information -= a * factor * cross[k];
                        gradient -= a * factor * normal.gradient[k];
                    }
                }
            }
            ChannelDelay {
                channel,
                assumed: assumed[channel],
                beyond: -gradient / information,
                standard_error: information.max(0.0).sqrt().recip(),
                wanted,
            }
        })
        .collect()
}
