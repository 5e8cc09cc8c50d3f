//! Spectra of torques, motor positions and directions of motion at the lines that the motion excites.

use faer::c64;

use crate::frequency::record::Segment;
use crate::frequency::spectra::{Spectra, imaginary};

/// Least power of a motor position relative to that of its noise at an excited line.
const LEAST_SIGNAL_TO_NOISE: f64 = 30.0;

/// Least power of the torque of a motor at an excited line, relative to the largest one. Beyond the commanded motion,
/// dry friction and noise move the motors, and feedback responds with torque.
const LEAST_TORQUE: f64 = 0.005;

/// Half the number of lines over which powers are averaged.
pub(super) const POWER_LINES: usize = 12;

/// Most lines of a fit.
const MOST_LINES: usize = 2000;

/// Fewest lines of a fit, and more for each joint.
const FEWEST_LINES: usize = 60;
const FEWEST_LINES_PER_JOINT: usize = 10;

/// Time over which a velocity is a difference of positions, s.
const VELOCITY_TIME_S: f64 = 0.01;

/// Spectra of all joints at some lines.
#[derive(Clone, Debug)]
pub(super) struct Lines {
    /// Frequencies, Hz.
    pub(super) hz: Vec<f64>,
    /// s = jω, rad/s.
    pub(super) s: Vec<c64>,
    /// Motor torques, \[n\]\[lines\].
    pub(super) torque: Vec<Vec<c64>>,
    /// Motor positions, \[n\]\[lines\].
    pub(super) motor: Vec<Vec<c64>>,
    /// Directions of motion of joints with dry friction, \[n\]\[lines\]; `None` without.
    pub(super) direction: Vec<Option<Vec<c64>>>,
}

impl Lines {
    /// Returns the lines up to the highest excited frequency; `None` if they are too few.
    ///
    /// - `sharpness`: of the dry friction of each joint, s/rad (s/m); `None` without.
    pub(super) fn of(segment: &Segment, sharpness: &[Option<f64>]) -> Option<Self> {
        let spectra = Spectra::of(segment)?;
        let excited = (spectra.motor.iter().zip(&spectra.torque))
            .map(|(motor, torque)| highest_excited(motor, torque))
            .max()?;
        let fewest = FEWEST_LINES + FEWEST_LINES_PER_JOINT * spectra.motor.len();
        if excited < fewest {
            return None;
        }
        let directions = spectra.of_columns(&directions(segment, sharpness));
        Some(Self::first(&spectra, &directions, sharpness, excited + 1).thinned(MOST_LINES))
    }

    /// Returns the lines of a part of the log up to a frequency, Hz; `None` if it is too short.
    pub(super) fn below(segment: &Segment, sharpness: &[Option<f64>], hz: f64) -> Option<Self> {
        let spectra = Spectra::of(segment)?;
        let count = spectra.hz.partition_point(|frequency| *frequency <= hz);
        let directions = spectra.of_columns(&directions(segment, sharpness));
        Some(Self::first(&spectra, &directions, sharpness, count).thinned(MOST_LINES))
    }

    /// Returns the first lines of spectra.
    fn first(
        spectra: &Spectra,
        directions: &[Vec<c64>],
        sharpness: &[Option<f64>],
        count: usize,
    ) -> Self {
        let count = count.min(spectra.hz.len());
        let whole = |all: &Vec<c64>| all[..count].to_vec();
        Self {
            hz: spectra.hz[..count].to_vec(),
            s: spectra.hz[..count]
                .iter()
                .map(|hz| imaginary(*hz))
                .collect(),
            torque: spectra.torque.iter().map(whole).collect(),
            motor: spectra.motor.iter().map(whole).collect(),
            direction: (sharpness.iter().zip(directions))
                .map(|(sharpness, spectrum)| sharpness.map(|_| whole(spectrum)))
                .collect(),
        }
    }

    /// Returns at most a number of lines: the strongest one of each group of neighbours, because a
    /// motion that repeats itself excites only every n-th line.
    pub(super) fn thinned(&self, most: usize) -> Self {
        let every = self.s.len().div_ceil(most).max(1);
        let strength = |line: usize| -> f64 {
            (self.motor.iter())
                .map(|spectrum| {
                    spectrum[line].norm_sqr()
                        / mean_power(spectrum, line, every).max(f64::MIN_POSITIVE)
                })
                .sum()
        };
        let all: Vec<usize> = (0..self.s.len()).collect();
        let chosen: Vec<usize> = (all.chunks(every))
            .filter_map(|group| {
                let strongest = |a: &&usize, b: &&usize| strength(**a).total_cmp(&strength(**b));
                group.iter().max_by(strongest).copied()
            })
            .collect();
        let pick = |all: &Vec<c64>| -> Vec<c64> { chosen.iter().map(|&line| all[line]).collect() };
        Self {
            hz: chosen.iter().map(|&line| self.hz[line]).collect(),
            s: pick(&self.s),
            torque: self.torque.iter().map(pick).collect(),
            motor: self.motor.iter().map(pick).collect(),
            direction: (self.direction.iter())
                .map(|spectrum| spectrum.as_ref().map(pick))
                .collect(),
        }
    }

    /// Returns the number of joints.
    pub(super) fn joints(&self) -> usize {
        self.motor.len()
    }
}

/// Returns the highest line at which a motor moves clearly more than its noise, by a torque that is not
/// much smaller than its largest one.
fn highest_excited(motor: &[c64], torque: &[c64]) -> usize {
    let noise = power(&motor[motor.len() - motor.len() / 4..]);
    let of_torque = |line: usize| mean_power(torque, line, POWER_LINES);
    let is_clear =
        |line: &usize| mean_power(motor, *line, POWER_LINES) > LEAST_SIGNAL_TO_NOISE * noise;
    let clear: Vec<usize> = (0..motor.len()).filter(is_clear).collect();
    let largest = (clear.iter())
        .map(|&line| of_torque(line))
        .fold(0.0, f64::max);
    let last = (clear.iter()).rfind(|&&line| of_torque(line) > LEAST_TORQUE * largest);
    last.copied().unwrap_or(0)
}

/// Returns the direction of motion of each motor, between -1 and 1; zero without dry friction.
fn directions(segment: &Segment, sharpness: &[Option<f64>]) -> Vec<Vec<f64>> {
    let count = segment.len();
    let lag = ((0.5 * VELOCITY_TIME_S / segment.period()) as usize).max(1);
    (sharpness.iter().enumerate())
        .map(|(joint, sharpness)| {
            let motor = segment.motor(joint);
            (0..count)
                .map(|k| {
                    let (from, to) = (k.saturating_sub(lag), (k + lag).min(count - 1));
                    let velocity =
                        (motor[to] - motor[from]) / ((to - from) as f64 * segment.period());
                    sharpness.map_or(0.0, |sharpness| (sharpness * velocity).tanh())
                })
                .collect()
        })
        .collect()
}

/// Returns the mean power of lines.
fn power(lines: &[c64]) -> f64 {
    lines.iter().map(c64::norm_sqr).sum::<f64>() / lines.len().max(1) as f64
}

/// Returns the mean power of the lines about a line.
pub(super) fn mean_power(lines: &[c64], line: usize, half: usize) -> f64 {
    power(&lines[line.saturating_sub(half)..(line + half + 1).min(lines.len())])
}
