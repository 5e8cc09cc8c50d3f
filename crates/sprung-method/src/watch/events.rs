//! Events in words.

use sprung_core::chain::JointKind;

use super::changes::Change;
use super::contact::Contact;
use super::result::WatchEvent;
use crate::finding::{Finding, Severity};
use crate::model::Model;
use crate::regression::Reading;

/// Code of the finding about a contact.
const CONTACT: &str = "contact";

/// Code of the finding about a sensor that shows nothing.
const BLIND: &str = "sensor-shows-nothing";

/// Returns the event of a change.
pub(super) fn of_change(change: Change, log: &str, model: &Model) -> WatchEvent {
    WatchEvent {
        log: log.to_owned(),
        begins_s: change.span[0],
        ends_s: change.span[1],
        joint: change.joint.map(|joint| model.joints()[joint].clone()),
        torque_nm: None,
        threshold_nm: None,
        finding: change.finding,
    }
}

/// Returns the event of a time without samples.
///
/// - `span`: s.
pub(super) fn of_gap(span: [f64; 2], log: &str) -> WatchEvent {
    let duration = span[1] - span[0];
    let finding = Finding::new(
        Severity::Warning,
        BLIND,
        format!(
            "the log has no samples from {:.2} to {:.2} s: sprung is blind there, and says nothing about contacts and changes",
            span[0], span[1]
        ),
        "check the recorder",
    );
    WatchEvent {
        log: log.to_owned(),
        begins_s: span[0],
        ends_s: span[1],
        joint: None,
        torque_nm: None,
        threshold_nm: None,
        finding: finding.seen(log, "", duration, "s"),
    }
}

/// Returns the event of a channel that shows nothing.
pub(super) fn of_blindness(
    channel: usize,
    span: [f64; 2],
    log: &str,
    reading: &Reading,
) -> WatchEvent {
    let of = &reading.channels().all[channel];
    let joint = &reading.model().joints()[of.joint];
    let finding = Finding::new(
        Severity::Warning,
        BLIND,
        format!(
            "{joint}: \"{}\" keeps one value from {:.2} to {:.2} s, much longer than in the healthy logs: sprung is blind there, and \
             says nothing about contacts and changes",
            of.column, span[0], span[1]
        ),
        "check the sensor and its cable; a torque at its limit is saturated",
    );
    WatchEvent {
        log: log.to_owned(),
        begins_s: span[0],
        ends_s: span[1],
        joint: Some(joint.clone()),
        torque_nm: None,
        threshold_nm: None,
        finding: finding.seen(log, &of.column, span[1] - span[0], "s"),
    }
}

/// Returns the event of a contact.
pub(super) fn of_contact(contact: &Contact, log: &str, model: &Model) -> WatchEvent {
    let joint = &model.joints()[contact.joint];
    let unit = match model.kind(contact.joint) {
        JointKind::Revolute => "N·m",
        JointKind::Prismatic => "N",
    };
    let finding = Finding::new(
        Severity::Warning,
        CONTACT,
        format!(
            "{joint}: from {:.2} to {:.2} s a torque from outside of up to {:+.3} {unit} acts on the link; {:.3} {unit} is the \
             threshold in this state",
            contact.span[0], contact.span[1], contact.torque, contact.threshold
        ),
        "look for what touches the robot; if nothing does, record a healthy log of this motion and learn from it",
    );
    WatchEvent {
        log: log.to_owned(),
        begins_s: contact.span[0],
        ends_s: contact.span[1],
        joint: Some(joint.clone()),
        torque_nm: Some(contact.torque),
        threshold_nm: Some(contact.threshold),
        finding: finding.seen(log, "", contact.torque, unit),
    }
}
