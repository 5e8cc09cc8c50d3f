//! Decides on a result: the verdict, the findings that decided, and a sentence for the user.

use super::promise::percent;
use super::reasons::reason;
use crate::estimate::result::{Decision, EstimateResult, JointPrediction, Verdict};
use crate::finding::{Finding, Severity};
use crate::model::short;

/// Maximum number of parameters of a finding that the sentence names. It changes words only.
const MAX_NAMED_PARAMETERS: usize = 4;

/// Decides on a result: sets its verdict and the decision.
///
/// - `about_logs`: findings about the logs, which count for every result.
pub(in crate::estimate) fn decide(result: &mut EstimateResult, about_logs: &[Finding]) {
    let findings = || about_logs.iter().chain(&result.warnings);
    let verdict = Verdict::of(findings());
    let least = match verdict {
        Verdict::Good => None,
        Verdict::Doubtful => Some(Severity::Warning),
        Verdict::Unusable => Some(Severity::Serious),
    };
    let mut deciding: Vec<&Finding> = findings()
        .filter(|finding| least.is_some_and(|least| finding.severity >= least))
        .collect();
    deciding.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    let reasons = Reason::of(&deciding);
    let parameters = (reasons.iter())
        .flat_map(|reason| &reason.parameters)
        .map(|name| (*name).to_owned())
        .collect();
    let decision = Decision {
        sentence: sentence(verdict, &result.promise, &reasons),
        promise: promised(verdict, &result.promise),
        because: causes(reasons.iter()),
        findings: reasons
            .iter()
            .map(|reason| reason.code.to_owned())
            .collect(),
        parameters,
    };
    result.verdict = verdict;
    result.decision = decision;
}

/// Deciding findings of one code.
struct Reason<'a> {
    code: &'a str,
    // Parameters that no earlier reason names.
    parameters: Vec<&'a str>,
}

impl<'a> Reason<'a> {
    /// Groups findings by their codes, in their order.
    fn of(findings: &[&'a Finding]) -> Vec<Self> {
        let mut reasons: Vec<Self> = Vec::new();
        for finding in findings {
            let at = (reasons.iter()).position(|reason| reason.code == finding.code);
            let at = at.unwrap_or_else(|| {
                reasons.push(Reason {
                    code: &finding.code,
                    parameters: Vec::new(),
                });
                reasons.len() - 1
            });
            for name in &finding.parameters {
                let is_named =
                    (reasons.iter()).any(|reason| reason.parameters.contains(&name.as_str()));
                if !is_named {
                    reasons[at].parameters.push(name);
                }
            }
        }
        reasons
    }

    /// Returns the names of the first parameters.
    fn names(&self) -> String {
        let shown = self.parameters.iter().take(MAX_NAMED_PARAMETERS);
        let mut names: Vec<String> = shown.map(|name| short(name).into_owned()).collect();
        let more = self.parameters.len().saturating_sub(MAX_NAMED_PARAMETERS);
        if more > 0 {
            names.push(format!("{more} more"));
        }
        list(&names)
    }
}

/// Returns the decision in words: the promise, and the parameters not to use, with reasons.
fn sentence(verdict: Verdict, promise: &[JointPrediction], reasons: &[Reason<'_>]) -> String {
    let promised = promised(verdict, promise);
    match verdict {
        Verdict::Good => promised,
        Verdict::Doubtful => format!("{promised} {}.", reservations(reasons)),
        Verdict::Unusable => format!(
            "{promised} Do not use the values, because {}.",
            causes(reasons.iter())
        ),
    }
}

/// Returns the verdict and the promise as a sentence.
fn promised(verdict: Verdict, promise: &[JointPrediction]) -> String {
    let predicts = match expected_errors(promise) {
        Some(errors) => format!(
            "on a new experiment of this kind the model is expected to predict {errors} (root mean \
             squares)"
        ),
        None => "the log does not show how well the model predicts a new experiment".to_owned(),
    };
    let word = match verdict {
        Verdict::Good => "Good",
        Verdict::Doubtful => "Doubtful",
        Verdict::Unusable => "Unusable",
    };
    format!("{word}: {predicts}.")
}

/// Returns the reservations of a doubtful result: parameters not to be used alone, and reasons for a bias of all.
fn reservations(reasons: &[Reason<'_>]) -> String {
    let (naming, other): (Vec<_>, Vec<_>) =
        (reasons.iter()).partition(|reason| !reason.parameters.is_empty());
    let alone: Vec<String> = (naming.iter())
        .map(|named| format!("{} alone, because {}", named.names(), reason(named.code)))
        .collect();
    let alone = alone.join(", nor ");
    let causes = causes(other.iter().copied());
    match (alone.is_empty(), causes.is_empty()) {
        (false, true) => format!("Do not use {alone}"),
        (false, false) => format!("Do not use {alone}; all values may be biased, because {causes}"),
        (true, _) => format!("The values may be biased, because {causes}"),
    }
}

/// Joins the reasons of findings; each reason stands once.
fn causes<'a>(reasons: impl Iterator<Item = &'a Reason<'a>>) -> String {
    let mut clauses: Vec<String> = Vec::new();
    for cause in reasons {
        let clause = reason(cause.code).to_owned();
        if !clauses.contains(&clause) {
            clauses.push(clause);
        }
    }
    list(&clauses)
}

/// Returns the expected errors relative to the torques and deflections, in words; `None` without a
/// promise.
fn expected_errors(promise: &[JointPrediction]) -> Option<String> {
    let torques: Vec<(&str, f64)> = (promise.iter())
        .map(|joint| {
            (
                joint.joint.as_str(),
                joint.torque_error_nm / joint.torque_nm,
            )
        })
        .filter(|(_, error)| error.is_finite())
        .collect();
    let deflections: Vec<(&str, f64)> = (promise.iter())
        .filter_map(|joint| {
            let error = joint.deflection_error_rad? / joint.deflection_rad?;
            Some((joint.joint.as_str(), error)).filter(|(_, error)| error.is_finite())
        })
        .collect();
    let mut texts = Vec::new();
    for (name, errors) in [("motor torque", torques), ("deflection", deflections)] {
        texts.extend(range(name, &errors, texts.is_empty()));
    }
    (!texts.is_empty()).then(|| texts.join(" and "))
}

/// Returns a quantity with the smallest and the largest error of its joints.
///
/// - `errors`: joints and relative errors; `with_names`: whether the joints are named.
fn range(quantity: &str, errors: &[(&str, f64)], with_names: bool) -> Option<String> {
    let by_error = |a: &&(&str, f64), b: &&(&str, f64)| a.1.total_cmp(&b.1);
    let (least, most) = (
        errors.iter().min_by(by_error)?,
        errors.iter().max_by(by_error)?,
    );
    let (low, high) = (percent(least.1), percent(most.1));
    if errors.len() == 1 {
        return Some(format!(
            "the {quantity} of {} with an error of {high}",
            most.0
        ));
    }
    let range = if low == high {
        high
    } else if with_names {
        format!("{low} ({}) to {high} ({})", least.0, most.0)
    } else if high.ends_with(" %") {
        format!("{} to {high}", low.trim_end_matches(" %"))
    } else {
        format!("{low} to {high}")
    };
    Some(format!("the {quantity}s with errors of {range}"))
}

/// Joins words with commas and "and".
fn list(words: &[String]) -> String {
    match words {
        [] => String::new(),
        [word] => word.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn promised(joint: &str, torque_error: f64, deflection_error: Option<f64>) -> JointPrediction {
        JointPrediction {
            joint: joint.to_owned(),
            torque_nm: 2.0,
            torque_error_nm: 2.0 * torque_error,
            deflection_rad: deflection_error.map(|_| 0.1),
            deflection_error_rad: deflection_error.map(|error| 0.1 * error),
        }
    }

    fn finding(severity: Severity, code: &str, parameters: &[&str]) -> Finding {
        Finding::new(severity, code, String::new(), "")
            .about(parameters.iter().map(|name| (*name).to_owned()))
    }

    fn said(promise: &[JointPrediction], findings: &[Finding]) -> String {
        let all: Vec<&Finding> = findings.iter().collect();
        sentence(Verdict::of(findings), promise, &Reason::of(&all))
    }

    #[test]
    fn each_verdict_is_a_sentence() {
        let two = [
            promised("joint1", 0.019, Some(0.008)),
            promised("joint2", 0.024, Some(0.011)),
        ];
        assert_eq!(
            said(&two, &[]),
            "Good: on a new experiment of this kind the model is expected to predict the motor \
             torques with errors of 1.9 % (joint1) to 2.4 % (joint2) and the deflections with \
             errors of 0.80 to 1.1 % (root mean squares)."
        );
        let warning = Severity::Warning;
        let weak = finding(warning, "weakly-excited", &["joint2.link_viscous"]);
        assert!(
            said(&two, std::slice::from_ref(&weak)).ends_with(
                "(root mean squares). Do not use joint2.link_viscous alone, because the excitation is weak."
            )
        );
        let late = finding(warning, "late-channel", &[]);
        let same = finding(warning, "collinear", &["a", "joint2.link_viscous", "b"]);
        let doubtful = said(&two, &[weak, late.clone(), late.clone(), same]);
        assert!(
            doubtful.ends_with(
                ". Do not use joint2.link_viscous alone, because the excitation is weak, nor a and b alone, \
                 because two parameters act alike in this motion; all values may be biased, because a column is late."
            ),
            "{doubtful}"
        );
        assert!(
            said(&two, &[late]).ends_with(". The values may be biased, because a column is late.")
        );
        let serious = finding(Severity::Serious, "poor-fit", &["joint1.stiffness"]);
        assert_eq!(
            said(&[promised("joint1", 0.45, None)], &[serious]),
            "Unusable: on a new experiment of this kind the model is expected to predict the motor torque of joint1 \
             with an error of 45 % (root mean squares). Do not use the values, because the model does not explain \
             the torque."
        );
    }

    #[test]
    fn a_result_without_a_promise_says_so() {
        let text = "the log does not show how well the model predicts a new experiment";
        assert_eq!(said(&[], &[]), format!("Good: {text}."));
        // A joint without torque has no relative error.
        let mut still = promised("joint1", 0.1, None);
        still.torque_nm = 0.0;
        assert_eq!(said(&[still], &[]), format!("Good: {text}."));
    }
}
