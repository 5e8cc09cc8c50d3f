//! Figures of logs as they stand in the results.

use std::collections::BTreeMap;

use super::result::{DelayUsed, LogInfo};
use crate::check::Delays;
use crate::description::Log;
use crate::log::{Channels, Sampling};
use crate::regression::LogFigures;

/// Returns figures of the logs, in their order.
pub(super) fn log_infos(
    log: &Log,
    names: &[String],
    figures: &[LogFigures],
    delays: &Delays,
    channels: &Channels,
) -> Vec<LogInfo> {
    (figures.iter().zip(&log_names(log, names)))
        .map(|(figures, name)| log_info(name, figures, delays, channels))
        .collect()
}

/// Returns the names of the logs as the experiment has them.
fn log_names(log: &Log, opened: &[String]) -> Vec<String> {
    match &log.file {
        Some(files) if files.len() == opened.len() => files
            .iter()
            .map(|file| file.display().to_string())
            .collect(),
        _ => opened.to_vec(),
    }
}

fn log_info(file: &str, figures: &LogFigures, delays: &Delays, channels: &Channels) -> LogInfo {
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
    let timing = figures.timing;
    LogInfo {
        file: file.to_owned(),
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
        frozen: timing.frozen.count,
        gaps: timing.gaps.count,
        delay_s,
    }
}
