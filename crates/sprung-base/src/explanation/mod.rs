//! The meaning of every finding: its cause, its condition, its remedy, and when it may be ignored.

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use crate::named::nearest;

/// Sections in the order of the work, and their findings as TOML.
const SECTIONS: [(&str, &str); 12] = [
    ("Log: time", include_str!("time.toml")),
    ("Log: columns", include_str!("columns.toml")),
    ("Log: samples", include_str!("samples.toml")),
    ("Log: torques and filters", include_str!("torques.toml")),
    (
        "Estimates that the file asks for",
        include_str!("requests.toml"),
    ),
    ("Result", include_str!("result.toml")),
    ("Refinement", include_str!("refinement.toml")),
    ("LSFF", include_str!("lsff.toml")),
    ("Servo", include_str!("servo.toml")),
    ("Validation", include_str!("validate.toml")),
    ("Running robot", include_str!("watch.toml")),
    ("Comparison", include_str!("compare.toml")),
];

/// The meaning of one or several findings with one cause and one remedy.
///
/// Texts are Markdown; links are relative to the root of the repository.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Explanation {
    /// Codes of the findings.
    pub codes: Vec<String>,
    /// Codes of earlier versions.
    #[serde(default)]
    pub aliases: Vec<String>,
    /// Part of the work that finds them.
    #[serde(skip_deserializing)]
    pub section: &'static str,
    /// Severities that they may have, as words, the usual one first.
    pub severities: Vec<String>,
    /// Likely cause.
    pub cause: String,
    /// The observation that leads to the finding; absent if the cause says it.
    pub condition: Option<String>,
    /// Remedy.
    pub remedy: String,
    /// When the finding may be ignored; begins with "if", "always", "never" or a severity.
    pub ignore: String,
    /// Text of such a finding, as a program printed it.
    pub example: Option<String>,
}

#[derive(Deserialize)]
struct Section {
    finding: Vec<Explanation>,
}

static ALL: LazyLock<Vec<Explanation>> = LazyLock::new(|| {
    let read = |(section, text): &(&'static str, &str)| {
        // A test reads every file.
        let read: Option<Section> = toml::from_str(text).ok();
        let findings = read.map(|read| read.finding).unwrap_or_default();
        findings.into_iter().map(|explanation| Explanation {
            section,
            ..explanation
        })
    };
    SECTIONS.iter().flat_map(read).collect()
});

impl Explanation {
    /// Returns the meaning of every finding, in the order of the work.
    #[must_use]
    pub fn all() -> &'static [Self] {
        &ALL
    }

    /// Returns the meaning of a finding by its code, or by a code of an earlier version.
    #[must_use]
    pub fn of(code: &str) -> Option<&'static Self> {
        ALL.iter().find(|explanation| explanation.has(code))
    }

    /// Returns whether this is the meaning of a code, or of a code of an earlier version.
    #[must_use]
    pub fn has(&self, code: &str) -> bool {
        self.codes
            .iter()
            .chain(&self.aliases)
            .any(|known| known == code)
    }

    /// Returns the code of `all` that is nearest to an unknown one, if one is near.
    #[must_use]
    pub fn nearest_code<'a>(
        code: &str,
        all: impl IntoIterator<Item = &'a Self>,
    ) -> Option<&'a str> {
        let codes = all.into_iter().flat_map(|explanation| &explanation.codes);
        nearest(code, codes.map(String::as_str))
    }

    /// Returns the explanation with plain texts instead of Markdown.
    #[must_use]
    pub fn in_plain_text(&self) -> Self {
        Self {
            cause: Self::plain(&self.cause),
            condition: self.condition.as_deref().map(Self::plain),
            remedy: Self::plain(&self.remedy),
            ignore: Self::plain(&self.ignore),
            ..self.clone()
        }
    }

    /// Returns a Markdown text without marks; a link becomes its text and its target.
    #[must_use]
    pub fn plain(text: &str) -> String {
        let mut shown = String::new();
        let mut rest = text;
        while let Some((before, link)) = rest.split_once('[') {
            let Some((name, (target, after))) = link
                .split_once("](")
                .and_then(|(name, behind)| Some((name, behind.split_once(')')?)))
                .filter(|(name, _)| !name.contains(['[', ']']))
            else {
                shown.push_str(before);
                shown.push('[');
                rest = link;
                continue;
            };
            shown.push_str(before);
            shown.push_str(name);
            shown.push_str(": ");
            shown.push_str(target);
            rest = after;
        }
        shown.push_str(rest);
        shown.replace('`', "")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_section_is_read_and_no_code_comes_twice() {
        for (section, text) in SECTIONS {
            let read: Result<Section, _> = toml::from_str(text);
            assert!(read.is_ok(), "{section}: {:?}", read.err());
            assert!(ALL.iter().any(|known| known.section == section));
        }
        let codes: Vec<&String> = ALL
            .iter()
            .flat_map(|known| known.codes.iter().chain(&known.aliases))
            .collect();
        let unique: BTreeSet<_> = codes.iter().collect();
        assert_eq!(unique.len(), codes.len());
        assert!(codes.len() > 150, "{}", codes.len());
    }

    #[test]
    fn every_explanation_has_texts_and_an_example() {
        let known = ["error", "serious", "warning", "note"];
        for explanation in Explanation::all() {
            let Explanation {
                codes,
                severities,
                cause,
                condition,
                remedy,
                ignore,
                example,
                ..
            } = explanation;
            assert!(!codes.is_empty() && !severities.is_empty(), "{codes:?}");
            for severity in severities {
                assert!(known.contains(&severity.as_str()), "{codes:?}");
            }
            let starts = ["if ", "always", "never", "a note", "a warning"];
            assert!(
                starts.iter().any(|start| ignore.starts_with(start)),
                "{ignore}"
            );
            for text in [cause, remedy, ignore].into_iter().chain(condition) {
                assert!(text.len() > 5 && !text.ends_with('.'), "{text}");
            }
            // Reports show these as sentences, and make their first letter a capital.
            for text in [cause].into_iter().chain(condition) {
                assert!(
                    text.starts_with(|c: char| c.is_ascii_alphabetic()),
                    "{text}"
                );
            }
            let example = example.as_ref().unwrap_or_else(|| panic!("{codes:?}"));
            assert!(example.len() > 20 && !example.contains("/tmp"), "{example}");
        }
        assert_eq!(Explanation::of("gaps").unwrap().codes, ["gaps"]);
        assert_eq!(
            Explanation::of("noisy-torque").unwrap().codes,
            ["noisy-signal"]
        );
        assert!(Explanation::of("no-such-finding").is_none());
        assert_eq!(
            Explanation::nearest_code("weakly-exited", Explanation::all()),
            Some("weakly-excited")
        );
        assert_eq!(
            Explanation::nearest_code("zzzzzz", Explanation::all()),
            None
        );
    }

    #[test]
    fn markdown_becomes_plain() {
        let text = "see `a` ([the page](docs/a.md#b)) in [log] and `[identify]`";
        assert_eq!(
            Explanation::plain(text),
            "see a (the page: docs/a.md#b) in [log] and [identify]"
        );
    }
}
