//! What the filter sees of logs: torques, and measurements of positions.
//!
//! An encoder says little between two counts and much when it changes: where its
//! position was halfway between two samples, to a twentieth of a count. A raw count
//! is not a position with white noise, and a filter that takes it for one finds
//! disturbances that are not there.

use crate::log::{Channels, LogBlock, LogError, LogSource, Mix, Quantity};
use crate::model::Model;
use crate::preprocess::{Butterworth, ZeroPhase};

/// What is known of a count's edge, in counts: encoder lines are not that even.
const EDGE: f64 = 0.05;

/// Samples without an edge after which a joint is taken to rest within a count.
const RESTS: usize = 100;

/// How well the smoothed velocity at the start of a stretch is known, rad/s, and as
/// a part of itself.
const START_VELOCITY: f64 = 0.05;
const START_PART: f64 = 0.2;

/// Part of the largest torque that every joint's counts with at least.
const LEAST: f64 = 1e-3;

/// Noise of a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Noise {
    /// Counts of this size, rad (m).
    Counts(f64),
    /// White, of this standard deviation, rad (m).
    White(f64),
}

impl Noise {
    /// Returns the variance of a sample, rad² (m²).
    pub(super) fn variance(self) -> f64 {
        match self {
            Self::Counts(step) => step * step / 12.0,
            Self::White(deviation) => deviation * deviation,
        }
    }
}

/// What a channel of positions measures: a sum of coordinates.
#[derive(Clone, Debug)]
pub(super) struct Sensor {
    /// Index in [`Channels::all`].
    pub(super) channel: usize,
    /// Coordinates and how much of each.
    pub(super) of: Vec<(usize, f64)>,
    /// What is added to a cell to measure them, rad (m).
    pub(super) offset: f64,
    pub(super) noise: Noise,
    /// Standard deviation of what it shows, rad (m).
    pub(super) scale: f64,
}

/// One measurement.
#[derive(Clone, Copy, Debug)]
pub(super) struct Event {
    /// Index of the sensor.
    pub(super) sensor: usize,
    pub(super) value: f64,
    pub(super) variance: f64,
    /// How long before its sample it was taken, s.
    pub(super) before: f64,
}

/// Consecutive samples.
#[derive(Clone, Debug)]
pub(super) struct Stretch {
    /// The log it is of.
    pub(super) log: usize,
    pub(super) period: f64,
    /// Torque on each row, \[samples × rows\].
    pub(super) torque: Vec<f64>,
    /// Its rate, smoothed: that of a noise would look as if it told delays.
    pub(super) torque_rate: Vec<f64>,
    pub(super) events: Vec<Event>,
    /// First event of each sample, and the end.
    pub(super) first: Vec<usize>,
    /// Positions and velocities of the rows, \[2 rows\].
    pub(super) start: Vec<f64>,
    /// Their standard deviations.
    pub(super) start_deviation: Vec<f64>,
}

impl Stretch {
    pub(super) fn samples(&self) -> usize {
        self.first.len() - 1
    }
}

/// Logs as the filter sees them.
#[derive(Clone, Debug)]
pub(super) struct Record {
    pub(super) sensors: Vec<Sensor>,
    pub(super) stretches: Vec<Stretch>,
    /// Standard deviation of the torque of each row's joint, N·m (N).
    pub(super) torque_scale: Vec<f64>,
    /// Whether samples were left out, and of how many.
    pub(super) left_out: bool,
}

impl Record {
    pub(super) fn samples(&self) -> usize {
        self.stretches.iter().map(Stretch::samples).sum()
    }

    /// Returns the part of the samples that is of one log.
    pub(super) fn share(&self, log: usize) -> f64 {
        let own = self.stretches.iter().filter(|s| s.log == log);
        let own: usize = own.map(Stretch::samples).sum();
        own as f64 / self.samples().max(1) as f64
    }

    pub(super) fn duration(&self) -> f64 {
        let of = |s: &Stretch| s.period * s.samples() as f64;
        self.stretches.iter().map(of).sum()
    }
}

/// Raw samples of one stretch: channels in SI units.
#[derive(Clone, Debug)]
pub(super) struct Raw {
    log: usize,
    period: f64,
    values: Vec<Vec<f64>>,
}

impl Raw {
    pub(super) fn period(&self) -> f64 {
        self.period
    }
}

/// Returns the standard deviation of the torque of each row's joint; a joint that
/// has hardly any counts with a part of the largest.
pub(super) fn torque_scale(model: &Model, stretches: &[Stretch]) -> Vec<f64> {
    let rows = model.rows();
    let of = |row: usize| {
        let own = stretches
            .iter()
            .map(|s| s.torque.iter().skip(row).step_by(rows));
        deviation(own.flatten().copied())
    };
    let scales: Vec<f64> = (0..rows)
        .map(|row| of(model.torque_row(model.joint_of(row))))
        .collect();
    let largest = scales.iter().fold(f64::MIN_POSITIVE, |m, x| x.max(m));
    scales
        .iter()
        .map(|scale| scale.max(LEAST * largest))
        .collect()
}

/// Returns the standard deviation of numbers.
fn deviation(all: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = all.clone().count().max(1) as f64;
    let mean = all.clone().sum::<f64>() / count;
    (all.map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt()
}

/// Reads the beginning of logs, at most `limit` samples together, cut at gaps.
///
/// Returns them, and whether the logs hold more.
///
/// # Errors
///
/// [`LogError`] if a log cannot be read.
pub(super) fn read(
    channels: &Channels,
    sources: &mut [LogSource<'_>],
    limit: usize,
) -> Result<(Vec<Raw>, bool), LogError> {
    let count = channels.all.len();
    let mut all = Vec::new();
    let mut more = false;
    let share = limit / sources.len().max(1);
    for (log_index, source) in sources.iter_mut().enumerate() {
        let mut log = source.open(channels)?;
        let mut block = LogBlock::new(count);
        let mut values = vec![Vec::new(); count];
        let mut taken = 0;
        let mut going = log.read(&mut block)?;
        let period = log.timing().period;
        while going {
            let left = (share - taken).min(block.len());
            more |= left < block.len();
            for k in 0..left {
                if block.gaps.contains(&k) {
                    let values = std::mem::replace(&mut values, vec![Vec::new(); count]);
                    all.push(Raw {
                        log: log_index,
                        period,
                        values,
                    });
                }
                for (own, column) in values.iter_mut().zip(&block.values) {
                    own.push(column[k]);
                }
            }
            taken += left;
            going = log.read(&mut block)?;
            if taken == share {
                more |= going && !block.is_empty();
                break;
            }
        }
        all.push(Raw {
            log: log_index,
            period,
            values,
        });
    }
    Ok((all, more))
}

/// Returns what each channel of positions measures.
///
/// - `raw`: samples, for the scales; `noise`: of each channel.
pub(super) fn sensors(
    model: &Model,
    channels: &Channels,
    raw: &[Raw],
    noise: impl Fn(usize) -> Noise,
) -> Vec<Sensor> {
    let robot = model.robot();
    let motor = |joint: usize| robot.motor_coordinate(joint);
    (channels.all.iter().enumerate())
        .filter(|(_, channel)| channel.quantity != Quantity::MotorTorque)
        .map(|(i, channel)| {
            let joint = channel.joint;
            let own = channels.offsets[joint];
            let (of, offset) = match (channel.quantity, &channels.position_mix) {
                (Quantity::LinkDeflection, _) => (vec![(joint, 1.0), (motor(joint), -1.0)], 0.0),
                (Quantity::MotorPosition, Some(mix)) => {
                    let row = &mix.back[joint];
                    let parts = row.iter().enumerate().filter(|(_, ratio)| **ratio != 0.0);
                    let offset = Mix::apply(std::slice::from_ref(row), &channels.offsets)[0];
                    (parts.map(|(j, ratio)| (motor(j), *ratio)).collect(), offset)
                }
                (Quantity::MotorPosition, None) => (vec![(motor(joint), 1.0)], own),
                (Quantity::LinkPosition | Quantity::MotorTorque, _) => (vec![(joint, 1.0)], own),
            };
            Sensor {
                channel: i,
                of,
                offset,
                noise: noise(i),
                scale: deviation(raw.iter().flat_map(|raw| raw.values[i].iter().copied())),
            }
        })
        .collect()
}

/// Turns raw samples into torques and measurements.
///
/// - `delays`: of each channel, s.
/// - `filter`: of the smoothed positions, at the period of the log.
///
/// Returns nothing if the samples are too few for the filter or the delays.
pub(super) fn stretch(
    raw: &Raw,
    model: &Model,
    channels: &Channels,
    sensors: &[Sensor],
    delays: &[f64],
    filter: &Butterworth,
) -> Option<Stretch> {
    let period = raw.period;
    let rows = model.rows();
    let length = raw.values.first()?.len();
    // Samples that all channels reach, delays undone.
    let shift = |delay: f64| delay / period;
    let latest = delays
        .iter()
        .map(|d| shift(*d).max(0.0))
        .fold(0.0, f64::max);
    let earliest = delays
        .iter()
        .map(|d| shift(*d).min(0.0))
        .fold(0.0, f64::min);
    let begin = (-earliest).ceil() as usize;
    let lost = begin + latest.ceil() as usize;
    let samples = length.checked_sub(lost + 1).filter(|left| *left > 2)?;
    let mut found: Vec<(usize, Event)> = Vec::new();
    let mut begins = vec![(0.0, 0.0); sensors.len()];
    for (index, sensor) in sensors.iter().enumerate() {
        let cells = &raw.values[sensor.channel];
        let velocity = velocity(cells, filter, period)?;
        // Where a sample of the channel stands among those of the stretch.
        let place = |k: f64| k - shift(delays[sensor.channel]) - begin as f64;
        let mut put = |at: f64, value: f64, variance: f64, acceleration: f64| {
            let sample = (at - 1e-9).ceil();
            if sample >= 0.0 && sample < samples as f64 {
                let before = (sample - at).max(0.0) * period;
                found.push((
                    sample as usize,
                    Event {
                        sensor: index,
                        // The filter goes back by the velocity of the sample alone.
                        value: value + sensor.offset - 0.5 * acceleration * before * before,
                        variance,
                        before,
                    },
                ));
            }
        };
        match sensor.noise {
            Noise::White(deviation) => {
                for (k, value) in cells.iter().enumerate() {
                    let ahead = (k + 1).min(velocity.len() - 1);
                    let acceleration = (velocity[ahead] - velocity[k]) / period;
                    put(place(k as f64), *value, deviation * deviation, acceleration);
                }
            }
            Noise::Counts(step) => edges(cells, &velocity, step, period, |at, value, r, a| {
                put(place(at), value, r, a);
            }),
        }
        let first = (begin as f64 + shift(delays[sensor.channel]))
            .round()
            .max(0.0) as usize;
        begins[index] = (cells[first] + sensor.offset, velocity[first]);
    }
    found.sort_by_key(|(sample, event)| (*sample, event.sensor));
    let mut first = Vec::with_capacity(samples + 1);
    let mut next = 0;
    for sample in 0..=samples {
        while next < found.len() && found[next].0 < sample {
            next += 1;
        }
        first.push(next);
    }
    let (start, start_deviation) = start(rows, sensors, &begins)?;
    let torque = torques(raw, model, channels, delays, begin, samples);
    Some(Stretch {
        log: raw.log,
        period,
        torque_rate: rates(&torque, rows, filter, period)?,
        torque,
        events: found.into_iter().map(|(_, event)| event).collect(),
        first,
        start,
        start_deviation,
    })
}

/// Returns the velocity of the smoothed cells.
fn velocity(cells: &[f64], filter: &Butterworth, period: f64) -> Option<Vec<f64>> {
    let mut smooth = Vec::with_capacity(cells.len());
    let mut running = ZeroPhase::new(filter.clone());
    running.push(cells, &mut smooth);
    if !running.finish(&mut smooth) {
        return None;
    }
    let last = smooth.len() - 1;
    Some(
        (0..=last)
            .map(|k| {
                let (before, after) = (k.saturating_sub(1), (k + 1).min(last));
                (smooth[after] - smooth[before]) / ((after - before) as f64 * period)
            })
            .collect(),
    )
}

/// Returns the rates of the smoothed torques, \[samples × rows\].
fn rates(torque: &[f64], rows: usize, filter: &Butterworth, period: f64) -> Option<Vec<f64>> {
    let mut rates = vec![0.0; torque.len()];
    for row in 0..rows {
        let own: Vec<f64> = torque.iter().skip(row).step_by(rows).copied().collect();
        let smooth = velocity(&own, filter, period)?;
        for (rate, own) in rates[row..].iter_mut().step_by(rows).zip(smooth) {
            *rate = own;
        }
    }
    Some(rates)
}

/// Visits what a counter says: place among the samples, position, its variance and
/// the acceleration there.
///
/// Where the counter changes, the position halfway between two samples is the mean
/// of both, whatever the number of counts between them: of all positions that lead
/// to so many counts at this velocity it is the centre, and they span one count
/// less the part by which the number differs from what the velocity says. Taking
/// the later cell instead is wrong by up to half a count towards the motion, which
/// looks like friction.
fn edges(
    cells: &[f64],
    velocity: &[f64],
    step: f64,
    period: f64,
    mut visit: impl FnMut(f64, f64, f64, f64),
) {
    let mut since = 0;
    for k in 0..cells.len() {
        let counts = match cells.get(k + 1) {
            Some(next) => (next - cells[k]) / step,
            None => f64::INFINITY,
        };
        if counts.abs() < 0.5 {
            continue;
        }
        // A rest says once where the joint was, however long it was.
        if k - since >= RESTS {
            let middle = usize::midpoint(since, k);
            visit(middle as f64, cells[middle], step * step / 12.0, 0.0);
        }
        since = k + 1;
        if let (Some(next), Some(ahead)) = (cells.get(k + 1), velocity.get(k + 1)) {
            let moved = 0.5 * (velocity[k] + ahead) * period / step;
            let width = (1.0 - (counts - moved).abs()).max(0.0);
            let variance = (width * width / 12.0 + EDGE * EDGE) * step * step;
            // The mean of two positions lies ahead of the one between them in time.
            let gained = ahead - velocity[k];
            let between = 0.5 * (cells[k] + next) - gained * period / 8.0;
            visit(k as f64 + 0.5, between, variance, gained / period);
        }
    }
}

/// Returns positions and velocities of the rows at the first sample, and their
/// standard deviations.
///
/// - `begins`: position and velocity of each sensor.
fn start(rows: usize, sensors: &[Sensor], begins: &[(f64, f64)]) -> Option<(Vec<f64>, Vec<f64>)> {
    // Each coordinate is measured, if not alone, then with known ones.
    let count = sensors.len();
    let matrix = faer::Mat::from_fn(count, rows, |i, j| {
        let own = sensors[i]
            .of
            .iter()
            .find(|(coordinate, _)| *coordinate == j);
        own.map_or(0.0, |(_, weight)| *weight)
    });
    let both = faer::Mat::from_fn(
        count,
        2,
        |i, j| if j == 0 { begins[i].0 } else { begins[i].1 },
    );
    let solved = {
        use faer::linalg::solvers::SolveLstsq;
        if count < rows {
            return None;
        }
        matrix.qr().solve_lstsq(both)
    };
    let mut start = Vec::new();
    let mut deviation = Vec::new();
    for row in 0..rows {
        start.push(solved[(row, 0)]);
        let of = |s: &&Sensor| s.of.iter().any(|(coordinate, _)| *coordinate == row);
        let variance: f64 = sensors.iter().filter(of).map(|s| s.noise.variance()).sum();
        deviation.push(variance.sqrt());
    }
    for row in 0..rows {
        let velocity = solved[(row, 1)];
        start.push(velocity);
        deviation.push(START_VELOCITY + START_PART * velocity.abs());
    }
    start
        .iter()
        .all(|x| x.is_finite())
        .then_some((start, deviation))
}

/// Returns the torque on each row, held for a period.
fn torques(
    raw: &Raw,
    model: &Model,
    channels: &Channels,
    delays: &[f64],
    begin: usize,
    samples: usize,
) -> Vec<f64> {
    let (n, rows) = (model.joint_count(), model.rows());
    let mut torque = vec![0.0; samples * rows];
    let mut joints = vec![0.0; n];
    for k in 0..samples {
        for (i, channel) in channels.all.iter().enumerate() {
            if channel.quantity == Quantity::MotorTorque {
                // A torque held from between two samples counts for both.
                let lead = delays[i] / raw.period + begin as f64;
                let whole = (lead + 1e-9).floor();
                let part = (lead - whole).max(0.0);
                let at = k + whole.max(0.0) as usize;
                let cells = &raw.values[i];
                let last = cells.len() - 1;
                joints[channel.joint] =
                    (1.0 - part) * cells[at.min(last)] + part * cells[(at + 1).min(last)];
            }
        }
        if let Some(mix) = &channels.torque_mix {
            joints = Mix::apply(&mix.forward, &joints);
        }
        for (joint, tau) in joints.iter().enumerate() {
            torque[k * rows + model.torque_row(joint)] = *tau;
        }
    }
    torque
}
