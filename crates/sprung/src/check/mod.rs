//! What is wrong with a log, before anything is identified from it.
//!
//! [`check`] reads logs once, in bounded memory, and says what it found; an
//! identification asks [`examine`] with the figures of its own pass. What one
//! column shows by itself is judged in [`crate::log`]; here stands what takes the
//! robot's equations or the settings: whether the torque explains the motion, which
//! channel is late, what the filters take away. For these the beginning of the first
//! log is looked at, an [`Excerpt`].

mod columns;
mod filters;
mod joints;
mod offset;
mod relative;
mod resolution;
mod result;
mod tell;

use crate::description::Experiment;
use crate::finding::{Finding, Severity};
use crate::log::{
    ChannelError, Channels, LogBlock, LogError, LogSource, Summary, Timing, check_timing,
};
use crate::model::Model;
use crate::progress::{Listener, Phase, Stopped};
use crate::regression::{LogFigures, Reading};

pub use columns::reversed_torque;
pub use relative::{ChannelDelay, RelativeDelays, relative_delays};
pub use resolution::beyond_resolution;
pub use result::{
    CheckReport, Checked, CheckedLog, ColumnFigures, DelayFigures, JointFigures, LikelyDelay, Place,
};

pub use crate::prepare::{
    DelayByLikelihood, DelayError, Delays, Excerpt, FactorError, Factors, choose_cutoff, excerpt,
    find_factors, fit_motor_rows, noise, position_cutoff, velocity_noise,
};

/// Part of the motor torque that may stay unexplained, root mean squares, beyond what
/// the resolution of the positions leaves of it.
pub const UNEXPLAINED: f64 = 0.2;

/// Jitter, as a part of the period, that is worth a note.
const JITTER: f64 = 0.01;

/// What keeps a log from being checked.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CheckError {
    /// The experiment names no log.
    #[error("the experiment has no [log]; say which file to check")]
    NoLog,
    /// The description of the log is not complete.
    #[error(transparent)]
    Channel(#[from] ChannelError),
    /// A delay cannot be estimated.
    #[error(transparent)]
    Delay(#[from] DelayError),
    /// A sign or a gain cannot be estimated.
    #[error(transparent)]
    Factor(FactorError),
    /// The log cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The caller stopped it.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl From<FactorError> for CheckError {
    fn from(error: FactorError) -> Self {
        match error {
            FactorError::Log(error) => Self::Log(error),
            error => Self::Factor(error),
        }
    }
}

/// Errors about a log, for which it is refused.
#[derive(Clone, Debug, PartialEq)]
pub struct Refusal(pub Vec<Finding>);

impl std::fmt::Display for Refusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (k, finding) in self.0.iter().enumerate() {
            let separator = if k == 0 { "" } else { "\n" };
            write!(f, "{separator}{} ({})", finding.text, finding.code)?;
            if let Some(setting) = &finding.setting {
                write!(f, "; in the experiment file: {setting}")?;
            }
        }
        Ok(())
    }
}

/// What [`examine`] says.
#[derive(Clone, Debug, Default)]
pub struct Examination {
    /// What is wrong, worst first.
    pub findings: Vec<Finding>,
    /// Figures of the joints; none if the log is too short for the filters.
    pub joints: Vec<JointFigures>,
}

/// Judges logs by their figures and the beginning of the first.
///
/// - `delays`: those that are undone; `names`: of the logs; `figures`: of each.
#[must_use]
pub fn examine(
    experiment: &Experiment,
    reading: &Reading<'_>,
    delays: &Delays,
    names: &[String],
    figures: &[LogFigures],
    excerpt: Option<&Excerpt>,
) -> Examination {
    let (model, channels) = (reading.model, reading.channels);
    let mut findings = Vec::new();
    for (figures, name) in figures.iter().zip(names) {
        findings.extend(crate::log::check(
            name,
            channels,
            model.joints(),
            &figures.summary,
        ));
        let timing = check_timing(name, channels, &figures.timing);
        let uneven = (timing.iter()).any(|finding| finding.code == "uneven-sampling");
        findings.extend(timing);
        findings.extend(gaps(name, figures));
        if !uneven {
            findings.extend(jitter(name, &figures.timing));
        }
    }
    findings.extend(delays.findings(channels));
    let mut joints = Vec::new();
    if let (Some(excerpt), Some(name), Some(first)) = (excerpt, names.first(), figures.first()) {
        // Samples that are weighed say less of what is wrong with some.
        let reading = Reading {
            weights: None,
            ..*reading
        };
        let moving: Vec<usize> = (0..model.joint_count())
            .filter(|&joint| moves(channels, &first.summary, joint))
            .filter(|&joint| !is_wrong(&findings, channels, joint))
            .collect();
        match self::joints::joints(experiment, &reading, excerpt, name, &moving) {
            Some(examined) => {
                findings.extend(filters::filters(&reading, excerpt, name, &moving));
                // What the equations say of signs and scales is surer than correlations.
                let again = |found: &Finding| {
                    (examined.findings.iter())
                        .any(|other| other.code == found.code && same_joint(found, other, channels))
                };
                findings.retain(|found| !again(found));
                findings.extend(examined.findings);
                joints = examined.joints;
                for (joint, figures) in joints.iter_mut().enumerate() {
                    figures.slope = first.summary.line(joint).map(|line| line.slope);
                }
            }
            None => findings.push(too_short(name, excerpt)),
        }
    }
    findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    Examination { findings, joints }
}

/// Returns whether a position of a joint changes.
fn moves(channels: &Channels, summary: &Summary, joint: usize) -> bool {
    (channels.all.iter().enumerate())
        .filter(|(_, channel)| channel.joint == joint && channel.quantity.is_position())
        .any(|(i, _)| {
            summary
                .extent(i)
                .is_some_and(|extent| !extent.is_constant())
        })
}

/// Returns whether a column of a joint is known to be wrong: what its equations
/// say follows from that.
fn is_wrong(findings: &[Finding], channels: &Channels, joint: usize) -> bool {
    let own = |column: &str| {
        (channels.all.iter()).any(|channel| channel.joint == joint && channel.column == column)
    };
    (findings.iter())
        .filter(|finding| finding.severity == Severity::Error)
        .filter_map(|finding| finding.evidence.as_ref()?.column.as_ref())
        .any(|column| own(column))
}

/// Returns whether two findings are about columns of one joint.
fn same_joint(one: &Finding, other: &Finding, channels: &Channels) -> bool {
    let joint = |finding: &Finding| {
        let column = finding.evidence.as_ref()?.column.as_ref()?;
        let channel = channels
            .all
            .iter()
            .find(|channel| channel.column == *column)?;
        Some(channel.joint)
    };
    joint(one).is_some() && joint(one) == joint(other)
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
        .seen(file, "", gaps.duration, "s")
    })
}

/// Says that a clock is a little uneven.
fn jitter(file: &str, timing: &Timing) -> Option<Finding> {
    (timing.jitter > JITTER).then(|| {
        Finding::new(
            Severity::Info,
            "jitter",
            format!(
                "{file}: steps of the time differ from the period of {:.4} ms by up to {:.1} %",
                1e3 * timing.period,
                100.0 * timing.jitter
            ),
            "nothing, if the times are rounded; otherwise stamp samples where they are taken",
        )
        .seen(file, "", 100.0 * timing.jitter, "%")
    })
}

fn too_short(file: &str, excerpt: &Excerpt) -> Finding {
    Finding::new(
        Severity::Warning,
        "too-short-to-examine",
        format!(
            "{file}: {:.3} s are too short for the filters, so that torques, signs and delays were not \
             looked at",
            excerpt.duration()
        ),
        "record a longer log; three periods of position_cutoff_hz pad each end",
    )
    .seen(file, "", excerpt.duration(), "s")
}

/// Checks logs against their description.
///
/// Each is read once, block by block; memory does not grow with it.
///
/// - `sources`: the logs, all with the same columns.
/// - `progress`: told of the samples read so far.
///
/// # Errors
///
/// [`CheckError`] if the description is not complete or a log cannot be read. A
/// log that is wrong is a report.
pub fn check(
    experiment: &Experiment,
    model: &Model,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<Checked, CheckError> {
    let (experiment, factors) = find_factors(experiment, model, sources)?;
    let experiment = &*experiment;
    let log = experiment.log.as_ref().ok_or(CheckError::NoLog)?;
    let channels = Channels::new(&experiment.robot, log)?;
    let names: Vec<String> = sources.iter().map(|source| source.name.clone()).collect();
    let mut figures = Vec::new();
    let mut beginning = None;
    for source in sources {
        let before = figures
            .iter()
            .map(|log: &LogFigures| log.summary.samples())
            .sum();
        let (of_log, excerpt) = read(&channels, source, before, progress)?;
        figures.push(of_log);
        beginning.get_or_insert(excerpt);
    }
    let excerpt = beginning.ok_or(CheckError::NoLog)?;
    let settings = &experiment.identify;
    let none = vec![0.0; channels.all.len()];
    let mut reading = Reading {
        model,
        settings,
        position_cutoff_hz: position_cutoff(settings, model, &channels, &excerpt),
        channels: &channels,
        delays: &none,
        weights: None,
    };
    let delays = Delays::new(&reading, Some(&excerpt), &names.join(", "))?;
    reading.delays = &delays.values;
    let mut found = examine(
        experiment,
        &reading,
        &delays,
        &names,
        &figures,
        Some(&excerpt),
    );
    let file = names.first().map_or("", String::as_str);
    found.findings.extend(factors.findings(file));
    Ok(tell::told(
        experiment, &channels, &names, &figures, &excerpt, found,
    ))
}

/// Reads a log through: its figures, and its beginning.
fn read(
    channels: &Channels,
    source: &mut LogSource<'_>,
    before: u64,
    progress: &mut dyn Listener,
) -> Result<(LogFigures, Excerpt), CheckError> {
    let mut log = source.open(channels)?;
    let mut block = LogBlock::new(channels.all.len());
    let mut summary = Summary::new(channels);
    let mut more = log.read(&mut block)?;
    let mut excerpt = Excerpt::new(log.timing().period, channels.rigid.len());
    while more {
        summary.take(&block);
        excerpt.push(&block);
        progress.tell(Phase::Reading, before + log.timing().recorded, None)?;
        more = log.read(&mut block)?;
    }
    let figures = LogFigures {
        timing: log.timing(),
        lost: 0,
        summary,
    };
    Ok((figures, excerpt))
}
