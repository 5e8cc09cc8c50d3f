//! Findings about a broken promise and about the changes that explain it.

use super::explained::{Left, over_promise};
use super::proof::{JointProof, PROMISE_TOLERANCE, QuantityProof, worst};
use crate::description::Factor;
use crate::estimate::percent;
use crate::finding::{Finding, Severity};
use crate::log::{Channels, Signal};
use crate::model::Model;
use crate::numbers::with_error;
use crate::unknowns::{FoundChange, Kind};

/// Code of the finding about a broken promise.
pub(super) const PROMISE_BROKEN: &str = "promise-broken";

/// Codes of the findings about changes, and what they mean, as nouns.
const CHANGES: [(&str, &str); 13] = [
    ("friction-changed", "a change of friction"),
    ("payload-changed", "another load"),
    ("stiffness-changed", "another stiffness"),
    ("play-changed", "a play of a spring"),
    ("torque-scale-changed", "another scale of the logged torque"),
    ("channel-gain", "another scale of a column"),
    ("delayed-channel", "a late column"),
    ("eccentric-encoder", "an eccentric encoder"),
    ("encoder-offset", "another zero of an encoder"),
    ("position-drifts", "an encoder that drifts"),
    ("position-jumps", "an encoder that loses counts"),
    ("torque-saturates", "a torque that saturates"),
    ("torque-timing", "another timing of the torques"),
];

/// Maximum number of quantities and of changed values that a text names.
const MAX_NAMED: usize = 4;

/// Largest part of an error that stays with a change; with a larger part the change explains nothing.
const LARGEST_LEFT: f64 = 0.9;

/// Logs of a validation run and of the identification, for the remedies.
pub(crate) struct Logs<'a> {
    /// Names of the files of the run.
    pub(crate) run: &'a [String],
    /// Names of the files of the identification.
    pub(crate) identified: &'a [String],
    /// Columns of the run.
    pub(crate) channels: &'a Channels,
    /// Gains of columns that the description of the run gives.
    pub(crate) gain: &'a dyn Fn(&str) -> Option<Factor>,
}

/// Reports the errors that exceed the promise.
///
/// - `is_explained`: whether another finding names the change that explains them.
pub(super) fn promise_broken(
    label: &str,
    proofs: &[JointProof],
    is_explained: bool,
    logs: &Logs<'_>,
) -> Option<Finding> {
    let mut broken: Vec<QuantityProof<'_>> = (proofs.iter())
        .flat_map(JointProof::quantities)
        .filter(QuantityProof::is_broken)
        .collect();
    broken.sort_by(|a, b| b.ratio.unwrap_or(0.0).total_cmp(&a.ratio.unwrap_or(0.0)));
    let worst = broken.first()?.ratio?;
    let mut words: Vec<String> = (broken.iter().take(MAX_NAMED))
        .map(|quantity| {
            let ratio = quantity.ratio.unwrap_or(0.0);
            format!(
                "{} is {ratio:.1} times the promised one ({})",
                quantity.name(),
                quantity.errors()
            )
        })
        .collect();
    if broken.len() > MAX_NAMED {
        words.push(format!(
            "{} more errors are too large",
            broken.len() - MAX_NAMED
        ));
    }
    let (explained, remedy) = if is_explained {
        ("", "follow the finding about the change between the logs")
    } else {
        (
            ". sprung found no change of the robot or of a column that explains this",
            "look for an effect that this motion excites and the identification's did not (speed, \
             range, load, a delay of a column), and identify from both logs",
        )
    };
    let text = format!(
        "{label}: {}, and {PROMISE_TOLERANCE} times is allowed{explained}",
        words.join(", ")
    );
    let finding = Finding::new(Severity::Warning, PROMISE_BROKEN, text, remedy);
    Some(finding.seen(&logs.run.join(", "), "", worst, ""))
}

/// Returns what a code means if it is about a change, as a noun.
pub(super) fn change_in_words(code: &str) -> Option<&'static str> {
    let mut all = CHANGES.iter();
    all.find(|(of, _)| *of == code).map(|(_, words)| *words)
}

/// A parameter set on a log.
pub(crate) struct OfSet<'a> {
    pub(crate) label: &'a str,
    pub(crate) model: &'a Model,
    /// \[p\].
    pub(crate) theta: &'a [f64],
}

/// Reports the changes that explain a broken promise.
pub(super) fn promise_explained(
    set: &OfSet<'_>,
    (changes, left): (&[FoundChange], &[Left]),
    proofs: &[JointProof],
    logs: &Logs<'_>,
) -> Vec<Finding> {
    let falls =
        |joint: Option<usize>| errors(proofs, left, joint.map(|joint| &*set.model.joints()[joint]));
    let before = worst(proofs).map_or(0.0, |worst| worst.ratio.unwrap_or(0.0));
    changed(set, changes, (&falls, before), logs)
}

/// Reports changes of the robot or of its log.
///
/// - `falls`: the error of a joint, or the largest one, before and after the changes, in words; `None` if it does not fall.
/// - `before`: this error over the usual one.
pub(crate) fn changed(
    set: &OfSet<'_>,
    changes: &[FoundChange],
    (falls, before): (&dyn Fn(Option<usize>) -> Option<String>, f64),
    logs: &Logs<'_>,
) -> Vec<Finding> {
    let steps = |kinds: &dyn Fn(&FoundChange) -> bool| -> Vec<&FoundChange> {
        changes.iter().filter(|change| kinds(change)).collect()
    };
    let mut findings: Vec<Finding> = Vec::new();
    let friction = steps(&|change| change.found.kind == Kind::Friction);
    if let Some(first) = friction.first() {
        let is_one = friction.iter().all(|change| change.joint == first.joint);
        let of_one = first.joint.filter(|_| is_one);
        let whose = match of_one {
            Some(joint) => format!("the friction of {}", set.model.joints()[joint]),
            None => "the friction of several joints".to_owned(),
        };
        let finding = falls(of_one).map(|errors| Finding::new(
            Severity::Warning,
            CHANGES[0].0,
            format!(
                "{}: {whose} differs from that of the identification: with it fitted to this log, {errors}. {}",
                set.label,
                values(&friction, set)
            ),
            "friction changes with temperature, load and wear: record both logs at the same \
             temperature, or identify from both",
        ));
        findings.extend(finding.map(|finding| both_logs(about(finding, &friction), logs)));
    }
    let load = steps(&|change| change.found.kind == Kind::Load);
    if !load.is_empty() {
        let whose = match (set.model.tree(), load[0].parameter()) {
            (Some(_), Some(name)) => {
                format!(
                    "the load of {}",
                    name.rsplit_once('.').map_or(name, |(link, _)| link)
                )
            }
            _ => "the load of the links".to_owned(),
        };
        let finding = falls(None).map(|errors| Finding::new(
            Severity::Warning,
            CHANGES[1].0,
            format!(
                "{}: {whose} differs from that of the identification: with its inertial parameters fitted to this \
                 log, {errors}. {}",
                set.label,
                values(&load, set)
            ),
            "take the payload off, or identify with it; a payload that stays belongs into the \
             robot's description (the last link of the URDF)",
        ));
        findings.extend(finding.map(|finding| about(finding, &load)));
    }
    for change in changes {
        if let Some(errors) = falls(change.joint) {
            findings.extend(single(set, change, &errors, logs));
        }
    }
    let seen = |finding: Finding| {
        let column = finding.evidence.as_ref().and_then(|of| of.column.clone());
        let column = column.unwrap_or_default();
        finding.seen(&logs.run.join(", "), &column, before, "")
    };
    findings.into_iter().map(seen).collect()
}

/// Reports a change of a stiffness or of a channel; `None` for those that are reported together.
fn single(set: &OfSet<'_>, change: &FoundChange, errors: &str, logs: &Logs<'_>) -> Option<Finding> {
    let value = change.found.value;
    if change.found.kind == Kind::Stiffness {
        let joint = set.model.joints().get(change.joint?)?;
        let finding = Finding::new(
            Severity::Warning,
            CHANGES[2].0,
            format!(
                "{}: the stiffness of {joint} differs from that of the identification: with it fitted to this log, \
                 {errors}. {}",
                set.label,
                values(&[change], set)
            ),
            "check the spring or the gear, and the scale of both encoders of the joint; identify \
             from this log",
        );
        return Some(about(finding, &[change]));
    }
    if change.found.kind == Kind::Play {
        let joint = set.model.joints().get(change.joint?)?;
        let finding = Finding::new(
            Severity::Warning,
            CHANGES[3].0,
            format!(
                "{}: the spring of {joint} has a play that it had not at the identification: with it, {errors}. {}",
                set.label,
                values(&[change], set)
            ),
            "check the gear, the coupling and the screws of the joint",
        );
        return Some(about(finding, &[change]));
    }
    let mut finding = change.finding.clone()?;
    let is_torque = |column: &str| {
        let channels = logs.channels.all.iter();
        let mut of_column = channels.filter(|channel| channel.column == column);
        of_column.any(|channel| channel.quantity.signal() == Signal::Torque)
    };
    let column = change.column.as_deref();
    if change.found.kind == Kind::Gain && column.is_some_and(is_torque) {
        finding = Finding::new(
            Severity::Warning,
            CHANGES[4].0,
            format!(
                "{}: the torque of {} is logged at another scale than in the identification: multiplied by {:.4} ± \
                 {:.1e}, {errors}",
                set.label,
                set.model.joints()[change.joint?],
                1.0 + value,
                change.found.standard_error
            ),
            "check the torque constant, the amplifier and the unit of this log; if the log is \
             wrong, give its log this gain",
        );
    } else {
        finding.severity = Severity::Warning;
        finding.text = format!(
            "{}: unlike in the identification, {}",
            set.label, finding.text
        );
    }
    finding.setting = None;
    let Some(column) = column else {
        return Some(finding);
    };
    let line = match change.found.kind {
        Kind::Gain => {
            let given = (logs.gain)(column).map_or(Some(1.0), Factor::known);
            given.map(|given| format!("gain = {{ \"{column}\" = {:.4} }}", given * (1.0 + value)))
        }
        Kind::Delay => {
            (change.delay).map(|delay| format!("delay_s = {{ \"{column}\" = {delay:.5} }}"))
        }
        Kind::Timing
        | Kind::Offset
        | Kind::Drift
        | Kind::LostCounts
        | Kind::Eccentricity
        | Kind::Saturation
        | Kind::Ripple
        | Kind::TransmissionError
        | Kind::WarmUp
        | Kind::Sharpness
        | Kind::TimeScale
        | Kind::Law
        | Kind::Friction
        | Kind::Stiffness
        | Kind::Play
        | Kind::Load => None,
    };
    Some(match line {
        Some(line) if logs.channels.torque_mix.is_none() => finding.mended_by(
            "[[validate]]",
            &format!("log = {{ {}{line} }}", logs.own_file()),
        ),
        _ => finding,
    })
}

/// Adds the names of the parameters that changed.
fn about(finding: Finding, changes: &[&FoundChange]) -> Finding {
    let names = changes.iter().filter_map(|change| change.parameter());
    finding.about(names.map(str::to_owned))
}

/// Returns the largest error in proportion to its promise of those that fall, before and after the changes, in words; `None`
/// if none falls.
///
/// - `joint`: the joint of the changes, if they are of one.
fn errors(proofs: &[JointProof], left: &[Left], joint: Option<&str>) -> Option<String> {
    let joints = proofs.iter().zip(left);
    let quantities = joints.flat_map(|(proof, left)| proof.quantities().map(move |of| (of, left)));
    let (largest, left) = quantities
        .filter(|(of, left)| {
            left.of(of) < LARGEST_LEFT && joint.is_none_or(|joint| joint == of.joint)
        })
        .max_by(|a, b| over_promise(&a.0).total_cmp(&over_promise(&b.0)))?;
    let share = |error: f64| percent(error / largest.value);
    Some(format!(
        "the {} error of {} falls from {} to {}",
        largest.name,
        largest.joint,
        share(largest.error),
        share(largest.error * left.of(&largest))
    ))
}

/// Returns the changed values with their standard errors, in words.
fn values(changes: &[&FoundChange], set: &OfSet<'_>) -> String {
    let OfSet { model, theta, .. } = set;
    let one = |change: &&FoundChange| {
        let found = &change.found;
        let name = change.parameter().unwrap_or_default();
        let (by, error, unit) = (found.value, found.standard_error, found.unit);
        let same = |at: &usize| model.parameters()[*at].short() == name;
        if let Some(at) = (0..theta.len()).find(same) {
            let before = theta[at];
            let [after, error] = with_error(before + by, error);
            let [before_text, _] = with_error(before, change.found.standard_error);
            let share = 100.0 * by / before.abs();
            let share = if share.is_finite() {
                format!(", {share:+.0} %")
            } else {
                String::new()
            };
            format!("{name} {before_text} → {after} ± {error} {unit}{share}")
        } else {
            let [by, error] = with_error(by, error);
            let sign = if by.starts_with('-') { "" } else { "+" };
            format!("{name} {sign}{by} ± {error} {unit}")
        }
    };
    let mut words: Vec<String> = changes.iter().take(MAX_NAMED).map(one).collect();
    if changes.len() > MAX_NAMED {
        words.push(format!("{} more", changes.len() - MAX_NAMED));
    }
    words.join(", ")
}

impl Logs<'_> {
    /// Returns the key of the file of the run, if it is not one of the identification.
    fn own_file(&self) -> String {
        match self.run {
            [one] if !self.identified.contains(one) => format!("file = \"{one}\", "),
            _ => String::new(),
        }
    }
}

/// Adds the line that identifies from the logs of both.
fn both_logs(finding: Finding, logs: &Logs<'_>) -> Finding {
    if logs.identified.is_empty() || logs.run.is_empty() {
        return finding;
    }
    let files: Vec<String> = (logs.identified.iter().chain(logs.run))
        .map(|file| format!("\"{file}\""))
        .collect();
    finding.mended_by("[log]", &format!("file = [{}]", files.join(", ")))
}
