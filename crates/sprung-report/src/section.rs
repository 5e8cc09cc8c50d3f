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

/// Returns the section about what made a report: its command, and its experiment file if there is one.
pub(super) fn origin(fold: Fold, command: &str, experiment: Option<&str>) -> Section {
    let lead = match experiment {
        Some(_) => "The command that made this report, and the experiment file.",
        None => "The command that made this report.",
    };
    let texts = std::iter::once(command).chain(experiment);
    let blocks = texts.map(|text| Block::Code(text.to_owned()));
    folded(fold, "settings", "Settings", lead, blocks.collect())
}

/// Returns the section about what made a design: what it assumes, its settings, its command and its experiment file.
pub(super) fn origin_of_design(
    what: &str,
    assumed: &[String],
    settings: Block,
    command: &str,
    experiment: &str,
) -> Section {
    let assumed = assumed
        .iter()
        .map(|text| Block::Paragraph(as_sentence(text)));
    let texts = [command, experiment].map(|text| Block::Code(text.to_owned()));
    folded(
        Fold::Screen,
        "settings",
        "Assumptions and settings",
        &format!(
            "The assumptions of the design, its {what}, the command that made this report, and the experiment file."
        ),
        assumed.chain([settings]).chain(texts).collect(),
    )
}

/// Returns the findings in the form of a report; `None` without any.
pub(super) fn findings<'a>(found: impl IntoIterator<Item = &'a Finding>) -> Option<Block> {
    let all: Vec<Shown> = found.into_iter().map(shown).collect();
    (!all.is_empty()).then_some(Block::Findings(all))
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
