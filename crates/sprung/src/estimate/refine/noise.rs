//! The levels of the disturbances, found by maximum likelihood.
//!
//! The filter is linear about the last trajectory, so its likelihood and the exact
//! derivatives of it with respect to the levels follow from recursions for the
//! state, the covariance and their derivatives. A step is one of Fisher scoring.

use rayon::prelude::*;

use super::dynamics::{add, scale};
use super::kalman::{
    Levels, Schedule, add_white, disturb, measured, propagate, seen, start_covariance, update,
};
use super::record::Record;
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

/// A step that promises less than this of the likelihood's logarithm ends the
/// search: the estimate does not feel it.
const ENOUGH: f64 = 0.1;

/// Bounds of a sensor's noise, as parts of the standard deviation of what it shows.
pub(super) const QUIET: f64 = 1e-6;
const NOISY: f64 = 0.3;

/// Corner of the disturbances' spectrum that is expected, Hz, by which factor it may
/// well differ, and its bounds: a log with little disturbance says nothing of it.
pub(super) const CORNER: f64 = 1.5;
const FACTOR: f64 = 3.0;
const CORNERS: (f64, f64) = (0.2, 10.0);

/// Levels that one thread differentiates by.
const SHARE: usize = 4;

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

/// What all levels of a group say of each measurement.
struct Group {
    /// Variance and value of each innovation.
    innovations: Vec<(f64, f64)>,
    /// Their derivatives with respect to the logarithms of the levels,
    /// \[measurements × levels\].
    derivatives: Vec<(f64, f64)>,
}

/// A covariance's derivative and that of the state's deviation.
struct Derivative {
    level: Level,
    /// Twice the variance: the derivative of a square by a logarithm.
    strength: f64,
    covariance: Vec<f64>,
    deviation: Vec<f64>,
    column: Vec<f64>,
}

/// The innovations of a run about which the likelihood is linear.
#[derive(Clone, Copy)]
pub(super) struct About<'a> {
    pub(super) record: &'a Record,
    pub(super) schedule: &'a Schedule,
    /// Samples whose transitions are kept.
    pub(super) samples: usize,
}

impl About<'_> {
    /// Returns minus the logarithm of the likelihood at some levels, that of what is
    /// known of the corner included, its gradient and its expected curvature.
    pub(super) fn likelihood(&self, search: &Search, levels: &Levels) -> (f64, Vec<f64>, Vec<f64>) {
        let groups: Vec<Group> = (search.all.par_chunks(SHARE))
            .map(|share| self.group(share, levels))
            .collect();
        let count = search.all.len();
        let mut loss = 0.0;
        let mut gradient = vec![0.0; count];
        let mut curvature = vec![0.0; count * count];
        if let Some(at) = search.all.iter().position(|level| *level == Level::Corner) {
            let (away, width) = ((levels.corner / CORNER).ln(), FACTOR.ln());
            loss += 0.5 * (away / width).powi(2);
            gradient[at] += away / width.powi(2);
            curvature[at * (count + 1)] += width.powi(-2);
        }
        let measurements = groups.first().map_or(0, |group| group.innovations.len());
        let mut all = Vec::with_capacity(count);
        for at in 0..measurements {
            let (variance, innovation) = groups[0].innovations[at];
            loss += 0.5 * (innovation * innovation / variance + variance.ln());
            all.clear();
            for group in &groups {
                let own = group.derivatives.len() / measurements;
                all.extend_from_slice(&group.derivatives[at * own..(at + 1) * own]);
            }
            let square = innovation * innovation / variance;
            for (i, (ds, de)) in all.iter().enumerate() {
                gradient[i] += innovation * de / variance + 0.5 * ds / variance * (1.0 - square);
                for (j, (other_ds, other_de)) in all[..=i].iter().enumerate() {
                    curvature[i * count + j] +=
                        0.5 * ds * other_ds / (variance * variance) + de * other_de / variance;
                }
            }
        }
        (loss, gradient, curvature)
    }

    fn group(&self, share: &[Level], levels: &Levels) -> Group {
        let rows = levels.drift.len();
        let states = 3 * rows;
        let mut group = Group {
            innovations: Vec::new(),
            derivatives: Vec::new(),
        };
        let mut product = vec![0.0; 2 * rows * states];
        let mut column = vec![0.0; states];
        let mut transitions = self.schedule.transitions.chunks(2 * rows * states);
        let mut events = self.schedule.measured(states);
        let mut drifts = self.schedule.drift.chunks(rows);
        let mut left = self.samples;
        for stretch in &self.record.stretches {
            if left == 0 {
                break;
            }
            let left_after = levels.left_after(stretch.period);
            let change = left_after - Levels::left(self.schedule.corner, stretch.period);
            // By the logarithm of the corner.
            let slope = left_after * left_after.ln();
            let mut covariance = start_covariance(rows, stretch, levels);
            let mut deviation = vec![0.0; states];
            let mut derivatives: Vec<Derivative> = (share.iter())
                .map(|level| Derivative::new(*level, levels, states))
                .collect();
            for k in 0..stretch.samples().min(left) {
                for event in &stretch.events[stretch.first[k]..stretch.first[k + 1]] {
                    let Some((gains, before)) = events.next() else {
                        return group;
                    };
                    let of = seen(&self.record.sensors[event.sensor], event, rows);
                    let innovation = before - measured(&deviation, of.clone());
                    let noise = levels.variance(event);
                    let variance = update(&mut covariance, of.clone(), noise, &mut column);
                    group.innovations.push((variance, innovation));
                    for derivative in &mut derivatives {
                        let both = derivative.measure(
                            event.sensor,
                            of.clone(),
                            &column,
                            (variance, innovation),
                        );
                        group.derivatives.push(both);
                    }
                    // The state moves by its own gain; the run moved by its.
                    add(&mut deviation, innovation / variance, &column);
                    add(&mut deviation, -before, gains);
                }
                let Some(transition) = transitions.next() else {
                    return group;
                };
                let Some(drift) = drifts.next() else {
                    return group;
                };
                let period = Period {
                    transition,
                    left: left_after,
                    slope,
                    drift,
                };
                for derivative in &mut derivatives {
                    derivative.predict(&period, &deviation, &mut product);
                }
                propagate(&mut covariance, transition, &mut product, left_after);
                for derivative in &mut derivatives {
                    derivative.follow(&covariance, levels, &period);
                }
                disturb(&mut covariance, transition, levels, left_after);
                carry(&mut deviation, transition, left_after);
                for (own, drift) in deviation[2 * rows..].iter_mut().zip(drift) {
                    *own += change * drift;
                }
            }
            left -= stretch.samples().min(left);
        }
        group
    }
}

/// Carries a deviation of the state over a period.
fn carry(x: &mut [f64], transition: &[f64], decay: f64) {
    let moved: Vec<f64> = (transition.chunks(x.len()))
        .map(|row| row.iter().zip(&*x).map(|(a, b)| a * b).sum())
        .collect();
    let (moving, drift) = x.split_at_mut(moved.len());
    moving.copy_from_slice(&moved);
    scale(drift, decay);
}

impl Derivative {
    fn new(level: Level, levels: &Levels, states: usize) -> Self {
        let rows = states / 3;
        let mut covariance = vec![0.0; states * states];
        let strength = match level {
            Level::Corner => 0.0,
            Level::Sensor(sensor) => 2.0 * levels.sensor[sensor].powi(2),
            Level::White(row) => 2.0 * levels.white[row].powi(2),
            Level::Drift(row) => {
                let strength = 2.0 * levels.drift[row].powi(2);
                covariance[(2 * rows + row) * (states + 1)] = strength;
                strength
            }
        };
        Self {
            level,
            strength,
            covariance,
            deviation: vec![0.0; states],
            column: vec![0.0; states],
        }
    }

    /// Takes a measurement; returns the derivatives of the innovation's variance
    /// and of itself.
    ///
    /// - Variance and value of the innovation come last.
    /// - `column`: covariance of the state with the measurement.
    fn measure(
        &mut self,
        sensor: usize,
        of: impl Iterator<Item = (usize, f64)> + Clone,
        column: &[f64],
        (variance, innovation): (f64, f64),
    ) -> (f64, f64) {
        let states = column.len();
        self.column.fill(0.0);
        for (state, weight) in of.clone() {
            let row = &self.covariance[state * states..(state + 1) * states];
            add(&mut self.column, weight, row);
        }
        let mut of_variance = measured(&self.column, of.clone());
        if self.level == Level::Sensor(sensor) {
            of_variance += self.strength;
        }
        let of_innovation = -measured(&self.deviation, of);
        // P - c c^T / s: its derivative is that of the product.
        let part = of_variance / variance;
        for (i, row) in self.covariance.chunks_mut(states).enumerate() {
            let (own, of_own) = (column[i] / variance, self.column[i] / variance);
            add(row, part * own - of_own, column);
            add(row, -own, &self.column);
        }
        // x + c e / s, likewise.
        let of_factor = (of_innovation - part * innovation) / variance;
        add(&mut self.deviation, of_factor, column);
        add(&mut self.deviation, innovation / variance, &self.column);
        (of_variance, of_innovation)
    }

    /// Carries the derivatives over a period.
    ///
    /// - `deviation`: of the state before it.
    fn predict(&mut self, period: &Period<'_>, deviation: &[f64], product: &mut [f64]) {
        let rows = period.drift.len();
        propagate(
            &mut self.covariance,
            period.transition,
            product,
            period.left,
        );
        carry(&mut self.deviation, period.transition, period.left);
        if self.level == Level::Corner {
            let all = deviation[2 * rows..].iter().zip(period.drift);
            for (own, (away, drift)) in self.deviation[2 * rows..].iter_mut().zip(all) {
                *own += period.slope * (away + drift);
            }
        }
    }

    /// Adds what the level itself does to the covariance.
    ///
    /// - `covariance`: after the period, before it was disturbed.
    fn follow(&mut self, covariance: &[f64], levels: &Levels, period: &Period<'_>) {
        let rows = period.drift.len();
        let states = 3 * rows;
        match self.level {
            Level::White(row) => {
                add_white(&mut self.covariance, period.transition, row, self.strength);
            }
            Level::Drift(row) => {
                let own = (2 * rows + row) * (states + 1);
                self.covariance[own] += self.strength * (1.0 - period.left * period.left);
            }
            Level::Sensor(_) => {}
            Level::Corner => {
                // Rows and columns of the drifts hold the factor once, their own block
                // twice.
                let part = period.slope / period.left;
                for i in 0..states {
                    for j in 0..states {
                        let times = u8::from(i >= 2 * rows) + u8::from(j >= 2 * rows);
                        let at = i * states + j;
                        self.covariance[at] += f64::from(times) * part * covariance[at];
                    }
                }
                for (i, drift) in levels.drift.iter().enumerate() {
                    let own = (2 * rows + i) * (states + 1);
                    self.covariance[own] -= 2.0 * period.left * period.slope * drift * drift;
                }
            }
        }
    }
}

/// What a period does to state and covariance.
struct Period<'p> {
    /// Derivatives of the state, \[2 rows × 3 rows\].
    transition: &'p [f64],
    /// What is left of a disturbance, and its derivative by the logarithm of the
    /// corner.
    left: f64,
    slope: f64,
    /// Disturbances of the run before the period.
    drift: &'p [f64],
}

/// Searches the levels of the greatest likelihood; returns them, and by how much
/// its logarithm grew.
pub(super) fn search(about: &About<'_>, search: &Search, from: &Levels) -> (Levels, f64) {
    let mut logs = search.logs(from);
    let mut levels = search.levels(from, &logs);
    let (mut loss, mut gradient, mut curvature) = about.likelihood(search, &levels);
    let first = loss;
    for _ in 0..STEPS {
        let Some((step, promised)) = search.step(&logs, &gradient, &curvature) else {
            break;
        };
        if promised < ENOUGH {
            break;
        }
        let mut part = 1.0;
        let better = loop {
            let at: Vec<f64> = logs.iter().zip(&step).map(|(x, d)| x + part * d).collect();
            let there = search.levels(from, &at);
            let found = about.likelihood(search, &there);
            if found.0 < loss {
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
        (loss, gradient, curvature) = found;
    }
    (levels, first - loss)
}

impl Search {
    /// Returns the step of scoring within the bounds, and what it promises.
    ///
    /// What the log hardly speaks of moves little: every logarithm is held by the
    /// same amount, as much as keeps the longest step within its stride.
    fn step(&self, logs: &[f64], gradient: &[f64], curvature: &[f64]) -> Option<(Vec<f64>, f64)> {
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
