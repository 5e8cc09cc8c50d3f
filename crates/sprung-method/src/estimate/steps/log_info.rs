//! Figures of the logs in the form of the results.

use std::collections::BTreeMap;
use std::ops::Range;

use crate::description::{Delay, FilePart, Log};
use crate::estimate::result::{DelayUsed, GainUsed, LogInfo, Refinement, SignUsed};
use crate::log::Sampling;
use crate::numbers::in_percent;
use crate::prepare::Prepared;
use crate::regression::LogFigures;
use crate::sha256::sha256;
use crate::unknowns::UnknownResult;

/// Times that are dates, s since 1970: from 2000 to 2100. A clock that starts with the robot does not run for thirty
/// years.
const DATES_S: Range<f64> = 946_684_800.0..4_102_444_800.0;

/// Number of digits in a digest.
const DIGEST_DIGITS: usize = 16;

/// Returns a digest of a log that depends only on the samples, from the first, smallest and largest value of each
/// channel.
fn digest(figures: &LogFigures) -> String {
    let channels = 0..figures.names.len();
    let extents = channels.filter_map(|channel| figures.summary.extent(channel));
    let bytes: Vec<u8> = extents
        .flat_map(|extent| [extent.first, extent.min, extent.max])
        .flat_map(f64::to_le_bytes)
        .collect();
    let mut digits = sha256(&bytes[..]).unwrap_or_default();
    digits.truncate(DIGEST_DIGITS);
    digits
}

/// Returns the names of the logs as the experiment gives them, or the names of the opened logs if
/// the experiment lists none.
pub(in crate::estimate) fn log_names(log: Option<&Log>, opened: &[String]) -> Vec<String> {
    // Logs with an unknown payload serve only the payload.
    let has_unknown =
        |file: &&FilePart| (file.payload.as_ref()).is_some_and(|payload| payload.known().is_none());
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
    pub(in crate::estimate) fn of(file: &str, figures: &LogFigures) -> Self {
        let timing = figures.timing;
        Self {
            file: timing.window.without(file),
            window: timing.window,
            samples: figures.summary.samples(),
            period_s: timing.period,
            duration_s: timing.duration,
            date_s: Some(timing.start).filter(|start| DATES_S.contains(start)),
            digest: digest(figures),
            jitter_percent: in_percent(timing.jitter.largest),
            jitter_rms_percent: in_percent(timing.jitter.rms),
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
            torques_delay_s: None,
            sign: BTreeMap::new(),
            gain: BTreeMap::new(),
            torque_constant_side: None,
        }
    }

    /// Adds the delays, signs and gains, which hold for all logs.
    ///
    /// - `refined`: the refinement if the values come from it; it estimates open delays again. `torques_delay_s`: common
    ///   delay of all torques that it found.
    pub(in crate::estimate) fn with_choices(
        self,
        (prepared, unknowns): (&Prepared, &[UnknownResult]),
        (refined, torques_delay_s): (Option<&Refinement>, Option<DelayUsed>),
    ) -> Self {
        let factors = prepared.factors();
        let found = |kind: &str, column: &str| {
            let is_of = |unknown: &&UnknownResult| {
                unknown.kind == kind && unknown.place.split(", ").any(|place| place == column)
            };
            unknowns.iter().find(is_of)
        };
        let channels = prepared.reading().channels();
        let delay_s: BTreeMap<String, DelayUsed> = (channels.all.iter().enumerate())
            .filter(|(_, channel)| channel.delay.is_some())
            .map(|(i, channel)| {
                let by_likelihood = (refined.iter())
                    .flat_map(|refined| &refined.delays)
                    .filter(|_| channel.delay == Some(Delay::Estimate))
                    .find(|delay| delay.column == channel.column);
                let used = match by_likelihood {
                    Some(delay) => DelayUsed {
                        value: delay.delay_s,
                        standard_error: delay.standard_error_s,
                    },
                    None => DelayUsed {
                        value: prepared.reading().delays()[i],
                        standard_error: found("delay", &channel.column)
                            .map(|found| found.standard_error),
                    },
                };
                (channel.column.clone(), used)
            })
            .collect();
        let timing = unknowns.iter().find(|unknown| unknown.kind == "timing");
        Self {
            delay_s,
            torques_delay_s: torques_delay_s.or(timing.map(|timing| DelayUsed {
                value: timing.value,
                standard_error: Some(timing.standard_error),
            })),
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
            torque_constant_side: factors.side.as_ref().map(|found| found.side),
            ..self
        }
    }
}
