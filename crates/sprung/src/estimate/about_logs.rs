//! What there is to know about logs themselves.

use std::collections::BTreeMap;

use super::result::{DelayUsed, LogInfo};
use super::second_look::Delays;
use crate::description::Log;
use crate::finding::{Finding, Severity};
use crate::log::{Channels, Sampling, check, check_timing};
use crate::model::Model;
use crate::regression::{LogFigures, PassError};

/// Returns what there is to know about the logs as they are.
pub(super) fn about_logs(
    model: &Model,
    channels: &Channels,
    logs: &[LogFigures],
    names: &[String],
) -> Result<Vec<Finding>, PassError> {
    let mut findings = Vec::new();
    for (figures, name) in logs.iter().zip(names) {
        findings.extend(check(name, channels, model.joints(), &figures.summary)?);
        findings.extend(check_timing(name, channels, &figures.timing));
        findings.extend(gaps(name, figures));
    }
    Ok(findings)
}

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

fn gaps(file: &str, figures: &LogFigures) -> Option<Finding> {
    let gaps = &figures.timing.gaps;
    (gaps.count > 0).then(|| {
        let lost = match figures.lost {
            0 => String::new(),
            lost => format!("; {lost} samples between gaps are too few for the filters"),
        };
        Finding::new(
            if figures.lost > 0 {
                Severity::Warning
            } else {
                Severity::Info
            },
            "gaps",
            format!(
                "{file} has {} gap{}, {:.3} s together, at which the filters start anew{lost}",
                gaps.count,
                if gaps.count == 1 { "" } else { "s" },
                gaps.duration
            ),
            "see that the recorder keeps up; nothing needs to be cut",
        )
    })
}

fn log_info(file: &str, figures: &LogFigures, delays: &Delays, channels: &Channels) -> LogInfo {
    let delay_s: BTreeMap<String, DelayUsed> = (channels.all.iter().enumerate())
        .filter(|(_, channel)| channel.delay.is_some())
        .map(|(i, channel)| (channel.column.clone(), delays.used(i)))
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
