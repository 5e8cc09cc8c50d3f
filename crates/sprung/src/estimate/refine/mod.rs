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

mod dynamics;
mod kalman;
mod newton;
mod noise;
mod record;
mod solve;
#[cfg(test)]
mod tests;
mod unknowns;

use sprung_core::parameters::JointParameter;

use super::cutoff::noise;
use super::delay::Excerpt;
use crate::log::{Channels, LogSource};
use crate::model::{Model, Theta};
use crate::preprocess::Butterworth;
use crate::regression::{PassError, Reading};
use dynamics::Dynamics;
use kalman::{Levels, Wanted, run};
use newton::{Descent, Problem};
use noise::Search;
use record::{Noise, Raw, Record};
use unknowns::Unknowns;

/// Samples times rows that the filter goes through, at most: more would take
/// minutes and tell little.
const MOST: usize = 300_000;

/// Levels that the search starts from, as parts of the torque's standard deviation:
/// of motor torques, and of torques on links.
const START_MOTOR: f64 = 0.01;
const START_LINK: f64 = 0.003;

/// White noise of a torque that is said to be exact, likewise.
const EXACT: f64 = 1e-3;

/// Noise of positions that show none, rad (m).
const FINEST: f64 = 1e-9;

/// Points of a trace, at most.
const TRACE: usize = 60;

/// What a refinement finds.
#[derive(Clone, Debug)]
pub struct Refined {
    /// The parameter vector, known values included, \[p\].
    pub theta: Theta,
    /// Standard error of each parameter; zero for known ones, infinite where the
    /// log says nothing.
    pub standard_error: Vec<f64>,
    /// Indices in theta of the parameters that were refined.
    pub free: Vec<usize>,
    /// Covariance of these, \[free × free\].
    pub covariance: Vec<f64>,
    /// Whether the search ended by itself.
    pub converged: bool,
    /// Runs of the filter.
    pub runs: usize,
    /// Parameters that moved last, index in theta and part of the standard error,
    /// the largest first.
    pub moved: Vec<(usize, f64)>,
    /// Minus the logarithm of the likelihood, without its constant.
    pub loss: f64,
    /// Measurements that were used.
    pub measurements: u64,
    /// Samples that were used.
    pub samples: usize,
    /// Time that they span, s.
    pub duration: f64,
    /// Whether the logs hold more.
    pub left_out: bool,
    /// Levels of noise and disturbances, one per row of the regressor.
    pub levels: Vec<RowLevel>,
    /// What the log says of delays, one per channel.
    pub delays: Vec<ChannelDelay>,
    /// Parameter vectors of growing parts of the log, by their end in s.
    pub trace: Vec<(f64, Theta)>,
}

/// Noise and disturbance of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowLevel {
    /// Standard deviation of white torque noise, N·m (N); zero in link rows.
    pub white: f64,
    /// Standard deviation of the disturbance, N·m (N).
    pub drift: f64,
    /// Standard deviation of the torque of the row's joint, N·m (N).
    pub torque: f64,
    /// Whether one of them ended at its upper bound.
    pub at_bound: bool,
}

/// What the likelihood says of the delay of a channel against the others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelDelay {
    /// Index in [`Channels::all`].
    pub channel: usize,
    /// How much later than assumed it was recorded, s.
    pub delay: f64,
    /// Its standard error, s.
    pub standard_error: f64,
}

/// Refines parameters from a start.
///
/// - `excerpt`: the beginning of the first log, for the noise of its channels.
/// - `start`: a parameter vector, \[p\].
/// - `free`: indices of the parameters to refine.
/// - `exact_torque`: whether the logged torque is what acted.
/// - `progress`: called with the number of filter runs so far.
///
/// Returns nothing if the logs are too short, or the filter does not follow them
/// from this start.
///
/// # Errors
///
/// [`PassError`] if a log cannot be read, or the filter does not fit it.
#[expect(
    clippy::too_many_arguments,
    reason = "a log, a start, and what is known"
)]
pub fn refine(
    reading: &Reading<'_>,
    sources: &mut [LogSource<'_>],
    excerpt: &Excerpt,
    start: &[f64],
    free: &[usize],
    exact_torque: bool,
    progress: &mut dyn FnMut(usize),
) -> Result<Option<Refined>, PassError> {
    let (model, channels) = (reading.model, reading.channels);
    let limit = MOST / model.rows().max(1);
    let (raw, left_out) = record::read(channels, sources, limit)?;
    let Some(record) = build(reading, excerpt, &raw, left_out)? else {
        return Ok(None);
    };
    let start = lifted(model, start);
    let unknowns = Unknowns::new(model, channels, &record, &start, free.to_vec());
    let noisy: Vec<bool> = (0..model.rows())
        .map(|row| model.is_torque_row(row) && !exact_torque)
        .collect();
    let search = Search::new(&record, &noisy);
    let problem = Problem {
        model,
        record: &record,
        unknowns: &unknowns,
        search: &search,
    };
    let levels = first_levels(model, &record, exact_torque);
    let Some(descent) = problem.descend(&unknowns.point(&start), &levels, progress) else {
        return Ok(None);
    };
    Ok(finish(&problem, channels, &descent))
}

fn build(
    reading: &Reading<'_>,
    excerpt: &Excerpt,
    raw: &[Raw],
    left_out: bool,
) -> Result<Option<Record>, PassError> {
    let (model, channels) = (reading.model, reading.channels);
    let of_channel = |i: usize| match noise(excerpt, i) {
        Some((_, Some(step))) => Noise::Counts(step),
        Some((deviation, None)) => Noise::White(deviation.max(FINEST)),
        None => Noise::White(FINEST),
    };
    let sensors = record::sensors(model, channels, of_channel);
    let order = reading.settings.position_filter_order;
    let mut stretches = Vec::new();
    for raw in raw {
        let filter = Butterworth::new(order, reading.position_cutoff_hz, raw.period())?;
        let delays = reading.delays;
        stretches.extend(record::stretch(
            raw, model, channels, &sensors, delays, &filter,
        ));
    }
    if stretches.is_empty() {
        return Ok(None);
    }
    let torque_scale = record::torque_scale(model, &stretches);
    Ok(Some(Record {
        sensors,
        stretches,
        torque_scale,
        left_out,
    }))
}

/// Returns a start that moves as a robot does: inertias and stiffnesses above zero,
/// frictions not below.
fn lifted(model: &Model, start: &[f64]) -> Theta {
    let mut theta = start.to_vec();
    for (parameter, value) in model.parameters().iter().zip(&mut theta) {
        let Some((kind, joint)) = parameter.joint.filter(|_| parameter.fixed.is_none()) else {
            continue;
        };
        let rotor_of_link = kind == JointParameter::RotorInertia && !model.is_flexible(joint);
        if kind.is_vital() && !rotor_of_link && *value <= 0.0 {
            let nominal = parameter.nominal.filter(|nominal| *nominal > 0.0);
            *value = nominal.unwrap_or(value.abs()).max(f64::MIN_POSITIVE);
        } else if kind.is_friction() {
            *value = value.max(0.0);
        }
    }
    theta
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
        corner: noise::CORNER,
    }
}

/// Turns the end of a descent into a result.
fn finish(problem: &Problem<'_>, channels: &Channels, descent: &Descent) -> Option<Refined> {
    let (model, record) = (problem.model, problem.record);
    let all = problem
        .unknowns
        .clone()
        .with_delays(model, channels, record);
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
    let count = all.values();
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
    for (place, &index) in free.iter().enumerate() {
        standard_error[index] = covariance[place * (count + 1)].sqrt();
    }
    let trace = (outcome.growing.iter())
        .filter_map(|(time, so_far)| {
            let mut so_far = so_far.first(count);
            problem.with_prior(&descent.z, &mut so_far);
            let step = solve::damped_step(&so_far.information, &so_far.gradient, 0.0)?;
            let z: Vec<f64> = descent.z.iter().zip(&step).map(|(x, d)| x + d).collect();
            Some((*time, all.theta(&z)))
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
        free,
        converged: descent.converged,
        runs: descent.runs,
        moved,
        loss: outcome.loss,
        measurements: outcome.measurements,
        samples: record.samples(),
        duration: record.duration(),
        left_out: record.left_out,
        levels: row_levels(problem, &descent.levels),
        delays: delays(&all, &outcome.normal, &covariance, count),
        trace,
    })
}

fn row_levels(problem: &Problem<'_>, levels: &Levels) -> Vec<RowLevel> {
    let bound: Vec<noise::Level> = problem.search.at_bound(levels).collect();
    (0..levels.drift.len())
        .map(|row| RowLevel {
            white: levels.white[row],
            drift: levels.drift[row],
            torque: problem.record.torque_scale[row],
            at_bound: (bound.iter())
                .any(|level| [noise::Level::White(row), noise::Level::Drift(row)].contains(level)),
        })
        .collect()
}

/// Returns what one step of Gauss-Newton says of each delay alone, the other
/// unknowns following.
fn delays(
    unknowns: &Unknowns,
    normal: &kalman::Normal,
    covariance: &[f64],
    count: usize,
) -> Vec<ChannelDelay> {
    (unknowns.delayed().enumerate())
        .map(|(i, channel)| {
            let at = count + i;
            let cross = &normal.information[at * normal.count..at * normal.count + count];
            let mut information = normal.information[at * (normal.count + 1)];
            let mut gradient = normal.gradient[at];
            for (j, a) in cross.iter().enumerate() {
                let row = &covariance[j * count..(j + 1) * count];
                for (k, factor) in row.iter().enumerate() {
                    information -= a * factor * cross[k];
                    gradient -= a * factor * normal.gradient[k];
                }
            }
            ChannelDelay {
                channel,
                delay: -gradient / information,
                standard_error: information.max(0.0).sqrt().recip(),
            }
        })
        .collect()
}
