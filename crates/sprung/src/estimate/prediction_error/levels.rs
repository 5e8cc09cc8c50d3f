//! The levels of the disturbances, found by maximum likelihood.
//!
//! Steps are those of scoring: the information that the innovations show, brought
//! to the size that is expected of it.

use super::filter::Levels;
use super::likelihood::{About, Slope};
use super::measurements::Record;
use super::solve::damped_step;

/// Bounds of a level, as parts of the torque's standard deviation: more drift than
/// the upper one is not a disturbance but a torque that the model does not explain.
/// White noise may be that of a current sensor.
const LOWEST: f64 = 1e-4;
const HIGHEST_WHITE: f64 = 0.5;
const HIGHEST_DRIFT: f64 = 0.25;

/// Steps of scoring, and the largest change of a logarithm in one.
const STEPS: usize = 6;
const STRIDE: f64 = 1.5;

/// Ratio of expected to found that the curvature is corrected by, at most.
const UNLIKE: f64 = 30.0;

/// A step that promises less than this of the likelihood's logarithm ends the
/// search: the estimate does not feel it.
const ENOUGH: f64 = 0.1;

/// Bounds of a sensor's noise, as parts of the standard deviation of what it shows.
const QUIET: f64 = 1e-8;
const NOISY: f64 = 0.3;

/// Corner of the disturbances' spectrum that is expected, Hz, by which factor it may
/// well differ, and its bounds: a log with little disturbance says nothing of it.
pub(super) const CORNER: f64 = 1.5;
const FACTOR: f64 = 3.0;
const CORNERS: (f64, f64) = (0.2, 10.0);

/// A level: white noise or drift of a row, noise of a sensor, or the corner of all
/// drifts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Level {
    White(usize),
    Drift(usize),
    Sensor(usize),
    Corner,
}

/// Levels that are searched, and their bounds.
#[derive(Clone, Debug)]
pub(super) struct Search {
    pub(super) all: Vec<Level>,
    bounds: Vec<(f64, f64)>,
}

impl Search {
    /// - `white`: whether each row has white noise that is unknown; `sensors`:
    ///   whether each sensor has noise beyond what its samples show.
    pub(super) fn new(record: &Record, white: &[bool], sensors: &[bool]) -> Self {
        let scales = &record.torque_scale;
        let noisy = white.iter().enumerate().filter(|(_, white)| **white);
        let noisy_sensors = sensors.iter().enumerate().filter(|(_, noisy)| **noisy);
        let all: Vec<Level> = noisy
            .map(|(row, _)| Level::White(row))
            .chain((0..scales.len()).map(Level::Drift))
            .chain([Level::Corner])
            .chain(noisy_sensors.map(|(sensor, _)| Level::Sensor(sensor)))
            .collect();
        let bounds = all.iter().map(|level| match *level {
            Level::White(row) => (LOWEST * scales[row], HIGHEST_WHITE * scales[row]),
            Level::Drift(row) => (LOWEST * scales[row], HIGHEST_DRIFT * scales[row]),
            Level::Sensor(sensor) => {
                let scale = record.sensors[sensor].scale;
                (QUIET * scale, NOISY * scale)
            }
            Level::Corner => CORNERS,
        });
        Self {
            bounds: bounds.collect(),
            all,
        }
    }

    pub(super) fn logs(&self, levels: &Levels) -> Vec<f64> {
        let of = |level: &Level| match *level {
            Level::White(row) => levels.white[row],
            Level::Drift(row) => levels.drift[row],
            Level::Sensor(sensor) => levels.sensor[sensor],
            Level::Corner => levels.corner,
        };
        self.all.iter().map(|level| of(level).ln()).collect()
    }

    pub(super) fn levels(&self, from: &Levels, logs: &[f64]) -> Levels {
        let mut levels = from.clone();
        for ((level, log), (low, high)) in self.all.iter().zip(logs).zip(&self.bounds) {
            let value = log.exp().clamp(*low, *high);
            match *level {
                Level::White(row) => levels.white[row] = value,
                Level::Drift(row) => levels.drift[row] = value,
                Level::Sensor(sensor) => levels.sensor[sensor] = value,
                Level::Corner => levels.corner = value,
            }
        }
        levels
    }

    /// Returns the levels that ended at their upper bound.
    pub(super) fn at_bound<'a>(&'a self, levels: &'a Levels) -> impl Iterator<Item = Level> + 'a {
        let values = self.logs(levels);
        (self.all.iter().zip(&self.bounds).zip(values))
            .filter(|((level, (_, high)), log)| **level != Level::Corner && log.exp() > 0.99 * high)
            .map(|((level, _), _)| *level)
    }
}

/// Searches the levels of the greatest likelihood; returns them, and by how much
/// its logarithm grew.
pub(super) fn search(about: &About<'_>, search: &Search, from: &Levels) -> (Levels, f64) {
    let mut logs = search.logs(from);
    let mut levels = search.levels(from, &logs);
    let mut slope = search.slope(about, &levels);
    let first = slope.loss;
    for _ in 0..STEPS {
        let Some((step, promised)) = search.step(&logs, &slope) else {
            break;
        };
        if promised < ENOUGH {
            break;
        }
        let mut part = 1.0;
        let better = loop {
            let at: Vec<f64> = logs.iter().zip(&step).map(|(x, d)| x + part * d).collect();
            let there = search.levels(from, &at);
            let found = search.slope(about, &there);
            if found.loss < slope.loss {
                break Some((there, found));
            }
            part *= 0.25;
            if part < 0.01 {
                break None;
            }
        };
        let Some((there, found)) = better else { break };
        levels = there;
        logs = search.logs(&levels);
        slope = found;
    }
    (levels, first - slope.loss)
}

impl Search {
    /// Returns what the likelihood and what is known of the corner say at some
    /// levels; the curvature is the expected one where only one level counts.
    pub(super) fn slope(&self, about: &About<'_>, levels: &Levels) -> Slope {
        let mut slope = about.likelihood(self, levels);
        let count = self.all.len();
        let scales: Vec<f64> = (self.all.iter().zip(&slope.expected).zip(&slope.gradient))
            .map(|((level, expected), own)| {
                let found = expected - own;
                if *level == Level::Corner || !(found > 0.0 && *expected > 0.0) {
                    1.0
                } else {
                    (expected / found).sqrt().clamp(1.0 / UNLIKE, UNLIKE)
                }
            })
            .collect();
        for i in 0..count {
            for j in 0..=i {
                slope.curvature[i * count + j] *= scales[i] * scales[j];
            }
        }
        if let Some(at) = self.all.iter().position(|level| *level == Level::Corner) {
            let (away, width) = ((levels.corner / CORNER).ln(), FACTOR.ln());
            slope.loss += 0.5 * (away / width).powi(2);
            slope.gradient[at] += away / width.powi(2);
            slope.curvature[at * (count + 1)] += width.powi(-2);
        }
        slope
    }

    /// Returns the step of scoring within the bounds, and what it promises.
    ///
    /// What the log hardly speaks of moves little: every logarithm is held by the
    /// same amount, as much as keeps the longest step within its stride.
    fn step(&self, logs: &[f64], slope: &Slope) -> Option<(Vec<f64>, f64)> {
        let (gradient, curvature) = (&slope.gradient, &slope.curvature);
        let count = logs.len();
        let mut held = vec![false; count];
        let mut hold = 0.1;
        loop {
            let free: Vec<usize> = (0..count).filter(|i| !held[*i]).collect();
            let part: Vec<f64> = (free.iter())
                .flat_map(|&i| free.iter().map(move |&j| (i, j)))
                .map(|(i, j)| {
                    let own = if i == j { hold } else { 0.0 };
                    own + curvature[i.max(j) * count + i.min(j)]
                })
                .collect();
            let own: Vec<f64> = free.iter().map(|&i| gradient[i]).collect();
            let step = damped_step(&part, &own, 0.0)?;
            if step.iter().any(|step| step.abs() > STRIDE) {
                hold *= 4.0;
                continue;
            }
            let mut all = vec![0.0; count];
            let mut beyond = None;
            for (&i, step) in free.iter().zip(&step) {
                let (low, high) = self.bounds[i];
                let inside = (logs[i] + step).clamp(low.ln(), high.ln());
                all[i] = inside - logs[i];
                let cut = (all[i] - step).abs();
                if beyond.is_none_or(|(_, most)| cut > most) && cut > 1e-9 {
                    beyond = Some((i, cut));
                }
            }
            let promised: f64 = -0.5 * all.iter().zip(gradient).map(|(d, g)| d * g).sum::<f64>();
            match beyond {
                // A level that stands at its bound and pulls outward is none; nor
                // may one that is cut short lead the others uphill.
                Some((i, _)) if all[i].abs() < 1e-9 || promised <= 0.0 => held[i] = true,
                _ => return Some((all, promised)),
            }
        }
    }
}
