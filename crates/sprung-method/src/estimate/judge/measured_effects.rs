//! Findings about the logs whose effect on the results is measured by the estimation.

use crate::finding::{Finding, Severity};

/// Codes of findings about noise, filters and excitation. They predict uncertain parameters. After
/// the estimation the intervals and the promise contain the effect.
const MEASURED_EFFECTS: [&str; 7] = [
    "noisy-signal",
    "hardly-moves",
    "position-cutoff-low",
    "position-cutoff-high",
    "filter-cutoff",
    "sampled-slowly",
    "only-friction",
];

/// Turns warnings about the logs into notes if their effect is measured: those about noise, filters and excitation.
pub(in crate::estimate) fn after_estimation(findings: &mut [Finding]) {
    for finding in (findings.iter_mut()).filter(|finding| finding.severity == Severity::Warning) {
        if MEASURED_EFFECTS.contains(&finding.code.as_str()) {
            finding.severity = Severity::Info;
            finding.text = format!(
                "{}. The intervals and the promise contain the effect",
                finding.text
            );
        }
    }
}
