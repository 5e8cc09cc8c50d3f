//! Makes sections and findings in the form that all reports share.

use super::document::{Block, Finding as Shown, Section, Tone};
use crate::finding::{Finding, Severity};

/// Returns a section of a report.
pub(super) fn section(id: &str, heading: &str, lead: &str, blocks: Vec<Block>) -> Section {
    Section {
        id: id.to_owned(),
        heading: heading.to_owned(),
        lead: lead.to_owned(),
        blocks,
    }
}

/// Returns a finding in the form of a report.
pub(super) fn shown(finding: &Finding) -> Shown {
    Shown {
        severity: match finding.severity {
            Severity::Info => Tone::Neutral,
            Severity::Warning => Tone::Doubtful,
            Severity::Serious | Severity::Error => Tone::Bad,
        },
        code: finding.code.clone(),
        title: finding.code.replace('-', " "),
        text: finding.text.clone(),
        remedy: finding.remedy.clone(),
    }
}
