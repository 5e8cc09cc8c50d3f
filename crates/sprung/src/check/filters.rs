//! The bandwidth of the data against the filters of the file, and noise against
//! the motion.

use crate::description::Cutoff;
use crate::finding::{Finding, Severity};
use crate::log::Signal;
use crate::prepare::{Excerpt, choose_cutoff, noise, velocity_per_position};
use crate::preprocess::SignalBlock;
use crate::regression::{Reading, signals};

/// What the position filter takes away: standard deviations of the noise, and
/// part of the motion, beyond which it is motion.
const TAKEN_NOISE: f64 = 4.0;
const TAKEN_MOTION: f64 = 0.01;

/// How many times the cut-off may be the one that the noise asks for.
const TOO_HIGH: f64 = 4.0;

/// Samples in a period of the motion, at least.
const SAMPLES_PER_PERIOD: f64 = 20.0;

/// λ as a part of the sampling rate and of the motion's angular frequency.
const LAMBDA_HIGH: f64 = 0.3;
const LAMBDA_LOW: f64 = 0.1;

/// Noise of a velocity, of a deflection and of a torque that counts, as a part
/// of their standard deviations.
const VELOCITY_NOISE: f64 = 0.1;
const DEFLECTION_NOISE: f64 = 0.1;
const TORQUE_NOISE: f64 = 0.35;

struct Look<'a> {
    reading: &'a Reading,
    excerpt: &'a Excerpt,
    file: &'a str,
    signals: Vec<SignalBlock>,
}

/// Judges filters and noise of the joints that move.
pub(super) fn filters(
    reading: &Reading,
    excerpt: &Excerpt,
    file: &str,
    moving: &[usize],
) -> Vec<Finding> {
    let Ok(signals) = signals(reading, excerpt.period(), excerpt.blocks()) else {
        return Vec::new();
    };
    let look = Look {
        reading,
        excerpt,
        file,
        signals,
    };
    let mut findings: Vec<Finding> = look.too_high().into_iter().collect();
    for &joint in moving {
        findings.extend(look.takes_motion(joint));
        findings.extend(look.rate(joint));
        findings.extend(look.noises(joint));
    }
    findings
}

/// Returns the standard deviation of values about their mean.
fn deviation(values: impl Iterator<Item = f64>) -> f64 {
    let (mut n, mut mean, mut squares) = (0.0, 0.0, 0.0);
    for value in values {
        n += 1.0;
        let from = value - mean;
        mean += from / n;
        squares += from * (value - mean);
    }
    (squares / f64::max(n, 1.0)).sqrt()
}

impl Look<'_> {
    fn name(&self, joint: usize) -> &str {
        &self.reading.model().joints()[joint]
    }

    /// The cut-off that the file gives lets too much noise through.
    fn too_high(&self) -> Option<Finding> {
        let Cutoff::Fixed(given) = self.reading.settings().position_cutoff_hz else {
            return None;
        };
        let (chosen, reason) = choose_cutoff(
            self.reading.model(),
            self.reading.channels(),
            self.reading.settings().weights,
            self.excerpt,
        );
        (given > TOO_HIGH * chosen && reason.starts_with('"')).then(|| {
            Finding::new(
                Severity::Warning,
                "position-cutoff-high",
                format!(
                    "position_cutoff_hz = {given} lets noise through: for {chosen:.1} Hz speaks that \
                     {reason}"
                ),
                "set position_cutoff_hz = \"auto\" in [identify]",
            )
            .seen(self.file, "", given / chosen, "")
            .mended_by("[identify]", "position_cutoff_hz = \"auto\"")
        })
    }

    /// Returns raw and filtered motor positions of a joint, and the period of
    /// its motion, s.
    fn taken(&self, joint: usize, channel: usize) -> Option<(f64, f64)> {
        let raw = (self.excerpt.blocks().iter())
            .flat_map(|block| block.time.iter().zip(&block.values[channel]));
        let mut raw = raw.peekable();
        let half = 0.5 * self.excerpt.period();
        let mut differences = Vec::new();
        let mut kept = Vec::new();
        for block in &self.signals {
            for (time, value) in block.time.iter().zip(&block.phi[joint]) {
                while raw.next_if(|(at, _)| **at < time - half).is_some() {}
                let (at, measured) = raw.peek()?;
                if (**at - time).abs() <= half {
                    differences.push(*measured - value);
                    kept.push(*value);
                }
            }
        }
        // The filter's own transient at the ends is not the motion's.
        let edge = differences.len() / 20;
        let inside = |values: &[f64]| {
            let values = values.get(edge..values.len() - edge).unwrap_or_default();
            deviation(values.iter().copied())
        };
        Some((inside(&differences), inside(&kept)))
    }

    /// The position filter takes away motion, not only noise.
    fn takes_motion(&self, joint: usize) -> Option<Finding> {
        let channels = self.reading.channels();
        let channel = channels.telling(Signal::Motor, joint)?;
        let delayed = self.reading.delays().iter().any(|delay| *delay != 0.0);
        if channels.position_mix.is_some() || delayed {
            return None;
        }
        let (taken, motion) = self.taken(joint, channel)?;
        let (white, _) = noise(self.excerpt, channel)?;
        let cutoff = self.reading.position_cutoff_hz();
        (taken > TAKEN_NOISE * white && taken > TAKEN_MOTION * motion).then(|| {
            Finding::new(
                Severity::Warning,
                "position-cutoff-low",
                format!(
                    "{}: the position filter at {cutoff:.1} Hz takes {taken:.2e} rad (m) away from \
                     \"{}\", {:.0} times its noise and {:.1} % of its motion",
                    self.name(joint),
                    channels.all[channel].column,
                    taken / white,
                    100.0 * taken / motion
                ),
                "choose a higher position_cutoff_hz in [identify], or \"auto\"",
            )
            .seen(self.file, &channels.all[channel].column, taken, "rad")
            .mended_by(
                "[identify]",
                &format!("position_cutoff_hz = {:.0}", 2.0 * cutoff),
            )
        })
    }

    /// Sampling rate and λ against the motion.
    fn rate(&self, joint: usize) -> Option<Finding> {
        let period = self.excerpt.period();
        let velocity = deviation(
            self.signals
                .iter()
                .flat_map(|s| s.dphi[joint].iter().copied()),
        );
        let steps = (self.signals.iter())
            .flat_map(|s| s.dphi[joint].windows(2).map(|w| (w[1] - w[0]) / period));
        let acceleration = deviation(steps);
        let frequency = acceleration / velocity;
        if !frequency.is_finite() || frequency <= 0.0 {
            return None;
        }
        let samples = std::f64::consts::TAU / (frequency * period);
        let lambda = self.reading.settings().filter_cutoff_rad_per_s;
        let name = self.name(joint);
        if samples < SAMPLES_PER_PERIOD {
            return Some(
                Finding::new(
                    Severity::Warning,
                    "sampled-slowly",
                    format!(
                        "{name}: {samples:.0} samples in a period of its motion ({:.1} Hz); \
                         velocities from so few are wrong",
                        frequency / std::f64::consts::TAU
                    ),
                    "record faster, or move more slowly",
                )
                .seen(self.file, "", samples, "samples"),
            );
        }
        let (words, better) = if lambda * period > LAMBDA_HIGH {
            ("little below the sampling rate", 0.1 / period)
        } else if lambda < LAMBDA_LOW * frequency {
            ("far below the frequency of the motion", frequency)
        } else {
            return None;
        };
        Some(
            Finding::new(
                Severity::Warning,
                "filter-cutoff",
                format!(
                    "{name}: filter_cutoff_rad_per_s = {lambda} is {words} ({:.0} samples per second, \
                     motion at {frequency:.1} rad/s)",
                    1.0 / period
                ),
                "choose it near or above the frequency of the motion and below a tenth of the \
                 sampling rate",
            )
            .seen(self.file, "", lambda, "rad/s")
            .mended_by(
                "[identify]",
                &format!("filter_cutoff_rad_per_s = {better:.0}"),
            ),
        )
    }

    /// Noise against what is measured.
    fn noises(&self, joint: usize) -> Vec<Finding> {
        let (channels, period) = (self.reading.channels(), self.excerpt.period());
        let per_position = velocity_per_position(self.reading.position_cutoff_hz(), period);
        let of = |signal| {
            let i = channels.telling(signal, joint)?;
            Some((i, noise(self.excerpt, i)?.0))
        };
        let all = |pick: fn(&SignalBlock) -> &Vec<Vec<f64>>| {
            deviation(
                self.signals
                    .iter()
                    .flat_map(move |s| pick(s)[joint].iter().copied()),
            )
        };
        let mut findings = Vec::new();
        let mut tell = |channel: usize, what: &str, code: &str, noise: f64, size: f64, of: f64| {
            if size > 0.0 && noise > of * size {
                findings.push(
                    Finding::new(
                        Severity::Warning,
                        code,
                        format!(
                            "{}: the {what} from \"{}\" is {:.0} % noise ({noise:.2e} of {size:.2e} rms)",
                            self.name(joint),
                            channels.all[channel].column,
                            100.0 * noise / size
                        ),
                        "use a finer encoder, move farther and faster, or record longer; expect wide \
                         intervals",
                    )
                    .seen(self.file, &channels.all[channel].column, noise / size, ""),
                );
            }
        };
        if let Some((channel, noise)) = of(Signal::Motor) {
            let size = all(|s| &s.dphi);
            let noise = noise * per_position;
            tell(
                channel,
                "velocity",
                "noisy-velocity",
                noise,
                size,
                VELOCITY_NOISE,
            );
        }
        let link = of(Signal::Link);
        if let Some((channel, noise)) = link {
            let deflection = (self.signals.iter())
                .flat_map(|s| s.q[joint].iter().zip(&s.phi[joint]).map(|(q, phi)| q - phi));
            let size = deviation(deflection);
            // What the filter leaves of white noise.
            let cutoff = self.reading.position_cutoff_hz();
            let noise = noise * (2.0 * cutoff * period).min(1.0).sqrt();
            tell(
                channel,
                "deflection",
                "noisy-deflection",
                noise,
                size,
                DEFLECTION_NOISE,
            );
        }
        if let Some((channel, noise)) = of(Signal::Torque) {
            let size = deviation(self.excerpt.channel(channel));
            tell(channel, "torque", "noisy-torque", noise, size, TORQUE_NOISE);
        }
        findings
    }
}
