//! Delays of channels, found from the motor rows.

use sprung_core::parameters::JointParameter;

use crate::log::LogBlock;
use crate::model::Model;
use crate::regression::{Reading, System, SystemPart, reduce_blocks, solve};

/// Samples that a search looks at, shared among the joints, to the end of the
/// block they are in: half a minute at 1 kHz for two joints.
const EXCERPT: usize = 60_000;

/// Delays that are tried, s: sensors with filters of their own lag, some
/// channels are recorded a little early.
const EARLIEST: f64 = -0.05;
const LATEST: f64 = 0.5;

/// Distance of the delays that are tried first, s.
const COARSE: f64 = 0.01;

/// The beginning of a log, kept in memory.
#[derive(Clone, Debug)]
pub struct Excerpt {
    blocks: Vec<LogBlock>,
    samples: usize,
    limit: usize,
    period: f64,
}

impl Excerpt {
    /// Returns an empty excerpt of a log with period T, s, of so many joints.
    #[must_use]
    pub fn new(period: f64, joints: usize) -> Self {
        Self {
            blocks: Vec::new(),
            samples: 0,
            limit: EXCERPT / joints.max(2),
            period,
        }
    }

    /// Takes the next block; returns whether more would be kept.
    pub fn push(&mut self, block: &LogBlock) -> bool {
        if self.samples < self.limit {
            self.samples += block.len();
            self.blocks.push(block.clone());
        }
        self.samples < self.limit
    }

    /// Returns the blocks of the log.
    #[must_use]
    pub fn blocks(&self) -> &[LogBlock] {
        &self.blocks
    }

    /// Returns the first blocks, of at least so many samples if there are.
    #[must_use]
    pub fn first(&self, samples: usize) -> Self {
        let mut first = Self {
            blocks: Vec::new(),
            samples: 0,
            limit: samples,
            ..*self
        };
        for block in &self.blocks {
            first.push(block);
        }
        first
    }

    /// Returns T, s.
    #[must_use]
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Returns the regression of the excerpt; nothing if it is too short for
    /// the filters, or they do not fit it.
    #[must_use]
    pub fn reduce(&self, reading: &Reading<'_>) -> Option<System> {
        let rows: Vec<usize> = (0..reading.model.rows()).collect();
        self.reduce_rows(reading, &rows)
    }

    /// Returns the regression of the excerpt in some rows, likewise.
    #[must_use]
    pub fn reduce_rows(&self, reading: &Reading<'_>, rows: &[usize]) -> Option<System> {
        reduce_blocks(reading, self.period, &self.blocks, rows)
            .ok()
            .flatten()
    }
}

/// What the torque's row of a joint says under an assumption about the log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorRowFit {
    /// Stiffness, N·m/rad (N/m); none for a rigid joint.
    pub stiffness: Option<f64>,
    /// Whether stiffness, rotor inertia and frictions are all positive.
    pub plausible: bool,
    /// Residual over torque, root mean squares.
    pub relative_residual: f64,
}

/// A delay that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DelayEstimate {
    /// Index of the channel in [`Channels::all`](crate::log::Channels::all).
    pub channel: usize,
    /// Delay, s.
    pub delay: f64,
    /// Standard error, s, for residuals as correlated as the filter makes them.
    pub standard_error: f64,
    /// Whether it is one: a minimum inside the search that explains no less
    /// torque than no delay.
    pub found: bool,
    /// What the motor row says without and with the delay.
    pub without: MotorRowFit,
    /// The same with it.
    pub with: MotorRowFit,
}

/// Fits the torque's row of each joint of an excerpt alone.
///
/// Returns nothing if the excerpt is too short for the filter or the settings
/// do not fit the log.
#[must_use]
pub fn fit_motor_rows(excerpt: &Excerpt, reading: &Reading<'_>) -> Option<Vec<MotorRowFit>> {
    let model = reading.model;
    let rows: Vec<usize> = (0..model.joint_count())
        .map(|joint| model.torque_row(joint))
        .collect();
    let whole = excerpt.reduce_rows(reading, &rows)?.whole()?;
    (rows.iter().zip(&whole))
        .map(|(&row, factor)| {
            let columns = model.row_columns(row);
            let local: Vec<usize> = (0..columns.len()).collect();
            let part = SystemPart {
                columns: &local,
                factor,
            };
            let x = solve(&[part], columns.len())?.x;
            let squares: f64 = factor.residual(&x).iter().map(|r| r * r).sum();
            Some(judged(
                model,
                columns,
                &x,
                squares.sqrt() / factor.rhs_norm(),
            ))
        })
        .collect()
}

fn judged(model: &Model, columns: &[usize], x: &[f64], relative_residual: f64) -> MotorRowFit {
    let mut fit = MotorRowFit {
        stiffness: None,
        plausible: true,
        relative_residual,
    };
    for (&column, &value) in columns.iter().zip(x) {
        let parameter = &model.parameters()[column];
        let Some((kind, _)) = parameter.joint else {
            continue;
        };
        if kind == JointParameter::Stiffness {
            fit.stiffness = Some(value);
        }
        if (kind.is_vital() || kind.is_friction()) && value <= 0.0 {
            fit.plausible = false;
        }
    }
    fit
}

/// Finds the delays of some channels: those that leave the least of the motor
/// torque unexplained.
///
/// - `wanted`: indices of channels, at most one per joint.
///
/// The motor row of a joint holds the spring torque of that joint alone, so
/// joints do not disturb each other, and it has a right-hand side, so that the
/// delay cannot shrink the solution instead of fitting it. The search covers
/// -0.05 s to 0.5 s, at most an eighth of the excerpt either way, in steps of
/// 10 ms, then in steps of a sample, then by a parabola; delays at which the
/// stiffness is negative do not count.
///
/// Returns nothing if the excerpt is too short.
#[must_use]
pub fn estimate_delays(
    excerpt: &Excerpt,
    reading: &Reading<'_>,
    wanted: &[usize],
) -> Option<Vec<DelayEstimate>> {
    let search = Search {
        excerpt,
        reading,
        wanted,
    };
    let without = search.attempt(&vec![0.0; wanted.len()])?;
    let range = search.range();
    let coarse = COARSE.max(excerpt.period);
    let mut best = vec![(0.0, f64::INFINITY); wanted.len()];
    search.improve(&vec![0.0; wanted.len()], range, coarse, &mut best);
    let mut step = coarse;
    while step > excerpt.period {
        let centres: Vec<f64> = best.iter().map(|&(delay, _)| delay).collect();
        let finer = excerpt.period * (step / excerpt.period / 10.0).max(1.0).floor();
        search.improve(&centres, (-step, step), finer, &mut best);
        step = finer;
    }
    let refined = search.refine(&best)?;
    let at: Vec<f64> = refined.iter().map(|&(delay, _)| delay).collect();
    let with = search.attempt(&at)?;
    let estimate = |i: usize| {
        let (delay, standard_error) = refined[i];
        let joint = search.joint(i);
        let inside = delay > range.0 + 0.5 * coarse && delay < range.1 - 0.5 * coarse;
        let better = with[joint].relative_residual <= without[joint].relative_residual;
        DelayEstimate {
            channel: wanted[i],
            delay,
            standard_error,
            found: inside && better && best[i].1.is_finite() && standard_error.is_finite(),
            without: without[joint],
            with: with[joint],
        }
    };
    Some((0..wanted.len()).map(estimate).collect())
}

/// What a search for delays looks at.
struct Search<'a> {
    excerpt: &'a Excerpt,
    reading: &'a Reading<'a>,
    wanted: &'a [usize],
}

impl Search<'_> {
    fn joint(&self, i: usize) -> usize {
        self.reading.channels.all[self.wanted[i]].joint
    }

    fn duration(&self) -> f64 {
        self.excerpt.samples as f64 * self.excerpt.period
    }

    fn range(&self) -> (f64, f64) {
        let eighth = self.duration() / 8.0;
        (EARLIEST.max(-eighth), LATEST.min(eighth))
    }

    fn attempt(&self, at: &[f64]) -> Option<Vec<MotorRowFit>> {
        let mut delays = self.reading.delays.to_vec();
        for (&channel, &delay) in self.wanted.iter().zip(at) {
            delays[channel] = delay;
        }
        let reading = Reading {
            delays: &delays,
            ..*self.reading
        };
        fit_motor_rows(self.excerpt, &reading)
    }

    /// Tries delays around centres and keeps the best of each channel.
    fn improve(&self, centres: &[f64], range: (f64, f64), step: f64, best: &mut [(f64, f64)]) {
        let count = ((range.1 - range.0) / step).round() as u32;
        for k in 0..=count {
            let offset = range.0 + f64::from(k) * step;
            let at: Vec<f64> = centres.iter().map(|centre| centre + offset).collect();
            // Too long a delay leaves too little of a short log: no candidate.
            let Some(fits) = self.attempt(&at) else {
                continue;
            };
            for (i, best) in best.iter_mut().enumerate() {
                let fit = &fits[self.joint(i)];
                let cost = fit.relative_residual.powi(2);
                // A spring pulls back: other minima are echoes of the motion.
                if fit.stiffness.is_none_or(|k| k > 0.0) && cost < best.1 {
                    *best = (at[i], cost);
                }
            }
        }
    }

    /// Puts a parabola through the best and its neighbours; returns delay and
    /// standard error of each channel.
    fn refine(&self, best: &[(f64, f64)]) -> Option<Vec<(f64, f64)>> {
        let period = self.excerpt.period;
        let shifted = |by: f64| {
            let at: Vec<f64> = best.iter().map(|&(delay, _)| delay + by).collect();
            self.attempt(&at)
        };
        let (before, after) = (shifted(-period)?, shifted(period)?);
        let cutoff = self.reading.settings.filter_cutoff_rad_per_s;
        // Filtered residuals agree over about 2/λ.
        let independent = (self.duration() * cutoff / 2.0).max(1.0);
        let refine = |(i, &(delay, cost)): (usize, &(f64, f64))| {
            let left = before[self.joint(i)].relative_residual.powi(2);
            let right = after[self.joint(i)].relative_residual.powi(2);
            let curvature = (left - 2.0 * cost + right) / period.powi(2);
            if curvature.is_nan() || curvature <= 0.0 {
                return (delay, f64::INFINITY);
            }
            let slope = (right - left) / (2.0 * period);
            let error = (2.0 * cost / (independent * curvature)).sqrt();
            (delay + (-slope / curvature).clamp(-period, period), error)
        };
        Some(best.iter().enumerate().map(refine).collect())
    }
}
