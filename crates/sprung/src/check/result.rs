//! What a check leaves, as it stands in `check.json`.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::curves::Curves;
use crate::finding::{Finding, Severity};

/// Code of the finding that a channel is late.
pub(super) const DELAYED: &str = "delayed-channel";

/// The log against its description.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CheckReport {
    /// Version of this format.
    pub format: u32,
    /// The program that wrote it.
    pub generator: String,
    /// Name of the robot.
    pub robot: String,
    /// The logs, in their order.
    pub logs: Vec<CheckedLog>,
    /// Joints, from the beginning of the first log.
    pub joints: Vec<JointFigures>,
    /// Whether there is an error: `identify` refuses such a log.
    pub refused: bool,
    /// How many findings of each severity.
    pub counts: BTreeMap<String, usize>,
    /// What is wrong, worst first.
    pub findings: Vec<Finding>,
}

impl CheckReport {
    /// Puts what a likelihood says of delays in the place of what least squares
    /// said.
    fn with_delays(&mut self, found: &[LikelyDelay]) {
        let joint_of = |column: &str| {
            let log = self.logs.first()?;
            let known = log.columns.iter().find(|one| one.column == column)?;
            Some(known.joint.clone())
        };
        let file = self
            .logs
            .first()
            .map_or("", |log| log.file.as_str())
            .to_owned();
        let sharper: Vec<(Option<String>, Finding)> = (found.iter())
            .map(|delay| (joint_of(&delay.column), delay.finding(&file)))
            .collect();
        let joints: Vec<Option<String>> = (self.findings.iter())
            .map(|finding| joint_of(finding.evidence.as_ref()?.column.as_ref()?))
            .collect();
        let mut joints = joints.into_iter();
        self.findings.retain(|finding| {
            let joint = joints.next().flatten();
            finding.code != DELAYED
                || joint.is_none()
                || !sharper.iter().any(|(other, _)| *other == joint)
        });
        self.findings
            .extend(sharper.into_iter().map(|(_, finding)| finding));
        self.findings
            .sort_by_key(|finding| std::cmp::Reverse(finding.severity));
        self.count();
    }

    /// Counts the findings of each severity.
    pub(super) fn count(&mut self) {
        self.counts.clear();
        for finding in &self.findings {
            let word = finding.severity.word().to_owned();
            *self.counts.entry(word).or_insert(0) += 1;
        }
    }

    /// Returns the worst severity of its findings.
    #[must_use]
    pub fn worst(&self) -> Option<Severity> {
        self.findings.iter().map(|finding| finding.severity).max()
    }
}

/// Figures of one log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CheckedLog {
    /// File as opened.
    pub file: String,
    /// Number of samples.
    pub samples: u64,
    /// Sampling period T.
    pub period_s: f64,
    /// Sampling rate.
    pub rate_hz: f64,
    /// Time between first and last sample.
    pub duration_s: f64,
    /// Largest deviation of a step from the period.
    pub jitter_percent: f64,
    /// When samples were taken: `even`, `on-cycle` or `as-stamped`.
    pub sampling: String,
    /// Samples that were interpolated onto even times.
    pub interpolated: u64,
    /// Samples that are missing between gaps.
    pub dropped: u64,
    /// Samples that are there twice.
    pub repeated: u64,
    /// Samples that repeat all values of the one before though a joint moves.
    pub frozen: u64,
    /// Number of gaps.
    pub gaps: u64,
    /// How long they are together.
    pub gap_duration_s: f64,
    /// Columns, in the order of the joints: links, motors, torques.
    pub columns: Vec<ColumnFigures>,
}

/// Figures of one column.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ColumnFigures {
    /// Name of the column.
    pub column: String,
    /// Its quantity, as the key of `[log]` names it.
    pub quantity: String,
    /// Name of the joint.
    pub joint: String,
    /// Unit of the values below.
    pub unit: String,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// Mean.
    pub mean: f64,
    /// Standard deviation about the mean.
    pub deviation: f64,
    /// Standard deviation of its noise, from the beginning of the log.
    pub noise: Option<f64>,
    /// Step between its values, if it is quantised.
    pub step: Option<f64>,
    /// Logarithm to base 2 of range over noise, as an ideal converter of so many
    /// bits has it.
    pub effective_bits: Option<f64>,
    /// Longest time with one value.
    pub longest_still_s: f64,
}

/// Figures of one joint.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointFigures {
    /// Name.
    pub joint: String,
    /// Slope of motor over link position, if both are logged.
    pub slope: Option<f64>,
    /// Part of the squared filtered torque that the motion explains.
    pub explained_percent: f64,
    /// Stiffness that the motor row alone gives, N·m/rad (N/m).
    pub stiffness: Option<f64>,
    /// The delay of one channel that explains the log best, if it was tested.
    pub delay: Option<DelayFigures>,
    /// Motor minus link position where the spring is at rest.
    pub encoder_offset_rad: Option<f64>,
    /// Its standard error.
    pub encoder_offset_standard_error_rad: Option<f64>,
}

/// A channel that came late, as a likelihood says.
#[derive(Clone, Debug, PartialEq)]
pub struct LikelyDelay {
    /// The column.
    pub column: String,
    /// How much later than the others it was recorded, s.
    pub delay: f64,
    /// Standard error, s.
    pub standard_error: f64,
}

impl LikelyDelay {
    fn finding(&self, file: &str) -> Finding {
        let when = if self.delay < 0.0 { "early" } else { "late" };
        let setting = format!("delay_s = {{ \"{}\" = {:.6} }}", self.column, self.delay);
        Finding::new(
            Severity::Warning,
            DELAYED,
            format!(
                "the likelihood says that \"{}\" was recorded {:.6} s {when} (standard error {:.6} s), and \
                 with that no other channel of its joint is",
                self.column,
                self.delay.abs(),
                self.standard_error
            ),
            &format!("set {setting} in [log]"),
        )
        .seen(file, &self.column, self.delay, "s")
        .mended_by("[log]", &setting)
    }
}

/// A delay, whether or not it is one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DelayFigures {
    /// The column.
    pub column: String,
    /// How much later than the others of its joint it was recorded.
    pub delay_s: f64,
    /// Standard error.
    pub standard_error_s: f64,
}

/// A check and the curves that show what it found.
#[derive(Clone, Debug)]
pub struct Checked {
    /// The figures and findings.
    pub report: CheckReport,
    /// Each column over the first log: a set `smallest` and a set `largest`.
    pub overview: Curves,
    /// Columns around the places of findings: one set per finding that has one,
    /// labelled by its place in the list of findings, from 0.
    pub places: Vec<Place>,
}

impl Checked {
    /// Puts what a likelihood says of delays in the place of what least squares
    /// said.
    pub fn with_delays(&mut self, found: &[LikelyDelay]) {
        let before: Vec<Finding> = self.report.findings.clone();
        self.report.with_delays(found);
        for place in &mut self.places {
            let finding = before.get(place.finding);
            let now = (self.report.findings.iter()).position(|other| Some(other) == finding);
            place.finding = now.unwrap_or(usize::MAX);
        }
    }
}

/// Samples around the place of a finding.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Index of the finding in [`CheckReport::findings`].
    pub finding: usize,
    /// Name of the column, and its unit.
    pub column: String,
    /// Unit of the values.
    pub unit: String,
    /// Time, s.
    pub time: Vec<f64>,
    /// Values.
    pub values: Vec<f64>,
}
