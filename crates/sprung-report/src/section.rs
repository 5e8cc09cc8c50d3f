//! Makes sections and findings in the form that all reports share.

use super::document::{Block, Finding as Shown, Fold, Section, Tone};
use super::verdict::as_sentence;
use crate::finding::{Finding, Severity};
use sprung_base::explanation::Explanation;

/// Returns a section of a report.
pub(super) fn section(id: &str, heading: &str, lead: &str, blocks: Vec<Block>) -> Section {
    Section {
        id: id.to_owned(),
        heading: heading.to_owned(),
        lead: lead.to_owned(),
        fold: Fold::Open,
        blocks,
    }
}

/// Returns a section that is folded.
pub(super) fn folded(
    fold: Fold,
    id: &str,
    heading: &str,
    lead: &str,
    blocks: Vec<Block>,
) -> Section {
    Section {
        fold,
        ..section(id, heading, lead, blocks)
    }
}

/// Returns a finding in the form of a report.
pub(super) fn shown(finding: &Finding) -> Shown {
    let known = Explanation::of(&finding.code);
    let sentence = |text: &str| as_sentence(&Explanation::plain(text));
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
        cause: known.map_or_else(String::new, |explanation| sentence(&explanation.cause)),
        condition: known
            .and_then(|explanation| explanation.condition.as_deref())
            .map_or_else(String::new, sentence),
        ignore: known.map_or_else(String::new, |explanation| {
            format!("{}.", Explanation::plain(&explanation.ignore))
        }),
    }
}
