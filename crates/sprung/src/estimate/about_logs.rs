//! Figures of the logs in the form of the results.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::description::{FilePart, Log, Window};
use crate::log::Sampling;
use crate::prepare::Prepared;
use crate::regression::LogFigures;

/// Figures of one log: timing, faulty samples, delays, signs and gains.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LogInfo {
    /// File name as the experiment gives it.
    pub file: String,
    /// Window of the file; absent for the whole file.
    #[serde(default, skip_serializing_if = "Window::is_whole")]
    pub window: Window,
    /// Number of samples.
    pub samples: u64,
    /// Sampling period, s.
    pub period_s: f64,
    /// Time between the first and the last sample, s.
    pub duration_s: f64,
    /// Largest deviation of a time step from the period, percent.
    pub jitter_percent: f64,
    /// Root mean square of these deviations, percent.
    #[serde(default)]
    pub jitter_rms_percent: f64,
    /// Kind of the sampling times: `even`, `on-cycle` or `as-stamped`.
    #[serde(default)]
    pub sampling: String,
    /// Cycle at whose multiples the samples were taken, s; `None` if there is no cycle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cycle_s: Option<f64>,
    /// Number of samples in the file, or in its window.
    #[serde(default)]
    pub recorded: u64,
    /// Number of used samples that were interpolated.
    #[serde(default)]
    pub interpolated: u64,
    /// Number of missing samples. More than three missing samples in a row count as a gap instead.
    #[serde(default)]
    pub dropped: u64,
    /// Number of samples left out because they repeat the time of the previous sample.
    #[serde(default)]
    pub repeated: u64,
    /// Number of samples left out because a column has no value.
    #[serde(default)]
    pub without_value: u64,
    /// Number of samples that repeat all values of the previous sample although a joint moves.
    #[serde(default)]
    pub frozen: u64,
    /// Number of gaps. The filters restart after each gap.
    #[serde(default)]
    pub gaps: u64,
    /// Delays that were compensated, by column.
    #[serde(default)]
    pub delay_s: BTreeMap<String, DelayUsed>,
    /// Signs that were estimated, by column.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub sign: BTreeMap<String, SignUsed>,
    /// Gains that were estimated, by column.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub gain: BTreeMap<String, GainUsed>,
}

/// A sign that was estimated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SignUsed {
    /// 1 or -1.
    pub value: f64,
    /// Logarithm of the likelihood with this sign minus that with the opposite sign.
    pub log_likelihood: f64,
}

/// A gain that was estimated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GainUsed {
    /// Factor by which the column was multiplied.
    pub value: f64,
    /// Standard error of the value.
    pub standard_error: f64,
}

impl LogInfo {
    /// Returns its file with its window, for messages.
    #[must_use]
    pub fn name(&self) -> String {
        self.window.of(&self.file)
    }

    /// Returns the signs that were estimated, by column.
    #[must_use]
    pub fn signs(&self) -> BTreeMap<String, f64> {
        let signs = self.sign.iter();
        signs
            .map(|(name, sign)| (name.clone(), sign.value))
            .collect()
    }

    /// Returns the gains that were estimated, by column.
    #[must_use]
    pub fn gains(&self) -> BTreeMap<String, f64> {
        let gains = self.gain.iter();
        gains
            .map(|(name, gain)| (name.clone(), gain.value))
            .collect()
    }
}

/// A delay that was compensated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DelayUsed {
    /// Value, s.
    pub value: f64,
    /// Standard error, s, if it was estimated.
    pub standard_error: Option<f64>,
}

/// Returns the names of the logs as the experiment gives them, or the names of the opened logs if
/// the experiment lists none.
pub(super) fn log_names(log: Option<&Log>, opened: &[String]) -> Vec<String> {
    // Logs with an unknown payload serve only the payload.
    let has_unknown =
        |file: &&FilePart| (file.payload.as_ref()).is_some_and(|own| own.known().is_none());
    let files = log.into_iter().flat_map(|log| log.file.iter().flatten());
    let names: Vec<String> = files
        .filter(|file| !has_unknown(file))
        .map(ToString::to_string)
        .collect();
    if names.len() == opened.len() {
        names
    } else {
        opened.to_vec()
    }
}

impl LogInfo {
    /// Returns the figures of one log, without the choices that hold for all logs.
    pub(super) fn of(file: &str, figures: &LogFigures) -> Self {
        let timing = figures.timing;
        Self {
            file: timing.window.without(file),
            window: timing.window,
            samples: figures.summary.samples(),
            period_s: timing.period,
            duration_s: timing.duration,
            jitter_percent: 100.0 * timing.jitter,
            jitter_rms_percent: 100.0 * timing.jitter_rms,
            sampling: timing.sampling.map_or("even", Sampling::name).to_owned(),
            cycle_s: timing.sampling.and_then(Sampling::cycle),
            recorded: timing.recorded,
            interpolated: timing.interpolated,
            dropped: timing.dropped.count,
            repeated: timing.repeated.count,
            without_value: timing.lacking.count,
            frozen: timing.frozen.count,
            gaps: timing.gaps.count,
            delay_s: BTreeMap::new(),
            sign: BTreeMap::new(),
            gain: BTreeMap::new(),
        }
    }

    /// Adds the delays, signs and gains, which hold for all logs.
    pub(super) fn with_choices(self, prepared: &Prepared) -> Self {
        let (delays, factors) = (prepared.delays(), prepared.factors());
        let channels = prepared.reading().channels();
        let delay_s: BTreeMap<String, DelayUsed> = (channels.all.iter().enumerate())
            .filter(|(_, channel)| channel.delay.is_some())
            .map(|(i, channel)| {
                let (value, standard_error) = delays.used(i);
                let used = DelayUsed {
                    value,
                    standard_error,
                };
                (channel.column.clone(), used)
            })
            .collect();
        Self {
            delay_s,
            sign: (factors.signs.iter())
                .map(|sign| {
                    let used = SignUsed {
                        value: sign.value,
                        log_likelihood: sign.log_likelihood,
                    };
                    (sign.column.clone(), used)
                })
                .collect(),
            gain: (factors.gains.iter())
                .map(|gain| {
                    let used = GainUsed {
                        value: gain.value,
                        standard_error: gain.standard_error,
                    };
                    (gain.column.clone(), used)
                })
                .collect(),
            ..self
        }
    }
}
