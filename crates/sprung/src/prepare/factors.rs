//! Signs and gains that the description asks for, found before anything else.

use std::borrow::Cow;

use super::as_given::as_given;
use super::delays::{DelayError, Delays};
use super::excerpt::{Excerpt, excerpt};
use super::found::{FoundGain, FoundSign};
use super::gain::gain;
use super::sign::signs;
use crate::description::{Experiment, Factor};
use crate::finding::{Finding, Severity};
use crate::log::{ChannelError, Channels, LogError, LogSource};
use crate::model::Model;
use crate::regression::Reading;

/// What keeps signs and gains from being found.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FactorError {
    /// The log does not tell one.
    #[error("{0}")]
    NotTold(String),
    /// The description of the log is not complete.
    #[error(transparent)]
    Channel(#[from] ChannelError),
    /// A delay cannot be estimated.
    #[error(transparent)]
    Delay(#[from] DelayError),
    /// The log cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
}

/// Signs and gains that were found in a log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Factors {
    /// The signs.
    pub signs: Vec<FoundSign>,
    /// The gains.
    pub gains: Vec<FoundGain>,
}

impl Factors {
    /// Returns what there is to know about them.
    ///
    /// - `file`: name of the log.
    #[must_use]
    pub fn findings(&self, file: &str) -> Vec<Finding> {
        let signs = self.signs.iter().map(|sign| {
            let way = if sign.value < 0.0 {
                "counts the other way"
            } else {
                "counts the way of the model"
            };
            let line = format!("sign = {{ \"{}\" = {} }}", sign.column, sign.value);
            Finding::new(
                Severity::Info,
                "sign-estimated",
                format!(
                    "\"{}\" {way} (sign {}): {}; log-likelihood +{:.0} against the other sign",
                    sign.column, sign.value, sign.because, sign.log_likelihood
                ),
                "give the sign as a number to keep it fixed",
            )
            .seen(file, &sign.column, sign.value, "")
            .mended_by("[log]", &line)
        });
        let gains = self.gains.iter().map(|gain| {
            let line = format!("gain = {{ \"{}\" = {:.6} }}", gain.column, gain.value);
            Finding::new(
                Severity::Info,
                "gain-estimated",
                format!(
                    "\"{}\" is to be multiplied with {:.6} (standard error {:.6}): {}",
                    gain.column, gain.value, gain.standard_error, gain.because
                ),
                "give the gain as a number to keep it fixed",
            )
            .seen(file, &gain.column, gain.value, "")
            .mended_by("[log]", &line)
        });
        signs.chain(gains).collect()
    }

    /// Puts them into the description of a log.
    fn put_into(&self, experiment: &mut Experiment) {
        let signs = self.signs.iter().map(|s| (s.column.clone(), s.value));
        let gains = self.gains.iter().map(|g| (g.column.clone(), g.value));
        if let Some(log) = &mut experiment.log {
            log.settle(&signs.collect(), &gains.collect());
        }
    }
}

/// Finds the signs and gains that a description asks for from the beginning of the
/// first log; returns the experiment with them, and what was found.
///
/// Signs are decided together in each joint, by the equation of its torque: which of
/// them make inertia, stiffness and frictions positive and explain the torque. Gains
/// follow with these signs.
///
/// # Errors
///
/// [`FactorError`] if one cannot be told, with what to do, or the log cannot be read.
pub fn find_factors<'a>(
    experiment: &'a Experiment,
    model: &Model,
    sources: &mut [LogSource<'_>],
) -> Result<(Cow<'a, Experiment>, Factors), FactorError> {
    let unchanged = || Ok((Cow::Borrowed(experiment), Factors::default()));
    let Some(log) = &experiment.log else {
        return unchanged();
    };
    let open = |factors: &std::collections::BTreeMap<String, Factor>| {
        factors.values().any(|factor| *factor == Factor::Estimate)
    };
    if !open(&log.sign) && !open(&log.gain) {
        return unchanged();
    }
    let Some(first) = sources.first_mut() else {
        return unchanged();
    };
    let file = first.name.clone();
    let mut now = experiment.clone();
    let mut found = Factors::default();
    let channels = Channels::new(&now.robot, log)?;
    let beginning = excerpt(&channels, first)?;
    if channels.all.iter().any(|channel| channel.open_sign) {
        let reading = look(&now, model, &channels, &beginning, &file)?;
        found.signs = signs(&reading, &beginning, &file).map_err(FactorError::NotTold)?;
        found.put_into(&mut now);
    }
    // A sign is part of what the reader makes of a column.
    let settled = Channels::new(&now.robot, now.log.as_ref().unwrap_or(log))?;
    let beginning = excerpt(&settled, first)?;
    let open: Vec<usize> = (0..settled.all.len())
        .filter(|&i| settled.all[i].open_gain)
        .collect();
    if !open.is_empty() {
        let reading = look(&now, model, &settled, &beginning, &file)?;
        for channel in open {
            let own = gain(&now, &reading, &beginning, channel);
            found.gains.push(own.map_err(FactorError::NotTold)?);
        }
        found.put_into(&mut now);
    }
    Ok((Cow::Owned(now), found))
}

/// Returns how the beginning of a log is read before its signs or gains are known.
fn look(
    experiment: &Experiment,
    model: &Model,
    channels: &Channels,
    excerpt: &Excerpt,
    file: &str,
) -> Result<Reading, FactorError> {
    let (reading, _) = as_given(model, &experiment.identify, channels, excerpt);
    // With a wrong sign no delay shows; with all signs known it may move a gain.
    if channels.all.iter().any(|channel| channel.open_sign) {
        return Ok(reading);
    }
    let delays = Delays::new(&reading, excerpt, file)?;
    Ok(reading.with_delays(&delays.values))
}
