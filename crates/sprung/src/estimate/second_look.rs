//! A second look at the beginning of a log: delays that are asked for, and
//! joints whose motor row is impossible.

use super::delay::{DelayEstimate, Excerpt, MotorRowFit, estimate_delays, fit_motor_rows};
use super::identify::IdentifyError;
use super::judge::{Suspicion, suspect};
use super::result::{DelayUsed, EstimateResult};
use crate::description::Delay;
use crate::finding::{Finding, Severity};
use crate::log::{Channels, LogBlock, LogError, LogSource, Quantity};
use crate::regression::Reading;

/// Part of a residual that another reading of the log must stay below to be
/// mentioned.
const CLEARLY: f64 = 0.9;

/// Standard errors that a delay must be away from zero to be mentioned.
const CERTAIN: f64 = 3.0;

/// Delays in use.
pub(super) struct Delays {
    /// One per channel, s.
    pub(super) values: Vec<f64>,
    found: Vec<DelayEstimate>,
}

impl Delays {
    /// Returns the delays that a description gives, and estimates those that it
    /// asks for.
    ///
    /// # Errors
    ///
    /// [`IdentifyError::Delay`] if the log cannot tell, or its own errors.
    pub(super) fn new(
        base: &Reading<'_>,
        excerpt: Option<&Excerpt>,
        file: &str,
    ) -> Result<Self, IdentifyError> {
        let (channels, model) = (base.channels, base.model);
        let mut values = vec![0.0; channels.all.len()];
        let mut wanted = Vec::new();
        for (i, channel) in channels.all.iter().enumerate() {
            match channel.delay {
                Some(Delay::Known(value)) => values[i] = value,
                Some(Delay::Estimate) => wanted.push(i),
                None => {}
            }
        }
        let mut found = Vec::new();
        if !wanted.is_empty() {
            for (joint, name) in model.joints().iter().enumerate() {
                let mine = wanted.iter().filter(|&&i| channels.all[i].joint == joint);
                if mine.count() > 1 {
                    return Err(IdentifyError::Delay(format!(
                        "delay_s asks to estimate two channels of {name}; only delays between \
                         channels show in a log, so estimate one of them"
                    )));
                }
            }
            let reading = Reading {
                delays: &values,
                ..*base
            };
            let search = excerpt.and_then(|excerpt| estimate_delays(excerpt, &reading, &wanted));
            found = search.ok_or_else(|| {
                IdentifyError::Delay(format!(
                    "{file} is too short to estimate a delay from; give the delay as a number of \
                     seconds"
                ))
            })?;
        }
        for estimate in found.iter().filter(|estimate| estimate.found) {
            values[estimate.channel] = estimate.delay;
        }
        Ok(Self { values, found })
    }

    /// Returns the delay of a channel as it stands in the results.
    pub(super) fn used(&self, channel: usize) -> DelayUsed {
        let found = self
            .found
            .iter()
            .find(|estimate| estimate.channel == channel);
        DelayUsed {
            value: self.values[channel],
            standard_error: found
                .filter(|estimate| estimate.found)
                .map(|estimate| estimate.standard_error),
        }
    }

    /// Returns what there is to know about the delays that were estimated.
    pub(super) fn findings(&self, channels: &Channels) -> Vec<Finding> {
        let finding = |estimate: &DelayEstimate| {
            let column = &channels.all[estimate.channel].column;
            if !estimate.found {
                return Finding::new(
                    Severity::Serious,
                    "delay-not-found",
                    format!(
                        "no delay of \"{column}\" between -0.05 s and 0.5 s explains the motor torque \
                         better than its neighbours and than none; it was taken as 0"
                    ),
                    "give the delay as a number of seconds; see that the log begins with motion \
                     and that all signs are right",
                );
            }
            Finding::new(
                Severity::Info,
                "delay-estimated",
                format!(
                    "\"{}\" was recorded {:.4} s late (standard error {:.4} s): with that the motor \
                     row leaves {:.1} % of its torque unexplained, without it {:.1} % (root mean \
                     squares)",
                    column,
                    estimate.delay,
                    estimate.standard_error,
                    100.0 * estimate.with.relative_residual,
                    100.0 * estimate.without.relative_residual
                ),
                "give the delay as a number to keep it fixed",
            )
        };
        self.found.iter().map(finding).collect()
    }
}

/// Reads the beginning of a log.
pub(super) fn excerpt(
    channels: &Channels,
    source: &mut LogSource<'_>,
) -> Result<Excerpt, LogError> {
    let mut log = source.open(channels)?;
    let mut block = LogBlock::new(channels.all.len());
    let mut more = log.read(&mut block)?;
    let mut excerpt = Excerpt::new(log.timing().period, channels.rigid.len());
    while more {
        more = excerpt.push(&block) && log.read(&mut block)?;
    }
    Ok(excerpt)
}

/// Looks at the log again for joints whose motor row is impossible or leaves
/// much of the torque unexplained; returns one suspicion per joint.
///
/// # Errors
///
/// [`LogError`] if the log cannot be read again.
pub(super) fn suspicions<'e>(
    reading: &Reading<'_>,
    result: &EstimateResult,
    excerpt: impl FnOnce() -> Result<Option<&'e Excerpt>, LogError>,
) -> Result<Vec<Suspicion>, LogError> {
    let channels = reading.channels;
    let column = |quantities: &[Quantity], joint: usize| {
        (channels.all.iter())
            .find(|c| c.joint == joint && quantities.contains(&c.quantity))
            .map_or_else(String::new, |c| c.column.clone())
    };
    let joints = reading.model.joint_count();
    let mut all: Vec<Suspicion> = (0..joints)
        .map(|joint| Suspicion {
            link: column(&[Quantity::LinkPosition, Quantity::LinkDeflection], joint),
            motor: column(&[Quantity::MotorPosition], joint),
            torque: column(&[Quantity::MotorTorque], joint),
            delay: None,
            exchanged: None,
        })
        .collect();
    if !(0..joints).any(|joint| suspect(reading.model, result, joint)) {
        return Ok(all);
    }
    let Some(excerpt) = excerpt()? else {
        return Ok(all);
    };
    let Some(now) = fit_motor_rows(excerpt, reading) else {
        return Ok(all);
    };
    let suspects: Vec<usize> = (0..joints)
        .filter(|&joint| suspect(reading.model, result, joint))
        .collect();
    let better = |joint: usize, fit: &MotorRowFit| {
        fit.plausible && fit.relative_residual < CLEARLY * now[joint].relative_residual
    };
    // The rows of flexible joints without coupling do not disturb each other; of
    // others this is a first look, at channels that are wrong in the same way.
    let exchanged = suspects.iter().fold(channels.clone(), |channels, &joint| {
        channels.exchanged(joint).unwrap_or(channels)
    });
    if exchanged != *channels {
        let reading = Reading {
            channels: &exchanged,
            ..*reading
        };
        let fits = fit_motor_rows(excerpt, &reading).unwrap_or_default();
        for &joint in &suspects {
            let fit = fits.get(joint).copied();
            all[joint].exchanged = fit
                .filter(|_| channels.exchanged(joint).is_some())
                .filter(|fit| better(joint, fit));
        }
    }
    // A late torque looks like an early link: the best of all is named.
    let untested = |i: &usize| match channels.all[*i].delay {
        None => true,
        Some(Delay::Known(delay)) => delay == 0.0,
        Some(Delay::Estimate) => false,
    };
    for quantities in [
        &[Quantity::LinkPosition, Quantity::LinkDeflection][..],
        &[Quantity::MotorPosition],
        &[Quantity::MotorTorque],
    ] {
        let wanted: Vec<usize> = (0..channels.all.len())
            .filter(|&i| quantities.contains(&channels.all[i].quantity))
            .filter(|&i| suspects.contains(&channels.all[i].joint))
            .filter(|&i| all[channels.all[i].joint].exchanged.is_none())
            .filter(untested)
            .collect();
        if wanted.is_empty() {
            continue;
        }
        for found in estimate_delays(excerpt, reading, &wanted).unwrap_or_default() {
            let channel = &channels.all[found.channel];
            let suspicion = &mut all[channel.joint];
            let certain = found.found && found.delay.abs() > CERTAIN * found.standard_error;
            let best = (suspicion.delay.as_ref()).is_none_or(|(_, other)| {
                found.with.relative_residual < other.with.relative_residual
            });
            if certain && better(channel.joint, &found.with) && best {
                suspicion.delay = Some((channel.column.clone(), found));
            }
        }
    }
    Ok(all)
}
