//! Assembles the report of a check and its curves from figures and findings.

use std::collections::BTreeMap;

use super::examine::Examination;
use super::result::{CheckReport, Checked, CheckedLog, ColumnFigures, FindingSamples};
use crate::curves::{CurveSet, Curves};
use crate::description::Experiment;
use crate::finding::{Finding, GENERATOR, Severity};
use crate::log::{Channels, Figures, Overview, Sampling};
use crate::prepare::{Excerpt, Prepared, noise};
use crate::regression::LogFigures;
use crate::unknowns::UnknownResult;

/// Samples that the report shows on each side of a place.
const SAMPLES_EACH_SIDE: usize = 150;

/// Assembles a report and its curves.
pub(super) fn assemble(
    prepared: &Prepared,
    figures: &[LogFigures],
    found: Examination,
    unknowns: Vec<UnknownResult>,
) -> Checked {
    let (experiment, channels) = (prepared.experiment(), prepared.reading().channels());
    let (names, excerpt) = (prepared.names(), prepared.excerpt());
    let logs = (figures.iter().zip(names).enumerate())
        .map(|(k, (figures, name))| {
            let beginning = (k == 0).then_some(excerpt);
            log(experiment, channels, name, figures, beginning)
        })
        .collect();
    let places = (found.findings.iter().enumerate())
        .filter_map(|(k, finding)| place(channels, names, excerpt, (k, finding)))
        .collect();
    let mut report = CheckReport {
        format: 1,
        generator: GENERATOR.to_owned(),
        robot: experiment.robot.name.clone(),
        logs,
        joints: found.joints,
        unknowns,
        refused: (found.findings.iter()).any(|finding| finding.severity == Severity::Error),
        counts: BTreeMap::new(),
        findings: found.findings,
    };
    report.count();
    Checked {
        report,
        overview: overview(channels, figures),
        places,
    }
}

fn log(
    experiment: &Experiment,
    channels: &Channels,
    name: &str,
    figures: &LogFigures,
    excerpt: Option<&Excerpt>,
) -> CheckedLog {
    let columns = channels.all.iter().enumerate().filter_map(|(i, channel)| {
        let of = figures.summary.figures(i)?;
        let extent = of.extent();
        let noise = excerpt.and_then(|excerpt| noise(excerpt, i));
        let level = noise.map(|(level, _)| level).filter(|level| *level > 0.0);
        Some(ColumnFigures {
            column: channel.column.clone(),
            matched: (channel.origin.pick.is_pattern()).then(|| figures.names[i].clone()),
            quantity: channel.quantity.key().to_owned(),
            joint: experiment.robot.joint[channel.joint].name.clone(),
            unit: channel
                .quantity
                .unit(channels.turns[channel.joint])
                .to_owned(),
            min: extent.min,
            max: extent.max,
            mean: of.mean(),
            deviation: of.deviation(),
            noise: level,
            step: noise.and_then(|(_, step)| step),
            // The quantisation noise of an ideal converter is its step over √12.
            effective_bits: level.map(|level| (extent.range() / (level * 12_f64.sqrt())).log2()),
            longest_still_s: of.longest().samples as f64 * figures.timing.period,
        })
    });
    CheckedLog {
        file: figures.timing.window.without(name),
        window: figures.timing.window,
        samples: figures.summary.samples(),
        period_s: figures.timing.period,
        rate_hz: 1.0 / figures.timing.period,
        duration_s: figures.timing.duration,
        jitter_percent: 100.0 * figures.timing.jitter.largest,
        sampling: (figures.timing.sampling)
            .map_or("even", Sampling::name)
            .to_owned(),
        interpolated: figures.timing.interpolated,
        dropped: figures.timing.dropped.count,
        repeated: figures.timing.repeated.count,
        without_value: figures.timing.lacking.count,
        frozen: figures.timing.frozen.count,
        gaps: figures.timing.gaps.count,
        gap_duration_s: figures.timing.gaps.duration,
        columns: columns.collect(),
    }
}

/// Returns the smallest and largest values of all columns in each part of the first log.
fn overview(channels: &Channels, figures: &[LogFigures]) -> Curves {
    let all: Vec<Option<&Overview>> = (0..channels.all.len())
        .map(|i| figures.first()?.summary.figures(i).map(Figures::overview))
        .collect();
    let set = |label: &str, at: usize| CurveSet {
        label: label.to_owned(),
        time: (all.iter().flatten().next()).map_or_else(Vec::new, |one| one.time.clone()),
        values: (all.iter())
            .map(|one| {
                let bins = one.map_or(&[][..], |one| &one.between);
                bins.iter().map(|bin| Some(bin[at])).collect()
            })
            .collect(),
    };
    Curves {
        columns: (channels.all.iter())
            .map(|channel| channel.column.clone())
            .collect(),
        sets: vec![set("smallest", 0), set("largest", 1)],
    }
}

/// Returns the samples around the place of a finding; `None` if the place is not in the excerpt.
fn place(
    channels: &Channels,
    names: &[String],
    excerpt: &Excerpt,
    (index, finding): (usize, &Finding),
) -> Option<FindingSamples> {
    let evidence = finding.evidence.as_ref()?;
    let (column, at) = (evidence.column.as_ref()?, evidence.time_s?);
    if names.first() != Some(&evidence.file) {
        return None;
    }
    let i = (channels.all.iter()).position(|channel| channel.column == *column)?;
    let samples: Vec<(f64, f64)> = (excerpt.blocks().iter())
        .flat_map(|block| {
            block
                .time
                .iter()
                .copied()
                .zip(block.values[i].iter().copied())
        })
        .collect();
    let nearest = samples.partition_point(|(time, _)| *time < at);
    if nearest >= samples.len() {
        return None;
    }
    let from = nearest.saturating_sub(SAMPLES_EACH_SIDE);
    let to = (nearest + SAMPLES_EACH_SIDE).min(samples.len());
    let channel = &channels.all[i];
    Some(FindingSamples {
        finding: index,
        column: column.clone(),
        unit: channel
            .quantity
            .unit(channels.turns[channel.joint])
            .to_owned(),
        time: samples[from..to].iter().map(|(time, _)| *time).collect(),
        values: samples[from..to].iter().map(|(_, value)| *value).collect(),
    })
}
