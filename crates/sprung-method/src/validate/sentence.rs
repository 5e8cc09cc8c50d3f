//! The outcome of a validation in one sentence.

use super::changes::change_in_words;
use super::proof::{JointProof, PROMISE_TOLERANCE, QuantityProof, worst};
use super::result::{RunResult, SetResult, Validation};
use crate::finding::Severity;

/// Smallest error of a model that does not predict, as a part of the measured quantity.
const USELESS: f64 = 0.5;

impl Validation {
    /// Returns whether the promise of the first parameter set is kept on all logs, in words, and the
    /// serious findings about this set.
    #[must_use]
    pub fn sentence(&self) -> String {
        let serious = self.runs.iter().flat_map(|run| {
            let findings = run.sets.first().into_iter().flat_map(|set| &set.findings);
            let serious = findings.filter(|finding| finding.severity >= Severity::Serious);
            serious
                .map(|finding| format!(" In {} the set is unusable ({}).", run.name, finding.code))
        });
        let serious: String = serious.collect();
        format!("{}{serious}", self.proof_in_words())
    }

    fn proof_in_words(&self) -> String {
        let proofs: Vec<Proof<'_>> = (self.runs.iter())
            .filter_map(|run| {
                let set = run.sets.first()?;
                let worst = worst(&set.predictions)?;
                Some(Proof { run, set, worst })
            })
            .collect();
        let mut sets = self.runs.iter().filter_map(|run| run.sets.first());
        if proofs.is_empty() && sets.all(|set| set.predictions.is_empty()) {
            return "The promise cannot be proved, because values of parameters are missing."
                .to_owned();
        }
        if proofs.is_empty() {
            return "There is no promise to prove, because the parameters come from no \
                    identification that promises errors."
                .to_owned();
        }
        let broken = || {
            let all = proofs.iter();
            all.filter(|proof| proof.set.promise_kept == Some(false))
        };
        if let Some(Proof { run, set, worst }) = largest(broken()) {
            let change = set.change_code().and_then(change_in_words);
            let reason = change.map_or_else(String::new, |words| format!("; {words} explains it"));
            let others = || proofs.iter().filter(|proof| !proof.run.same_log);
            let kept = others().filter(|proof| proof.set.promise_kept == Some(true));
            let kept = match others().count() {
                0 | 1 => String::new(),
                all => format!(" It is kept in {} of {all} runs.", kept.count()),
            };
            return format!(
                "The promise is broken: in {} {} is {:.1} times the promised one ({}){reason}.{kept}",
                run.name,
                worst.name(),
                worst.ratio.unwrap_or(0.0),
                worst.errors(),
            );
        }
        let others = || proofs.iter().filter(|proof| !proof.run.same_log);
        let Some(Proof { worst, .. }) = largest(others()) else {
            return "The promise is not proved: the logs are those of the identification, so \
                    validate on another log."
                .to_owned();
        };
        let is_useless = |of: &QuantityProof<'_>| of.error > USELESS * of.value;
        let useless = others().find_map(|proof| {
            let all = proof
                .set
                .predictions
                .iter()
                .flat_map(JointProof::quantities);
            Some((proof.run, all.into_iter().find(is_useless)?))
        });
        if let Some((run, of)) = useless {
            return format!(
                "The model does not predict, although no error exceeds {PROMISE_TOLERANCE} times the promised one: in {} {} is \
                 {}.",
                run.name,
                of.name(),
                of.errors()
            );
        }
        let names: Vec<&str> = others().map(|proof| proof.run.name.as_str()).collect();
        format!(
            "The promise is kept: in {} no error exceeds {PROMISE_TOLERANCE} times the promised one; \
             the largest is {}, {:.1} times ({}).",
            names.join(", "),
            worst.name(),
            worst.ratio.unwrap_or(0.0),
            worst.errors()
        )
    }
}

/// First parameter set of a run, with its largest error in proportion to the promise.
#[derive(Clone, Copy)]
struct Proof<'a> {
    run: &'a RunResult,
    set: &'a SetResult,
    worst: QuantityProof<'a>,
}

/// Returns the proof with the largest ratio of error to promised error.
fn largest<'a, 'b>(proofs: impl Iterator<Item = &'b Proof<'a>>) -> Option<Proof<'a>>
where
    'a: 'b,
{
    let ratio = |proof: &Proof<'a>| proof.worst.ratio.unwrap_or(0.0);
    (proofs.copied()).max_by(|a, b| ratio(a).total_cmp(&ratio(b)))
}
