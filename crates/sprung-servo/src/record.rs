//! The samples of the logs, segment by segment.

use sprung_core::servo::Load;

use super::bench::Bench;
use super::error::ServoError;
use crate::description::{Quantity, Signal};
use crate::log::{Channels, LogBlock, LogSource};
use crate::progress::{Listener, Phase};

/// Consecutive samples of one log.
#[derive(Clone, Debug)]
pub(crate) struct Record {
    /// Index of the log.
    pub(super) log: usize,
    /// Sampling period, s.
    pub(super) period: f64,
    /// The known load.
    pub(super) load: Load,
    /// Targets, rad.
    pub(super) target: Vec<f64>,
    /// Whether the drive was on.
    pub(super) on: Vec<bool>,
    /// Logged positions, rad.
    pub(super) position: Vec<f64>,
    /// Smoothed positions, rad, and velocities, rad/s.
    pub(super) smooth: Vec<[f64; 2]>,
    /// Standard deviation of the logged positions, rad.
    pub(super) noise: f64,
}

/// The logs of a servo.
#[derive(Clone, Debug)]
pub struct Records {
    /// Segments without gaps.
    pub(super) all: Vec<Record>,
    /// Name of each log.
    pub(super) names: Vec<String>,
}

/// Segments shorter than this are left out, s.
const SHORTEST_S: f64 = 0.5;

/// Samples on each side that a smoothed sample uses.
const SIDE: usize = 5;

/// Reads the logs of a servo.
///
/// # Errors
///
/// [`ServoError`] if a log cannot be read, has no motion, or has a value of `drive_on` other than 0
/// and 1.
pub fn read(
    bench: &Bench,
    channels: &Channels,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<Records, ServoError> {
    let mut records = Records {
        all: Vec::new(),
        names: Vec::new(),
    };
    let mut samples = 0;
    for (log, source) in sources.iter_mut().enumerate() {
        let name = source.label();
        let load = bench.loads.get(log).copied().unwrap_or_default();
        let mut reader = source.open(channels)?;
        let mut block = LogBlock::new(channels.all.len());
        let mut record = Raw::default();
        let mut found = Vec::new();
        while reader.read(&mut block)? {
            samples += block.len() as u64;
            progress.tell(Phase::Reading, samples, None)?;
            for k in 0..block.len() {
                if block.gaps.contains(&k) {
                    found.push(std::mem::take(&mut record));
                }
                record.push(channels, &block, k, &name)?;
            }
        }
        found.push(record);
        let period = reader.timing().period;
        let long = |raw: &Raw| raw.position.len() as f64 * period >= SHORTEST_S;
        let found = found.into_iter().filter(long);
        let before = records.all.len();
        (records.all).extend(found.map(|raw| raw.finished(log, period, load)));
        if records.all[before..].iter().all(|record| !record.moves()) {
            return Err(ServoError::NoMotion { log: name });
        }
        records.names.push(name);
    }
    Ok(records)
}

/// Samples that are being read.
#[derive(Default)]
struct Raw {
    target: Vec<f64>,
    on: Vec<bool>,
    position: Vec<f64>,
}

impl Raw {
    fn push(
        &mut self,
        channels: &Channels,
        block: &LogBlock,
        k: usize,
        log: &str,
    ) -> Result<(), ServoError> {
        let of = |quantity| {
            let channel = channels.index(quantity, 0)?;
            Some((channel, block.values[channel][k]))
        };
        let position = channels.telling(Signal::Motor, 0);
        let position = position.map_or(0.0, |channel| block.values[channel][k]);
        let target = of(Quantity::MotorTarget).map_or(0.0, |(_, value)| value);
        self.position.push(position + channels.offsets[0]);
        self.target.push(target + channels.offsets[0]);
        self.on.push(match of(Quantity::DriveOn) {
            None => true,
            Some((_, value)) if value.to_bits() == 1.0_f64.to_bits() => true,
            Some((_, value)) if value.abs() < f64::MIN_POSITIVE => false,
            Some((channel, value)) => {
                return Err(ServoError::NotASwitch {
                    log: log.to_owned(),
                    column: channels.all[channel].column.clone(),
                    time: block.time[k],
                    value,
                });
            }
        });
        Ok(())
    }

    fn finished(self, log: usize, period: f64, load: Load) -> Record {
        let smooth = smoothed(&self.position, period);
        let noise = noise(&self.position, &smooth);
        Record {
            log,
            period,
            load,
            target: self.target,
            on: self.on,
            position: self.position,
            smooth,
            noise,
        }
    }
}

impl Record {
    /// Returns the duration, s.
    pub(super) fn duration(&self) -> f64 {
        self.position.len() as f64 * self.period
    }

    /// Returns whether the servo moves by more than a few steps of its sensor.
    fn moves(&self) -> bool {
        let low = self.position.iter().copied().fold(f64::INFINITY, f64::min);
        let high = self
            .position
            .iter()
            .copied()
            .fold(f64::NEG_INFINITY, f64::max);
        high - low > 20.0 * self.noise
    }

    /// Returns the root mean square velocity, rad/s.
    pub(super) fn rms_velocity(&self) -> f64 {
        let sum: f64 = self.smooth.iter().map(|[_, v]| v * v).sum();
        (sum / self.smooth.len().max(1) as f64).sqrt()
    }
}

/// Returns positions, rad, and velocities, rad/s, of parabolas through the samples around each
/// sample.
fn smoothed(position: &[f64], period: f64) -> Vec<[f64; 2]> {
    let n = position.len();
    (0..n)
        .map(|k| {
            let (from, to) = (k.saturating_sub(SIDE), (k + SIDE + 1).min(n));
            let mut moments = [0.0; 5];
            let mut sums = [0.0; 3];
            for i in from..to {
                let x = i as f64 - k as f64;
                let y = position[i] - position[k];
                let powers = [1.0, x, x * x, x * x * x, x * x * x * x];
                for (moment, power) in moments.iter_mut().zip(powers) {
                    *moment += power;
                }
                for (sum, power) in sums.iter_mut().zip(powers) {
                    *sum += y * power;
                }
            }
            let matrix: Vec<f64> = (0..9).map(|at| moments[at / 3 + at % 3]).collect();
            match super::matrix::damped(&matrix, &sums, 0.0) {
                Some(x) => [position[k] + x[0], x[1] / period],
                None => [position[k], 0.0],
            }
        })
        .collect()
}

/// Returns the standard deviation of the positions: that of a step of the sensor, or that about the
/// smoothed positions where this is larger.
fn noise(position: &[f64], smooth: &[[f64; 2]]) -> f64 {
    let steps = position.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    // Differences of numbers that were rounded to a few digits are no steps.
    let step = (steps.filter(|step| *step > 1e-9)).fold(f64::INFINITY, f64::min);
    let mut about: Vec<f64> = (position.iter().zip(smooth))
        .map(|(position, [smooth, _])| (position - smooth).abs())
        .collect();
    about.sort_by(f64::total_cmp);
    // Median of the absolute value of a normal variable, and the degrees of freedom of a parabola.
    let median = 1.4826 * 1.17 * about.get(about.len() / 2).copied().unwrap_or(0.0);
    let of_step = if step.is_finite() {
        step / 12.0_f64.sqrt()
    } else {
        0.0
    };
    median.max(of_step).max(1e-7)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_of_an_encoder_are_its_noise() {
        let count = std::f64::consts::TAU / 4096.0;
        let position: Vec<f64> = (0..2000)
            .map(|k| count * ((0.005 * f64::from(k)).sin() / count).round())
            .collect();
        let smooth = smoothed(&position, 0.005);
        let found = noise(&position, &smooth);
        assert!(
            (found * 12.0_f64.sqrt() / count - 1.0).abs() < 0.3,
            "{found}"
        );
        let [at, velocity] = smooth[400];
        assert!((at - 2.0_f64.sin()).abs() < 1e-3);
        assert!((velocity - 2.0_f64.cos()).abs() < 0.1);
    }
}
