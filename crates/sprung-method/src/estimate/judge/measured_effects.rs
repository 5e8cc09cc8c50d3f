//! Findings about the logs whose effect on the results is measured by the estimation.

use crate::check::DELAYED_CHANNEL;
use crate::estimate::result::EstimateResult;
use crate::estimate::statistics::CERTAIN_SIGMAS;
use crate::finding::{Finding, Severity};
use crate::log::{Channels, Quantity};
use crate::numbers::in_ms;

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

/// Code of a delay by likelihood.
const LATE_CHANNEL: &str = "late-channel";

/// Turns warnings about the logs into notes if their effect is measured: those about noise, filters
/// and excitation, delays that the likelihood of the whole robot refutes, and a delay of all torques that the intervals
/// of least squares contain.
pub(in crate::estimate) fn after_estimation(
    findings: &mut [Finding],
    results: &[EstimateResult],
    of_torques: Option<&DelayOfTorques<'_>>,
) {
    for finding in (findings.iter_mut()).filter(|finding| finding.severity == Severity::Warning) {
        let more = if MEASURED_EFFECTS.contains(&finding.code.as_str()) {
            Some("The intervals and the promise contain the effect".to_owned())
        } else {
            (finding.code == DELAYED_CHANNEL)
                .then(|| {
                    (results.iter().find_map(|result| refuted(finding, result)))
                        .or_else(|| of_torques?.contains(finding))
                })
                .flatten()
        };
        if let Some(more) = more {
            finding.severity = Severity::Info;
            finding.text = format!("{}. {more}", finding.text);
        }
    }
}

/// The delay with which all torques were recorded by the equations. The intervals of least squares contain its effect.
pub(in crate::estimate) struct DelayOfTorques<'a> {
    /// s.
    pub(in crate::estimate) delay: f64,
    /// Sampling period, s.
    pub(in crate::estimate) period: f64,
    pub(in crate::estimate) channels: &'a Channels,
}

impl DelayOfTorques<'_> {
    /// Returns the reason why the intervals contain the delay of a torque, if it differs by less than half a period
    /// from that of all torques.
    fn contains(&self, finding: &Finding) -> Option<String> {
        let evidence = finding.evidence.as_ref()?;
        let column = evidence.column.as_ref()?;
        let is_torque = (self.channels.all.iter())
            .any(|channel| channel.column == *column && channel.quantity == Quantity::MotorTorque);
        let differs = (evidence.value - self.delay).abs() > 0.5 * self.period;
        (is_torque && !differs).then(|| {
            format!(
                "By the equations all torques together were recorded {:.3} ms late. The intervals of least squares contain \
                 the effect; the estimator \"prediction-error\" estimates it",
                in_ms(self.delay)
            )
        })
    }
}

/// Returns the evidence of the likelihood against a delay by least squares, if there is any.
fn refuted(finding: &Finding, result: &EstimateResult) -> Option<String> {
    let refinement = result.refined()?;
    let is_late =
        |other: &Finding| other.code == LATE_CHANNEL && other.severity >= Severity::Warning;
    let column = finding.evidence.as_ref()?.column.as_ref()?;
    let delay = refinement
        .delays
        .iter()
        .find(|delay| delay.column == *column)?;
    let error = delay.standard_error_s?;
    let size = (delay.delay_s - delay.used_s).abs();
    (size <= CERTAIN_SIGMAS * error && !result.warnings.iter().any(is_late)).then(|| {
        format!(
            "The likelihood of the whole robot does not confirm the delay ({:.3} ± {:.3} ms)",
            in_ms(delay.delay_s),
            in_ms(error)
        )
    })
}
