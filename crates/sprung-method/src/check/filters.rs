//! Compares the bandwidth of the data with the filters of the experiment, and the noise with the
//! motion.

use crate::description::Cutoff;
use crate::finding::{Finding, Severity};
use crate::log::Signal;
use crate::prepare::{Excerpt, choose_cutoff, deviation, noise, velocity_per_position};
use crate::preprocess::SignalBlock;
use crate::regression::{Reading, signals};

/// Limits of the signal that the position filter removes, in standard deviations of the noise and
/// as a fraction of the motion. Above both limits the filter removes motion.
const REMOVED_NOISE_RATIO: f64 = 4.0;
const REMOVED_MOTION_SHARE: f64 = 0.01;

/// Largest ratio of the given cut-off to the automatic one.
const MAX_CUTOFF_RATIO: f64 = 4.0;

/// Smallest number of samples in a period of the motion.
const SAMPLES_PER_PERIOD: f64 = 20.0;

/// Largest λ over the sampling rate, and smallest λ over the motion's angular frequency.
const MAX_LAMBDA_SHARE_OF_RATE: f64 = 0.3;
const MIN_LAMBDA_SHARE_OF_MOTION: f64 = 0.1;

/// Limits of the noise of a velocity, a deflection and a torque, as fractions of their standard
/// deviations.
const MAX_VELOCITY_NOISE: f64 = 0.1;
const MAX_DEFLECTION_NOISE: f64 = 0.1;
const MAX_TORQUE_NOISE: f64 = 0.35;

struct FilterCheck<'a> {
    reading: &'a Reading,
    excerpt: &'a Excerpt,
    file: &'a str,
    signals: Vec<SignalBlock>,
}

/// Returns findings about filters and noise for the joints that move.
pub(super) fn filters(
    reading: &Reading,
    excerpt: &Excerpt,
    file: &str,
    moving: &[usize],
) -> Vec<Finding> {
    let Ok(signals) = signals(reading, excerpt.period(), excerpt.blocks()) else {
        return Vec::new();
    };
    let check = FilterCheck {
        reading,
        excerpt,
        file,
        signals,
    };
    let mut findings: Vec<Finding> = check.too_high().into_iter().collect();
    for &joint in moving {
        findings.extend(check.removes_motion(joint));
        findings.extend(check.rate(joint));
        findings.extend(check.noises(joint));
    }
    findings
}

impl FilterCheck<'_> {
    fn name(&self, joint: usize) -> &str {
        &self.reading.model().joints()[joint]
    }

    /// Finding: the given cut-off passes too much noise.
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
        (given > MAX_CUTOFF_RATIO * chosen && reason.starts_with('"')).then(|| {
            Finding::new(
                Severity::Warning,
                "position-cutoff-high",
                format!(
                    "position_cutoff_hz = {given} passes too much noise; \"auto\" would choose \
                     {chosen:.1} Hz: {reason}"
                ),
                "set position_cutoff_hz = \"auto\" in [identify]",
            )
            .seen(self.file, "", given / chosen, "")
            .mended_by("[identify]", "position_cutoff_hz = \"auto\"")
        })
    }

    /// Returns the standard deviations of the signal that the filter removes from a motor position,
    /// and of the filtered position, rad (m).
    fn removed(&self, joint: usize, channel: usize) -> Option<(f64, f64)> {
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
        // The ends contain the filter's transient, so they are left out.
        let edge = differences.len() / 20;
        let inside = |values: &[f64]| {
            let values = values.get(edge..values.len() - edge).unwrap_or_default();
            deviation(values.iter().copied())
        };
        Some((inside(&differences), inside(&kept)))
    }

    /// Finding: the position filter removes motion besides noise.
    fn removes_motion(&self, joint: usize) -> Option<Finding> {
        let channels = self.reading.channels();
        let channel = channels.telling(Signal::Motor, joint)?;
        let delayed = self.reading.delays().iter().any(|delay| *delay != 0.0);
        if channels.position_mix.is_some() || delayed {
            return None;
        }
        let (removed, motion) = self.removed(joint, channel)?;
        let (white, _) = noise(self.excerpt, channel)?;
        let cutoff = self.reading.position_cutoff_hz();
        let better = match self.reading.settings().position_cutoff_hz {
            Cutoff::Fixed(_) => "\"auto\"".to_owned(),
            Cutoff::Auto => format!("{:.0}", 2.0 * cutoff),
        };
        (removed > REMOVED_NOISE_RATIO * white && removed > REMOVED_MOTION_SHARE * motion).then(|| {
            Finding::new(
                Severity::Warning,
                "position-cutoff-low",
                format!(
                    "{}: the position filter at {cutoff:.1} Hz removes {removed:.2e} rad (m) from \"{}\", \
                     {:.0} times its noise and {:.1} % of its motion",
                    self.name(joint),
                    channels.all[channel].column,
                    removed / white,
                    100.0 * removed / motion
                ),
                "choose a higher position_cutoff_hz in [identify], or \"auto\"",
            )
            .seen(self.file, &channels.all[channel].column, removed, "rad")
            .mended_by("[identify]", &format!("position_cutoff_hz = {better}"))
        })
    }

    /// Compares sampling rate and λ with the motion.
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
        let given = self.reading.settings().filter_cutoff_rad_per_s;
        let name = self.name(joint);
        if samples < SAMPLES_PER_PERIOD {
            return Some(
                Finding::new(
                    Severity::Warning,
                    "sampled-slowly",
                    format!(
                        "{name}: {samples:.0} samples in a period of its motion ({:.1} Hz); \
                         velocities from so few samples are wrong",
                        frequency / std::f64::consts::TAU
                    ),
                    "record faster, or move more slowly",
                )
                .seen(self.file, "", samples, "samples"),
            );
        }
        // Without the key sprung chose it by the rate.
        let lambda = given?;
        let (words, better) = if lambda * period > MAX_LAMBDA_SHARE_OF_RATE {
            ("too close to the sampling rate", 0.1 / period)
        } else if lambda < MIN_LAMBDA_SHARE_OF_MOTION * frequency {
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

    /// Returns findings about noise compared with the signals.
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
        let mut compare = |channel: usize, what: &str, noise: f64, size: f64, of: f64| {
            if size > 0.0 && noise > of * size {
                findings.push(
                    Finding::new(
                        Severity::Warning,
                        "noisy-signal",
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
            compare(channel, "velocity", noise, size, MAX_VELOCITY_NOISE);
        }
        let link = of(Signal::Link);
        if let Some((channel, noise)) = link {
            let deflection = (self.signals.iter())
                .flat_map(|s| s.q[joint].iter().zip(&s.phi[joint]).map(|(q, phi)| q - phi));
            let size = deviation(deflection);
            // White noise that passes the filter.
            let cutoff = self.reading.position_cutoff_hz();
            let noise = noise * (2.0 * cutoff * period).min(1.0).sqrt();
            compare(channel, "deflection", noise, size, MAX_DEFLECTION_NOISE);
        }
        if let Some((channel, noise)) = of(Signal::Torque) {
            let size = deviation(self.excerpt.channel(channel));
            compare(channel, "torque", noise, size, MAX_TORQUE_NOISE);
        }
        findings
    }
}
