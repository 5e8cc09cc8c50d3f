//! Delays that the description gives or asks for.

use super::delay::{DelayEstimate, estimate_delays};
use super::excerpt::Excerpt;
use crate::description::Delay;
use crate::finding::{Finding, Severity};
use crate::log::Channels;
use crate::regression::Reading;

/// A delay cannot be estimated.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct DelayError(String);

/// Delays in use.
pub struct Delays {
    /// One per channel, s.
    pub values: Vec<f64>,
    found: Vec<DelayEstimate>,
}

impl Delays {
    /// Returns the delays that a description gives, and estimates those that it
    /// asks for.
    ///
    /// # Errors
    ///
    /// [`DelayError`] if the log cannot tell.
    pub fn new(
        base: &Reading<'_>,
        excerpt: Option<&Excerpt>,
        file: &str,
    ) -> Result<Self, DelayError> {
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
                    return Err(DelayError(format!(
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
                DelayError(format!(
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

    /// Returns the delay of a channel, and its standard error if it was found
    /// in the log, s.
    #[must_use]
    pub fn used(&self, channel: usize) -> (f64, Option<f64>) {
        let found = (self.found.iter())
            .filter(|estimate| estimate.found)
            .find(|estimate| estimate.channel == channel);
        (
            self.values[channel],
            found.map(|estimate| estimate.standard_error),
        )
    }

    /// Returns what there is to know about the delays that were estimated.
    #[must_use]
    pub fn findings(&self, channels: &Channels) -> Vec<Finding> {
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
