//! Delays of channels, found from the motor rows.

use sprung_core::drives::MOTOR_SIDE;

use crate::log::LogBlock;
use crate::model::{JOINT_COUNT, ROWS};
use crate::regression::{Reading, Stages, SystemPart, solve};

/// Where rotor inertia and stiffness stand in [`MOTOR_SIDE`].
pub(super) const ROTOR_INERTIA: usize = 0;
pub(super) const STIFFNESS: usize = 2;

/// Samples that the search looks at, at most.
const EXCERPT: usize = 30_000;

/// Delays that are tried, s.
const EARLIEST: f64 = -0.05;
const LATEST: f64 = 0.5;

/// Distance of the delays that are tried first, s.
const COARSE: f64 = 0.01;

/// The beginning of a log, kept in memory.
#[derive(Clone, Debug)]
pub struct Excerpt {
    blocks: Vec<LogBlock>,
    samples: usize,
    period: f64,
}

impl Excerpt {
    /// Returns an empty excerpt of a log with period T, s.
    #[must_use]
    pub fn new(period: f64) -> Self {
        Self {
            blocks: Vec::new(),
            samples: 0,
            period,
        }
    }

    /// Takes the next block; returns whether more would be kept.
    pub fn push(&mut self, block: &LogBlock) -> bool {
        if self.samples < EXCERPT {
            self.samples += block.len();
            self.blocks.push(block.clone());
        }
        self.samples < EXCERPT
    }
}

/// What the motor rows say under an assumption about the log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorRowFit {
    /// Values of the kinds in [`MOTOR_SIDE`].
    pub values: [f64; MOTOR_SIDE.len()],
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
    /// What the motor row says without and with the delay.
    pub without: MotorRowFit,
    /// The same with it.
    pub with: MotorRowFit,
}

/// Fits the motor rows of an excerpt alone.
///
/// Returns nothing if the excerpt is too short for the filter or the settings
/// do not fit the log.
#[must_use]
pub fn fit_motor_rows(
    excerpt: &Excerpt,
    reading: &Reading<'_>,
) -> Option<[MotorRowFit; JOINT_COUNT]> {
    let mut stages = Stages::new(reading, excerpt.period).ok()?;
    for block in &excerpt.blocks {
        stages.push(block, &mut ());
    }
    let whole = stages.finish(&mut ())?.whole()?;
    let local: Vec<usize> = (0..MOTOR_SIDE.len()).collect();
    let mut fits = [MotorRowFit {
        values: [0.0; MOTOR_SIDE.len()],
        relative_residual: f64::INFINITY,
    }; JOINT_COUNT];
    for (fit, factor) in fits.iter_mut().zip(&whole[ROWS - JOINT_COUNT..]) {
        let part = SystemPart {
            columns: &local,
            factor,
        };
        let solution = solve(&[part], MOTOR_SIDE.len())?;
        let squares: f64 = factor.residual(&solution.x).iter().map(|r| r * r).sum();
        for (value, x) in fit.values.iter_mut().zip(&solution.x) {
            *value = *x;
        }
        fit.relative_residual = squares.sqrt() / factor.rhs_norm();
    }
    Some(fits)
}

/// Finds the delays of some channels: those that leave the least of the motor
/// torque unexplained.
///
/// - `wanted`: indices of channels, at most one per joint.
///
/// The motor row of a joint holds the spring torque of that joint alone, so
/// joints do not disturb each other, and it has a right-hand side, so that the
/// delay cannot shrink the solution instead of fitting it. The search covers
/// -0.05 s to 0.5 s in steps of 10 ms, then in steps of a sample, then by a
/// parabola; delays at which the stiffness is negative do not count.
///
/// Returns nothing if the excerpt is too short.
#[must_use]
pub fn estimate_delays(
    excerpt: &Excerpt,
    reading: &Reading<'_>,
    wanted: &[usize],
) -> Option<Vec<DelayEstimate>> {
    let attempt = |at: &[f64]| {
        let mut delays = reading.delays.to_vec();
        for (&channel, &delay) in wanted.iter().zip(at) {
            delays[channel] = delay;
        }
        let reading = Reading {
            delays: &delays,
            ..*reading
        };
        fit_motor_rows(excerpt, &reading)
    };
    let channels = reading.channels;
    let joint = |i: usize| channels.all[wanted[i]].joint;
    let duration = excerpt.samples as f64 * excerpt.period;
    let (from, to) = (EARLIEST.max(-duration / 8.0), LATEST.min(duration / 8.0));
    let without = attempt(&vec![0.0; wanted.len()])?;
    let mut best = vec![(0.0, f64::INFINITY); wanted.len()];
    let mut step = COARSE.max(excerpt.period);
    let count = ((to - from) / step).floor() as u32;
    let mut offsets: Vec<f64> = (0..=count).map(|k| from + f64::from(k) * step).collect();
    let mut centres = vec![0.0; wanted.len()];
    loop {
        for offset in &offsets {
            let at: Vec<f64> = centres.iter().map(|centre| centre + offset).collect();
            // Too long a delay leaves too little of a short log: no candidate.
            let Some(fits) = attempt(&at) else { continue };
            for (i, best) in best.iter_mut().enumerate() {
                let fit = &fits[joint(i)];
                let cost = fit.relative_residual.powi(2);
                // A spring pulls back: other minima are echoes of the motion.
                if fit.values[STIFFNESS] > 0.0 && cost < best.1 {
                    *best = (at[i], cost);
                }
            }
        }
        if step <= excerpt.period {
            break;
        }
        centres = best.iter().map(|&(delay, _)| delay).collect();
        let reach = (step / excerpt.period).ceil();
        step = excerpt.period * (reach / 10.0).max(1.0).floor();
        let count = (reach * excerpt.period / step).ceil();
        let mut k = -count;
        offsets.clear();
        while k <= count {
            offsets.push(k * step);
            k += 1.0;
        }
    }

    let shifted = |by: f64| {
        let at: Vec<f64> = best.iter().map(|&(delay, _)| delay + by).collect();
        attempt(&at)
    };
    let (before, after) = (shifted(-excerpt.period)?, shifted(excerpt.period)?);
    let refined: Vec<(f64, f64)> = best
        .iter()
        .enumerate()
        .map(|(i, &(delay, cost))| {
            let left = before[joint(i)].relative_residual.powi(2);
            let right = after[joint(i)].relative_residual.powi(2);
            let curvature = (left - 2.0 * cost + right) / excerpt.period.powi(2);
            let slope = (right - left) / (2.0 * excerpt.period);
            let move_by = (-slope / curvature).clamp(-excerpt.period, excerpt.period);
            // Filtered residuals agree over about 2/λ.
            let independent = (duration * reading.settings.filter_cutoff_rad_per_s / 2.0).max(1.0);
            let error = (2.0 * cost / (independent * curvature)).sqrt();
            if curvature > 0.0 {
                (delay + move_by, error)
            } else {
                (delay, f64::INFINITY)
            }
        })
        .collect();
    let at: Vec<f64> = refined.iter().map(|&(delay, _)| delay).collect();
    let with = attempt(&at)?;
    Some(
        wanted
            .iter()
            .zip(&refined)
            .enumerate()
            .map(|(i, (&channel, &(delay, standard_error)))| DelayEstimate {
                channel,
                delay,
                standard_error,
                without: without[joint(i)],
                with: with[joint(i)],
            })
            .collect(),
    )
}
