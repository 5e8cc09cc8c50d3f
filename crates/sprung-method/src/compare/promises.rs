//! Promises of several validations side by side.

use schemars::JsonSchema;
use serde::Serialize;

use crate::validate::{JointProof, QuantityProof, Validation, worst};

/// One parameter set on one validation log.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ComparedPromise {
    /// The file that was read.
    pub file: String,
    /// Name of the run.
    pub run: String,
    /// Log of the run.
    pub log: String,
    /// Whether the parameters come from this log, which is then no proof.
    pub same_log: bool,
    /// Origin of the parameters.
    pub parameters: String,
    /// Whether the promise is kept; absent without a promise.
    pub promise_kept: Option<bool>,
    /// Prediction errors of each joint and the promised ones.
    pub predictions: Vec<JointProof>,
}

impl ComparedPromise {
    /// Returns the largest error in proportion to its promise; `None` without a promise.
    #[must_use]
    pub fn worst(&self) -> Option<QuantityProof<'_>> {
        worst(&self.predictions)
    }
}

/// Returns the parameter sets of a validation on all its logs, without sets with changed values.
pub(super) fn promises<'a>(
    file: &'a str,
    validation: &'a Validation,
) -> impl Iterator<Item = ComparedPromise> + 'a {
    validation.runs.iter().flat_map(move |run| {
        let sets = run.sets.iter().filter(|set| set.modified.is_none());
        sets.map(move |set| ComparedPromise {
            file: file.to_owned(),
            run: run.name.clone(),
            log: run.log.clone(),
            same_log: run.same_log,
            parameters: set.parameters.clone(),
            promise_kept: set.promise_kept,
            predictions: set.predictions.clone(),
        })
    })
}

/// Returns the number of kept promises on other logs, in words; `None` without a validation.
pub(super) fn sentence(promises: &[ComparedPromise]) -> Option<String> {
    if promises.is_empty() {
        return None;
    }
    let proofs = || {
        let others = promises.iter().filter(|promise| !promise.same_log);
        others.filter_map(|promise| Some((promise, promise.promise_kept?)))
    };
    let kept = proofs().filter(|(_, kept)| *kept).count();
    let ratio = |promise: &ComparedPromise| promise.worst().and_then(|worst| worst.ratio);
    let worst = (proofs().map(|(promise, _)| promise))
        .max_by(|a, b| (ratio(a).unwrap_or(0.0)).total_cmp(&ratio(b).unwrap_or(0.0)));
    let Some((promise, worst)) = worst.and_then(|promise| Some((promise, promise.worst()?))) else {
        return Some(
            "No validation proves a promise: the parameters promise nothing, or come from the same \
             logs."
                .to_owned(),
        );
    };
    Some(format!(
        "The promises are kept in {kept} of {} validations; the largest error is {} in {} ({}, {}), \
         {:.1} times the promised one.",
        proofs().count(),
        worst.name(),
        promise.run,
        promise.parameters,
        promise.file,
        worst.ratio.unwrap_or(0.0)
    ))
}
