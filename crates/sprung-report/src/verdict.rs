//! The verdict at the head of a report: its reason, and the remedy.

use super::document::{Badge, Tone};
use crate::estimate::{EstimateResult, Identification, Verdict};
use crate::finding::{Finding, Severity};
use crate::validate::{RunResult, Validation};

/// The head of a report.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Head {
    pub(super) badge: Option<Badge>,
    pub(super) summary: String,
    pub(super) reason: String,
    /// Names of parameters that are not to be used alone.
    pub(super) avoid: Vec<String>,
    pub(super) what_to_do: String,
}

impl Head {
    /// Returns the head of an identification, of a validation, or of both.
    pub(super) fn of(
        identification: Option<&Identification>,
        validation: Option<&Validation>,
    ) -> Self {
        let result = identification.and_then(|identification| {
            let result = identification.results.first()?;
            Some((identification, result))
        });
        let mut head = match result {
            Some((identification, result)) => Self::of_result(identification, result),
            None => Self::default(),
        };
        if let Some(validation) = validation {
            head.add_validation(validation);
        }
        head
    }

    fn of_result(identification: &Identification, result: &EstimateResult) -> Self {
        let mut all = identification.findings.iter().chain(&result.warnings);
        let first = result.decision.findings.first();
        let deciding = first.and_then(|code| all.find(|finding| finding.code == *code));
        let advice = match result.verdict {
            Verdict::Good => "Use the model and its parameters for motions of this kind.",
            Verdict::Doubtful => "Use the model as a whole.",
            Verdict::Unusable => "Do not use the values.",
        };
        let mut findings = identification.findings.iter();
        let refining = if findings.any(|finding| finding.code == "refinement-pending") {
            ", being refined"
        } else {
            ""
        };
        let next = match (deciding, result.verdict) {
            (Some(finding), _) => as_sentence(&finding.remedy),
            (None, Verdict::Good) => {
                "To prove the promise, record another log and run sprung validate.".to_owned()
            }
            (None, _) => String::new(),
        };
        Self {
            badge: Some(Badge::new(
                tone(result.verdict),
                format!("{}: {}{refining}", result.estimator, result.verdict.word()),
            )),
            // Results of earlier versions have one sentence.
            summary: if result.decision.promise.is_empty() {
                result.decision.sentence.clone()
            } else {
                result.decision.promise.clone()
            },
            reason: as_sentence(&result.decision.because),
            avoid: match result.verdict {
                Verdict::Good | Verdict::Unusable => Vec::new(),
                Verdict::Doubtful => result.decision.parameters.clone(),
            },
            what_to_do: join(advice, &next),
        }
    }

    /// Adds the sentence of a validation, and the consequence of a broken promise.
    fn add_validation(&mut self, validation: &Validation) {
        self.summary = join(&self.summary, &validation.sentence());
        let first = |run: &RunResult| run.sets.first().and_then(|set| set.promise_kept);
        let is_good = self
            .badge
            .as_ref()
            .is_some_and(|badge| badge.tone == Tone::Good);
        let Some(broken) = validation.runs.iter().find(|run| first(run) == Some(false)) else {
            let is_proved = |run: &RunResult| !run.same_log && first(run) == Some(true);
            if is_good && validation.runs.iter().any(is_proved) {
                "Use the model and its parameters for motions of this kind."
                    .clone_into(&mut self.what_to_do);
            }
            return;
        };
        if let Some(badge) = &mut self.badge {
            badge.text.push_str(", promise broken");
            if badge.tone == Tone::Good {
                badge.tone = Tone::Doubtful;
            }
        }
        if let Some(finding) = explanation(broken)
            && (is_good || self.badge.is_none())
        {
            self.reason = first_sentence(&finding.text);
            self.what_to_do = as_sentence(&finding.remedy);
        }
    }
}

/// Returns the finding that explains a broken promise of the first parameter set: a change of the
/// robot, else the most severe finding.
fn explanation(run: &RunResult) -> Option<&Finding> {
    let set = run.sets.first()?;
    let change = set.change_code();
    let named = (set.findings.iter()).find(|finding| change == Some(finding.code.as_str()));
    let all = set.findings.iter().chain(&run.findings);
    let severe = all.filter(|finding| finding.severity >= Severity::Warning);
    named.or_else(|| severe.max_by_key(|finding| finding.severity))
}

/// Returns the tone of a verdict.
pub(super) fn tone(verdict: Verdict) -> Tone {
    match verdict {
        Verdict::Good => Tone::Good,
        Verdict::Doubtful => Tone::Doubtful,
        Verdict::Unusable => Tone::Bad,
    }
}

/// Returns the text up to its first full stop before a blank, as a sentence.
pub(super) fn first_sentence(text: &str) -> String {
    as_sentence(text.split_once(". ").map_or(text, |(first, _)| first))
}

/// Returns a lower-case fragment as a sentence. A name, such as `sprung` or a key, keeps its case.
pub(super) fn as_sentence(fragment: &str) -> String {
    let fragment = fragment.trim_end_matches('.');
    let word = fragment.split(' ').next().unwrap_or_default();
    let is_name =
        word == "sprung" || word.contains(|c: char| c.is_ascii_digit() || "_.=\":".contains(c));
    let mut letters = fragment.chars();
    match letters.next() {
        None => String::new(),
        Some(_) if is_name => format!("{fragment}."),
        Some(first) => format!("{}{}.", first.to_uppercase(), letters.as_str()),
    }
}

fn join(first: &str, second: &str) -> String {
    format!("{first} {second}").trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fragments_become_sentences() {
        let cases = [
            ("record a longer log", "Record a longer log."),
            (
                "joint1.stiffness is negative",
                "joint1.stiffness is negative.",
            ),
            ("elbow: the sign is wrong", "elbow: the sign is wrong."),
            ("sprung check tells more", "sprung check tells more."),
            ("", ""),
        ];
        for (fragment, sentence) in cases {
            assert_eq!(as_sentence(fragment), sentence);
        }
        assert_eq!(
            first_sentence("it is 2.5 times too large. Look at it"),
            "It is 2.5 times too large."
        );
    }
}
