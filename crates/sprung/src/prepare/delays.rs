//! Delays that the description gives or that sprung estimates.

use super::delay::{DelayEstimate, estimate_delays};
use super::excerpt::Excerpt;
use crate::description::{Delay, Estimator};
use crate::finding::{Finding, Severity};
use crate::log::Channels;
use crate::regression::Reading;

/// A delay cannot be estimated.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct DelayError(String);

/// A delay that the likelihood of a log gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DelayByLikelihood {
    /// Index of the channel in [`Channels::all`].
    pub channel: usize,
    /// Delay of the channel behind the other channels, s.
    pub delay: f64,
    /// Standard error, s.
    pub standard_error: f64,
}

/// Delays in use, with their estimates.
#[derive(Clone, Debug)]
pub struct Delays {
    /// Delay of each channel, s.
    pub values: Vec<f64>,
    found: Vec<DelayEstimate>,
    refined: Vec<DelayByLikelihood>,
    // Whether the refinement has estimated delays or will do so.
    by_likelihood: bool,
}

impl Delays {
    /// Takes the delays that the description gives, and estimates those with `Delay::Estimate`.
    ///
    /// - `reading`: contains the given delays.
    ///
    /// # Errors
    ///
    /// [`DelayError`] if the log is too short, or if two channels of one joint are to be estimated.
    pub fn new(reading: &Reading, excerpt: &Excerpt, file: &str) -> Result<Self, DelayError> {
        let (channels, model) = (reading.channels(), reading.model());
        let mut values = reading.delays().to_vec();
        let wanted: Vec<usize> = (0..channels.all.len())
            .filter(|&i| channels.all[i].delay == Some(Delay::Estimate))
            .collect();
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
            let search = estimate_delays(excerpt, reading, &wanted);
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
        Ok(Self {
            values,
            found,
            refined: Vec::new(),
            by_likelihood: (reading.settings().estimator).contains(&Estimator::PredictionError),
        })
    }

    /// Takes the delays that the description gives and estimates no others.
    pub(super) fn given(reading: &Reading) -> Self {
        Self {
            values: reading.delays().to_vec(),
            found: Vec::new(),
            refined: Vec::new(),
            by_likelihood: false,
        }
    }

    /// Replaces estimates of the search by those of the likelihood.
    ///
    /// - `refined`: empty if the likelihood gave no estimate.
    pub(super) fn refine(&mut self, refined: Vec<DelayByLikelihood>) {
        for delay in &refined {
            self.values[delay.channel] = delay.delay;
        }
        self.refined = refined;
        self.by_likelihood = false;
    }

    /// Returns the delay of a channel, s, and its standard error if sprung estimated it, s.
    #[must_use]
    pub fn used(&self, channel: usize) -> (f64, Option<f64>) {
        let searched = (self.found.iter())
            .filter(|estimate| estimate.found)
            .find(|estimate| estimate.channel == channel)
            .map(|estimate| estimate.standard_error);
        let refined = self.refined.iter().find(|delay| delay.channel == channel);
        (
            self.values[channel],
            refined.map(|delay| delay.standard_error).or(searched),
        )
    }

    /// Returns the delay of a channel by the likelihood of the log and its standard error, s; `None`
    /// if the likelihood gave no estimate.
    #[must_use]
    pub(crate) fn likely(&self, channel: usize) -> Option<(f64, f64)> {
        let refined = self.refined.iter().find(|delay| delay.channel == channel)?;
        Some((refined.delay, refined.standard_error))
    }

    /// Returns findings about the estimated delays.
    #[must_use]
    pub fn findings(&self, channels: &Channels) -> Vec<Finding> {
        let finding = |estimate: &DelayEstimate| {
            let column = &channels.all[estimate.channel].column;
            let refined = (self.refined.iter()).find(|d| d.channel == estimate.channel);
            if let Some(refined) = refined {
                return Finding::new(
                    Severity::Info,
                    "delay-estimated",
                    format!(
                        "\"{column}\" was recorded {:.6} s late (standard error {:.6} s), by the \
                         likelihood of the log",
                        refined.delay, refined.standard_error
                    ),
                    "give the delay as a number to keep it fixed",
                );
            }
            if !estimate.found && self.by_likelihood {
                return Finding::new(
                    Severity::Info,
                    "delay-left-to-likelihood",
                    format!(
                        "no delay of \"{column}\" explains the motor torque better than zero delay, so \
                         the delay is short or zero; identify estimates it from the likelihood of the \
                         whole robot"
                    ),
                    "run sprung identify, or sprung check --thorough, which tries every channel",
                );
            }
            if !estimate.found {
                return Finding::new(
                    Severity::Serious,
                    "delay-not-found",
                    format!(
                        "no delay of \"{column}\" between -0.05 s and 0.5 s explains the motor torque \
                         better than its neighbours and than zero delay, and the likelihood of the log \
                         does not determine the delay either; it was set to 0"
                    ),
                    "give the delay as a number of seconds; check that the log begins with motion \
                     and that all signs are right",
                );
            }
            Finding::new(
                Severity::Info,
                "delay-estimated",
                format!(
                    "\"{}\" was recorded {:.4} s late (standard error {:.4} s): with this delay the \
                     motor row leaves {:.1} % of its torque unexplained, without it {:.1} % (root mean \
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
