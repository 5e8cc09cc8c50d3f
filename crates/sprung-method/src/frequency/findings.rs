//! Findings about frequency responses.

use super::result::{Feature, FrequencyResponse};
use crate::finding::{Finding, Severity};

/// Difference of log and model beyond which they disagree: in standard errors of both, and relative
/// to the frequency. Reversals of friction excite vibrations that the motion does not contain; their
/// frequencies by the log are up to 9 % too high in arms that match their models.
const DISAGREEMENT_SIGMAS: f64 = 4.0;
const DISAGREEMENT: f64 = 0.1;

/// Reports the vibrations at which log and model disagree.
pub(crate) fn resonances_disagree(response: &FrequencyResponse, file: &str) -> Option<Finding> {
    let mut found = Vec::new();
    let mut first = None;
    let mut parameters = Vec::new();
    for joint in &response.joints {
        for feature in &joint.features {
            let Some((hz, error)) = disagrees(feature) else {
                continue;
            };
            let by_model = match feature.model_standard_error_hz {
                // Nothing that the log determines moves this frequency.
                0.0 => format!("{:.3} Hz", feature.model_hz),
                error => format!("{:.3} ± {:.3} Hz", feature.model_hz, 2.0 * error),
            };
            found.push(format!(
                "{} of {}: {hz:.3} ± {:.3} Hz by the log, {by_model} by the model",
                feature.kind.word(),
                joint.joint,
                2.0 * error,
            ));
            first.get_or_insert(hz);
            parameters.push(format!("{}.stiffness", joint.joint));
        }
    }
    parameters.dedup();
    let first = first?;
    Some(
        Finding::new(
            Severity::Info,
            "resonance-disagrees",
            format!(
                "the vibrations in {file} have other frequencies than those of the identified model: \
                 {}. Dry friction raises a resonance of small motions, and the comparison contains it \
                 only on average",
                found.join("; ")
            ),
            "compare the curves under Frequency response in the report. Look for a delay, a wrong gear \
             ratio or gain, a payload, or a spring that is stiffer at large torques",
        )
        .about(parameters)
        .seen(file, "", first, "Hz"),
    )
}

/// Returns frequency and standard error by the log, if the model disagrees.
fn disagrees(feature: &Feature) -> Option<(f64, f64)> {
    let (hz, error) = (feature.log_hz?, feature.log_standard_error_hz?);
    let both = error.hypot(feature.model_standard_error_hz);
    let [low, high] = feature.model_over_poses_hz;
    let outside = (hz - high).max(low - hz);
    (outside > DISAGREEMENT_SIGMAS * both && outside > DISAGREEMENT * feature.model_hz)
        .then_some((hz, error))
}
