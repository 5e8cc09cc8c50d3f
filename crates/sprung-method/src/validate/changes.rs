//! Findings about a broken promise and about the change of the robot that explains it.

use super::diagnosis::{Change, Kind, Step};
use super::proof::{JointProof, PROMISE_TOLERANCE, QuantityProof, worst};
use crate::description::Factor;
use crate::estimate::percent;
use crate::finding::{Finding, Severity};
use crate::log::{Channels, Signal};
use crate::model::Model;

/// Code of the finding about a broken promise.
pub(super) const PROMISE_BROKEN: &str = "promise-broken";

/// Codes of the findings about a change between the logs.
pub(super) const CHANGES: [&str; 4] = [
    "friction-changed",
    "payload-changed",
    "stiffness-changed",
    "torque-scale-changed",
];

/// Maximum number of quantities and of changed values that a text names.
const MAX_NAMED: usize = 4;

/// Logs of a validation run and of the identification, for the remedies.
pub(super) struct Logs<'a> {
    /// Names of the files of the run.
    pub(super) run: &'a [String],
    /// Names of the files of the identification.
    pub(super) identified: &'a [String],
    /// Columns of the run.
    pub(super) channels: &'a Channels,
    /// Gains of columns that the description of the run gives.
    pub(super) gain: &'a dyn Fn(&str) -> Option<Factor>,
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
            ". No change of friction, of a stiffness, of the last link's load or of the scale of one \
             torque explains this",
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

/// Returns the change that a code means, as a noun.
pub(super) fn change_in_words(code: &str) -> &'static str {
    match code {
        "friction-changed" => "a change of friction",
        "payload-changed" => "another load",
        "stiffness-changed" => "another stiffness",
        _ => "another scale of the logged torque",
    }
}

/// Reports the change that explains a broken promise.
pub(super) fn changed(
    label: &str,
    model: &Model,
    change: &Change,
    proofs: &[JointProof],
    logs: &Logs<'_>,
) -> Finding {
    let joint = |joint: usize| &model.joints()[joint];
    let errors = errors(proofs, change);
    let steps = steps(change);
    let warning = Severity::Warning;
    let finding = match change.kind {
        Kind::Friction(one) => {
            let whose = one.map_or_else(
                || "the friction of several joints".to_owned(),
                |one| format!("the friction of {}", joint(one)),
            );
            let finding = Finding::new(
                warning,
                CHANGES[0],
                format!(
                    "{label}: {whose} differs from that of the identification: with this friction \
                     alone fitted to this log, {errors}. {steps}"
                ),
                "friction changes with temperature, load and wear: record both logs at the same \
                 temperature, or identify from both",
            );
            both_logs(finding, logs)
        }
        Kind::Payload(link) => {
            let whose = match (link, model.tree()) {
                (Some(link), Some(tree)) => format!("the load of {}", tree.links[link]),
                _ => "the load of the links".to_owned(),
            };
            Finding::new(
                warning,
                CHANGES[1],
                format!(
                    "{label}: {whose} differs from that of the identification: with its inertial \
                     parameters alone fitted to this log, {errors}. {steps}"
                ),
                "take the payload off, or identify with it; a payload that stays belongs into the \
                 robot's description (the last link of the URDF)",
            )
        }
        Kind::Stiffness(at) => Finding::new(
            warning,
            CHANGES[2],
            format!(
                "{label}: the stiffness of {} differs from that of the identification: with this \
                 stiffness alone fitted to this log, {errors}. {steps}",
                joint(at)
            ),
            "check the spring or the gear, and the scale of both encoders of the joint; identify \
             from this log",
        ),
        Kind::TorqueScale(at) => {
            let gain = change.steps.first().map_or(1.0, |step| 1.0 + step.change);
            let finding = Finding::new(
                warning,
                CHANGES[3],
                format!(
                    "{label}: the torque of {} is logged at another scale than in the \
                     identification: multiplied by {}, {errors}",
                    joint(at),
                    steps
                ),
                "check the torque constant, the amplifier and the unit of this log; if the log is \
                 wrong, give its log this gain",
            );
            with_gain(finding, at, gain, logs)
        }
    };
    let before = worst(proofs).map_or(0.0, |worst| worst.ratio.unwrap_or(0.0));
    finding.seen(&logs.run.join(", "), "", before, "").about(
        change
            .steps
            .iter()
            .map(|step| step.name.clone())
            .filter(|name| !name.is_empty()),
    )
}

/// Returns the largest error in proportion to its promise, before and after the change, in words.
fn errors(proofs: &[JointProof], change: &Change) -> String {
    let quantities = proofs.iter().flat_map(JointProof::quantities);
    let size =
        |quantity: &QuantityProof<'_>| quantity.ratio.unwrap_or(quantity.error / quantity.value);
    let Some(largest) = quantities.max_by(|a, b| size(a).total_cmp(&size(b))) else {
        return String::new();
    };
    let after = change
        .after
        .iter()
        .find(|after| after.joint == largest.joint);
    let after = after.and_then(|after| match largest.name {
        "torque" => Some(after.torque_error_nm),
        _ => after.deflection_error_rad,
    });
    let share = |error: f64| percent(error / largest.value);
    format!(
        "{} falls from {} to {}",
        largest.name(),
        share(largest.error),
        after.map_or_else(String::new, share)
    )
}

/// Returns the changed values with their standard errors, in words.
fn steps(change: &Change) -> String {
    let one = |step: &Step| {
        let Step {
            name,
            unit,
            before,
            change,
            error,
        } = step;
        match before {
            Some(before) if name.is_empty() => format!("{:.4} ± {error:.1e}", before + change),
            Some(before) => {
                let share = 100.0 * change / before.abs();
                let share = if share.is_finite() {
                    format!(", {share:+.0} %")
                } else {
                    String::new()
                };
                format!(
                    "{name} {before:.4} → {:.4} ± {error:.1e} {unit}{share}",
                    before + change
                )
            }
            None => format!("{name} {change:+.4} ± {error:.1e} {unit}"),
        }
    };
    let mut words: Vec<String> = change.steps.iter().take(MAX_NAMED).map(one).collect();
    if change.steps.len() > MAX_NAMED {
        words.push(format!("{} more", change.steps.len() - MAX_NAMED));
    }
    words.join(", ")
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

/// Adds the line that gives the log of the run a separate gain.
fn with_gain(finding: Finding, joint: usize, gain: f64, logs: &Logs<'_>) -> Finding {
    let channels = logs.channels;
    let channel = channels.telling(Signal::Torque, joint);
    let (Some(channel), None) = (channel, &channels.torque_mix) else {
        return finding;
    };
    let column = &channels.all[channel].column;
    let given = (logs.gain)(column).map_or(Some(1.0), Factor::known);
    let Some(given) = given else { return finding };
    let file = match logs.run {
        [one] if !logs.identified.contains(one) => format!("file = \"{one}\", "),
        _ => String::new(),
    };
    finding.mended_by(
        "[[validate]]",
        &format!(
            "log = {{ {file}gain = {{ \"{column}\" = {:.4} }} }}",
            given * gain
        ),
    )
}
