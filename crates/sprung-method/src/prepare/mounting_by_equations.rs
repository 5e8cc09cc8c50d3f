//! Mountings of accelerometers by the equations of motion.
//!
//! The motors predict the acceleration of a soft link badly, but its torques show its deflection. The rows are linear
//! in the parameters, and nearly so in small changes of the mountings m, so both are found together by Gauss-Newton
//! steps:
//!
//! ```text
//! A(m) theta + (dA/dm theta) step = b        step / width = 0
//! ```
//!
//! The second equation has the weight of one independent sample. It keeps directions in which the rows do not change,
//! such as a turn of sensor and place about a vertical first axis.
//!
//! The steps need a start. From the base to the tip, the mounting comes from means over windows in which the sensors
//! give the motion of the links below, then its distance from a scan, then from steps on the motor row alone.

use std::ops::Range;

use sprung_core::parameters::JointParameter;

use super::excerpt::Excerpt;
use super::mounting::{UNKNOWNS, Window, fit_windows, mean_residual, moved, windows};
use super::row::independent;
use crate::description::Inertial;
use crate::fit::{Free, influences, scatter};
use crate::log::{Channels, LogBlock, Quantity};
use crate::model::{Model, Theta};
use crate::regression::{Reading, Reduction, Solution, SystemPart, Triangle, solve};

/// Largest rotations, rad, and displacements, m, that count as small changes.
const WIDTHS: [f64; UNKNOWNS] = [0.3, 0.3, 0.3, 0.1, 0.1, 0.1];

/// Step of the differences, rad and m.
const DIFFERENCE: f64 = 1e-5;

/// Powers of two by which the place is scaled in the scan. Near a resonance the motors predict the acceleration
/// several times too small or too large.
const SCAN: Range<i32> = -4..3;
const SCANS_PER_POWER: i32 = 2;

const MAX_STEPS: usize = 12;
const MAX_HALVINGS: i32 = 5;

/// Least relative decrease of the squared residuals by a step before another one.
const MIN_DECREASE: f64 = 1e-5;

/// Parts of the log that are left out in turn for the standard errors.
const GROUPS: usize = 16;

/// Largest relative standard error of a stiffness for a determined mounting.
const MAX_STIFFNESS_ERROR: f64 = 0.05;

/// Returns the reading with the mountings of accelerometers that the description does not give and the equations
/// determine well enough for the stiffnesses.
#[must_use]
pub(super) fn with_mountings(reading: &Reading, excerpt: &Excerpt) -> Reading {
    let found = by_equations(reading, excerpt).unwrap_or_else(|| {
        let mut channels = reading.channels().clone();
        let sensors = channels
            .inertial
            .iter_mut()
            .flat_map(|inertial| &mut inertial.all);
        sensors.for_each(|sensor| sensor.stiffness_error = None);
        channels
    });
    reading.with_channels(found)
}

fn by_equations(reading: &Reading, excerpt: &Excerpt) -> Option<Channels> {
    let (channels, model) = (reading.channels(), reading.model());
    let sensors = channels.inertial.as_ref()?;
    let open: Vec<Open> = (sensors.all.iter().enumerate())
        .filter(|(_, sensor)| !sensor.is_mounted)
        .map(|(index, sensor)| Open {
            index,
            joint: sensor.joint,
            windows: windows(channels, sensor, excerpt),
        })
        .collect();
    let has_motion = open.iter().all(|mounting| !mounting.windows.is_empty());
    if sensors.kind != Inertial::Accelerometer || open.is_empty() || !has_motion {
        return None;
    }
    let mut search = MountingSearch {
        reading: &reading.without_weights(),
        excerpt,
        free: Free::new(model),
        rows: (0..model.rows()).collect(),
        open,
    };
    let start = search.start(channels.clone())?;
    search.rows = (0..model.rows()).collect();
    let all = 0..search.open.len();
    let found = search.descend(start, &all)?;
    search.judged(found)
}

/// A sensor without mounting.
struct Open {
    /// Among the sensors.
    index: usize,
    joint: usize,
    windows: Vec<Window>,
}

struct MountingSearch<'a> {
    reading: &'a Reading,
    excerpt: &'a Excerpt,
    free: Free,
    /// The rows that count.
    rows: Vec<usize>,
    open: Vec<Open>,
}

/// Samples of each row: entries and right-hand side.
type Lines = Vec<Vec<Vec<f64>>>;

/// The rows at a mounting, linearised about it.
struct Linear {
    lines: Lines,
    /// Changes of the residuals of each row with each unknown of the mountings.
    slopes: Vec<Vec<Vec<f64>>>,
    /// Weight of each row: the inverse of its residual.
    weights: Vec<f64>,
}

impl MountingSearch<'_> {
    fn model(&self) -> &Model {
        self.reading.model()
    }

    /// Returns channels with a start of all open mountings.
    fn start(&mut self, mut channels: Channels) -> Option<Channels> {
        for i in 0..self.open.len() {
            let joint = self.open[i].joint;
            self.rows = vec![self.model().torque_row(joint)];
            let sensors = channels.inertial.as_ref()?;
            if sensors.all.iter().any(|sensor| sensor.joint < joint)
                && let Some(followed) = self.followed(&channels, joint)
            {
                let index = self.open[i].index;
                self.open[i].windows = windows(&channels, &sensors.all[index], &followed);
                fit_windows(channels.inertial.as_mut()?, index, &self.open[i].windows);
            }
            channels = self.scanned(&channels, i)?;
        }
        Some(channels)
    }

    /// Returns the excerpt with the link positions of the joints below a joint in place of those of their motors;
    /// `None` if motors move several joints, or if the excerpt is too short.
    fn followed(&self, channels: &Channels, joint: usize) -> Option<Excerpt> {
        if channels.position_mix.is_some() {
            return None;
        }
        let reading = self.reading.with_channels(channels.clone());
        let signals = self.excerpt.smoothed(&reading)?;
        let mut followed = self.excerpt.emptied(1);
        let time: Vec<f64> = (self.excerpt.blocks().iter())
            .flat_map(|block| block.time.iter().copied())
            .collect();
        let raw: Vec<Vec<f64>> = (0..channels.all.len())
            .map(|channel| self.excerpt.channel(channel).collect())
            .collect();
        let half = 0.5 * self.excerpt.period();
        for segment in signals.segments() {
            let begin = time.partition_point(|t| *t < segment.time[0] - half);
            let samples = segment.len().min(time.len() - begin);
            let mut block = LogBlock::new(raw.len());
            block.time.extend(&segment.time[..samples]);
            for (i, channel) in channels.all.iter().enumerate() {
                let below = channel.joint < joint && channel.quantity == Quantity::MotorPosition;
                block.values[i].extend_from_slice(if below {
                    &segment.q[channel.joint][..samples]
                } else {
                    &raw[i][begin..begin + samples]
                });
                if below {
                    let offset = channels.offsets[channel.joint];
                    block.values[i].iter_mut().for_each(|q| *q -= offset);
                }
            }
            followed.push(&block);
        }
        Some(followed)
    }

    /// Returns the channels with the mounting of a sensor that leaves the least residual of its motor row with a
    /// positive stiffness, by steps from the best distances of a scan.
    fn scanned(&self, channels: &Channels, open: usize) -> Option<Channels> {
        let unit = vec![1.0; self.model().rows()];
        let stiffness = (self.model()).index(JointParameter::Stiffness, self.open[open].joint)?;
        let squares = |channels: &Channels| -> Option<f64> {
            let (theta, squares) = self.fit(&self.lines(channels)?, &unit)?;
            (theta[stiffness] > 0.0).then_some(squares)
        };
        let tried: Vec<(f64, Channels)> = (SCANS_PER_POWER * SCAN.start
            ..=SCANS_PER_POWER * SCAN.end)
            .filter_map(|k| {
                let mut tried = channels.clone();
                let sensor = &mut tried.inertial.as_mut()?.all[self.open[open].index];
                let factor = (f64::from(k) / f64::from(SCANS_PER_POWER)).exp2();
                sensor.position = sensor.position.map(|x| factor * x);
                let tried = self.moved(&tried, &vec![0.0; self.unknowns()]);
                Some((squares(&tried).unwrap_or(f64::INFINITY), tried))
            })
            .collect();
        let is_least = |k: usize| {
            let at = |k: usize| tried.get(k).map_or(f64::INFINITY, |candidate| candidate.0);
            at(k) < at(k + 1) && k.checked_sub(1).is_none_or(|before| at(k) <= at(before))
        };
        let least = (0..tried.len())
            .filter(|&k| is_least(k))
            .map(|k| &tried[k].1);
        (least.chain([channels]))
            .filter_map(|start| {
                let found = self.descend(start.clone(), &(open..open + 1))?;
                Some((squares(&found)?, found))
            })
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, found)| found)
    }

    /// Number of unknowns of all mountings.
    fn unknowns(&self) -> usize {
        UNKNOWNS * self.open.len()
    }

    /// Returns the channels with mountings moved by a step, and their biases.
    fn moved(&self, channels: &Channels, step: &[f64]) -> Channels {
        let mut channels = channels.clone();
        if let Some(sensors) = &mut channels.inertial {
            for (open, step) in self.open.iter().zip(step.chunks(UNKNOWNS)) {
                let step: [f64; UNKNOWNS] = std::array::from_fn(|k| step[k]);
                sensors.all[open.index] = moved(&sensors.all[open.index], &step);
                let bias = mean_residual(sensors, &sensors.all[open.index], &open.windows);
                sensors.all[open.index].bias = bias;
            }
        }
        channels
    }

    fn lines(&self, channels: &Channels) -> Option<Lines> {
        let reading = self.reading.with_channels(channels.clone());
        let signals = self.excerpt.smoothed(&reading)?.thinned(&reading);
        let system = signals.reduce_by(Reduction::new(reading.model()), &reading)?;
        let lines = &system.kept().rows;
        let numbers = || lines.iter().flatten().flatten();
        (numbers().next().is_some() && numbers().all(|x| x.is_finite())).then(|| lines.clone())
    }

    /// Returns theta and the squared residuals of the rows that count.
    fn fit(&self, lines: &Lines, weights: &[f64]) -> Option<(Theta, f64)> {
        let linear = Linear {
            lines: lines.clone(),
            slopes: Vec::new(),
            weights: weights.to_vec(),
        };
        let theta = self.theta(&self.solve(&linear)?);
        let residuals = self.residuals(lines, &theta);
        let squares = (self.rows.iter())
            .map(|&row| weights[row].powi(2) * squares(&residuals[row]))
            .sum();
        Some((theta, squares))
    }

    fn theta(&self, solution: &Solution) -> Theta {
        let unknowns = &solution.x[..self.free.unknowns.len()];
        self.free.whole(unknowns, |value| value)
    }

    /// Returns the residuals of all rows, sample by sample.
    fn residuals(&self, lines: &Lines, theta: &[f64]) -> Vec<Vec<f64>> {
        (lines.iter().enumerate())
            .map(|(row, lines)| {
                let columns = self.model().row_columns(row);
                let fitted = |line: &[f64]| -> f64 {
                    let pairs = columns.iter().zip(line);
                    pairs.map(|(&c, x)| theta[c] * x).sum()
                };
                let rest = lines.iter().map(|line| fitted(line) - line[columns.len()]);
                rest.collect()
            })
            .collect()
    }

    /// Linearises the rows about a mounting.
    ///
    /// - `sensors`: those that may move.
    fn linear(&self, channels: &Channels, sensors: &Range<usize>) -> Option<Linear> {
        let lines = self.lines(channels)?;
        let (theta, _) = self.fit(&lines, &vec![1.0; lines.len()])?;
        let weights: Vec<f64> = (self.residuals(&lines, &theta).iter())
            .map(|rest| (rest.len() as f64 / squares(rest).max(f64::MIN_POSITIVE)).sqrt())
            .collect();
        let (theta, _) = self.fit(&lines, &weights)?;
        let before = self.residuals(&lines, &theta);
        let slope = |unknown: usize| -> Option<Vec<Vec<f64>>> {
            if !sensors.contains(&(unknown / UNKNOWNS)) {
                return Some(before.iter().map(|rest| vec![0.0; rest.len()]).collect());
            }
            let mut step = vec![0.0; self.unknowns()];
            step[unknown] = DIFFERENCE;
            let after = self.lines(&self.moved(channels, &step))?;
            let after = self.residuals(&after, &theta);
            let rows = after.iter().zip(&before).map(|(after, before)| {
                let pairs = after.iter().zip(before);
                pairs.map(|(a, b)| (a - b) / DIFFERENCE).collect()
            });
            Some(rows.collect())
        };
        Some(Linear {
            slopes: (0..self.unknowns()).map(slope).collect::<Option<_>>()?,
            lines,
            weights,
        })
    }

    /// Returns the columns of each row that counts among theta and step.
    fn columns(&self, linear: &Linear) -> Vec<Vec<usize>> {
        let p = self.free.unknowns.len();
        let steps = p..p + linear.slopes.len();
        (self.rows.iter())
            .map(|&row| {
                self.free.columns[row]
                    .iter()
                    .copied()
                    .chain(steps.clone())
                    .collect()
            })
            .collect()
    }

    /// Returns the factors of samples of the rows that count.
    fn factors(&self, linear: &Linear, samples: &Range<usize>) -> Vec<Triangle> {
        let factor = |row: usize| {
            let weight = linear.weights[row];
            let lines: Vec<Vec<f64>> = (samples.clone())
                .map(|k| {
                    let line = &linear.lines[row][k];
                    let (entries, rhs) = line.split_at(line.len() - 1);
                    let slopes = linear.slopes.iter().map(|slope| slope[row][k]);
                    let all = entries.iter().copied().chain(slopes);
                    all.chain(rhs.iter().copied()).map(|x| weight * x).collect()
                })
                .collect();
            let parameters = self.model().row_columns(row).iter();
            let mut known: Vec<Option<f64>> = parameters.map(|&c| self.model().known(c)).collect();
            known.resize(known.len() + linear.slopes.len(), None);
            Triangle::of_lines(&lines).with_known(&known)
        };
        self.rows.iter().map(|&row| factor(row)).collect()
    }

    /// Solves for theta and step.
    fn solve(&self, linear: &Linear) -> Option<Solution> {
        let samples = linear.lines.first()?.len();
        let mut columns = self.columns(linear);
        let mut factors = self.factors(linear, &(0..samples));
        let (p, count) = (self.free.unknowns.len(), linear.slopes.len());
        if count > 0 {
            // Neighbouring samples depend on each other.
            let scale = (samples as f64 / independent(self.excerpt, self.reading)).sqrt();
            let keep = |i: usize| -> Vec<f64> {
                let prior_entry = |j: usize| {
                    if i == j {
                        scale / WIDTHS[i % UNKNOWNS]
                    } else {
                        0.0
                    }
                };
                (0..=count).map(prior_entry).collect()
            };
            factors.push(Triangle::of_lines(
                &(0..count).map(keep).collect::<Vec<_>>(),
            ));
            columns.push((p..p + count).collect());
        }
        let parts: Vec<SystemPart<'_>> = (columns.iter().zip(&factors))
            .map(|(columns, factor)| SystemPart { columns, factor })
            .collect();
        solve(&parts, p + count)
    }

    /// Returns the channels after steps of some sensors that lower the residuals.
    fn descend(&self, mut channels: Channels, sensors: &Range<usize>) -> Option<Channels> {
        for _ in 0..MAX_STEPS {
            let linear = self.linear(&channels, sensors)?;
            let solution = self.solve(&linear)?;
            let step = &solution.x[self.free.unknowns.len()..];
            let (_, before) = self.fit(&linear.lines, &linear.weights)?;
            let better = (0..=MAX_HALVINGS).find_map(|halvings| {
                let shorter: Vec<f64> = step
                    .iter()
                    .map(|x| x * f64::from(-halvings).exp2())
                    .collect();
                let next = self.moved(&channels, &shorter);
                let (_, after) = self.fit(&self.lines(&next)?, &linear.weights)?;
                (after < before).then_some((next, after))
            });
            let Some((next, after)) = better else {
                break;
            };
            channels = next;
            if before - after < MIN_DECREASE * before {
                break;
            }
        }
        Some(channels)
    }

    /// Returns the channels if the rows determine all stiffnesses together with the mountings.
    fn judged(&self, mut channels: Channels) -> Option<Channels> {
        let linear = self.linear(&channels, &(0..self.open.len()))?;
        let solution = self.solve(&linear)?;
        let samples = linear.lines.first()?.len();
        let groups: Vec<Vec<Triangle>> = (0..GROUPS)
            .map(|g| g * samples / GROUPS..(g + 1) * samples / GROUPS)
            .map(|part| self.factors(&linear, &part))
            .collect();
        let errors = scatter(&influences(&solution, &self.columns(&linear), &groups));
        for open in &self.open {
            let stiffness = self.model().index(JointParameter::Stiffness, open.joint)?;
            let error = match self.free.unknowns.binary_search(&stiffness) {
                Ok(at) => errors[at] / solution.x[at],
                Err(_) => 0.0,
            };
            if !(0.0..MAX_STIFFNESS_ERROR).contains(&error) {
                return None;
            }
            channels.inertial.as_mut()?.all[open.index].stiffness_error = Some(error);
        }
        Some(channels)
    }
}

fn squares(all: &[f64]) -> f64 {
    all.iter().map(|x| x * x).sum()
}
