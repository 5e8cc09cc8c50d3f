//! Outcome of a refinement and of each rung.

use super::descent::Ending;
use super::hold_out::HeldOut;
use super::ladder::Tried;
use super::rung::Rung;
use crate::finding::{Finding, Severity};
use crate::model::Model;
use crate::numbers::in_percent;

/// Maximum number of parameters named if a rung did not converge. It changes words only.
const MAX_NAMED_PARAMETERS: usize = 3;

/// Outcome of a refinement. It determines whether the refinement is used.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Status {
    /// The values of this rung are used. Outcomes of all rungs that were tried.
    Used(Rung, Vec<(Rung, Outcome)>),
    /// The refinement was not tried because a log is faulty; code of that finding.
    NotTried { code: String },
    /// The log is too short, or no robot has parameters near the start.
    Impossible,
    /// No rung can be used. Outcomes of all rungs.
    StandsBack(Vec<(Rung, Outcome)>),
}

/// Outcome of a rung.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Outcome {
    /// Its values are used.
    Used(Option<HeldOut>),
    /// Its values could be used, but those of another rung predict held-out folds better, or
    /// equally well and the other rung is earlier.
    Passed(HeldOut),
    /// The filter does not follow the log from the start.
    NotFollowed,
    /// Disturbances of these rows ended at their upper bound.
    AtBound { rows: Vec<String> },
    /// The search did not converge: number of filter runs, and the parameters that moved most in
    /// the last step, in standard errors.
    NotConverged {
        runs: usize,
        moved: Vec<(String, f64)>,
    },
    /// The rung predicts held-out folds worse than least squares.
    NotPredictive(HeldOut),
}

impl Outcome {
    /// Judges a rung.
    fn of(model: &Model, tried: &Tried, is_used: bool) -> Self {
        let Some(refined) = tried.refined() else {
            return Self::NotFollowed;
        };
        let bound: Vec<String> = (refined.noise.rows.iter().enumerate())
            .filter(|(_, level)| level.at_bound)
            .map(|(row, _)| model.row_name(row))
            .collect();
        match (refined.search.ending, tried.held_out) {
            _ if !bound.is_empty() => Self::AtBound { rows: bound },
            (Ending::GivenUp, Some(held)) => Self::NotPredictive(held),
            (Ending::AtBound | Ending::GivenUp | Ending::OnlyNoise | Ending::OutOfRuns, _) => {
                Self::NotConverged {
                    runs: refined.search.runs,
                    moved: (refined.search.moved.iter().take(MAX_NAMED_PARAMETERS))
                        .map(|(index, by)| (model.parameters()[*index].short().into_owned(), *by))
                        .collect(),
                }
            }
            (Ending::Converged, held) if is_used => Self::Used(held),
            (Ending::Converged, Some(held)) if tried.passed().is_none() => {
                Self::NotPredictive(held)
            }
            (Ending::Converged, Some(held)) => Self::Passed(held),
            (Ending::Converged, None) => Self::Used(None),
        }
    }

    /// Returns the residuals on held-out folds, if the outcome depends on them.
    pub(super) fn held_out(&self) -> Option<HeldOut> {
        match self {
            Self::Used(held) => *held,
            Self::Passed(held) | Self::NotPredictive(held) => Some(*held),
            Self::NotFollowed | Self::AtBound { .. } | Self::NotConverged { .. } => None,
        }
    }

    /// Returns the outcome as the end of a sentence about the rung.
    pub(super) fn text(&self) -> String {
        let held = |held: &HeldOut| {
            format!(
                "it leaves {:.2} % of the filtered torque of held-out blocks unexplained, least \
                 squares {:.2} %",
                in_percent(held.refined),
                in_percent(held.linear)
            )
        };
        match self {
            Self::Used(None) => "it is used".to_owned(),
            Self::Used(Some(held_out)) => format!("it is used: {}", held(held_out)),
            Self::Passed(held_out) => format!("another rung is preferred: {}", held(held_out)),
            Self::NotPredictive(held_out) => format!("it predicts worse: {}", held(held_out)),
            Self::NotFollowed => "the filter does not follow the log".to_owned(),
            Self::AtBound { rows } => format!(
                "in {} the torque that the model does not explain is a quarter of the motor's or more",
                rows.join(", ")
            ),
            Self::NotConverged { runs, moved } => {
                let moved = (moved.iter()).map(|(name, by)| format!("{name} by {by:+.2}"));
                format!(
                    "it did not converge in {runs} runs of the filter; last moves, in standard \
                     errors: {}",
                    moved.collect::<Vec<_>>().join(", ")
                )
            }
        }
    }
}

impl Status {
    /// Judges the rungs that were tried.
    ///
    /// - `used`: index of the rung that is used.
    pub(super) fn of(model: &Model, tried: &[Tried], used: Option<usize>) -> Self {
        if tried.is_empty() {
            return Self::Impossible;
        }
        let outcomes = (tried.iter().enumerate())
            .map(|(i, attempt)| (attempt.rung, Outcome::of(model, attempt, used == Some(i))))
            .collect();
        match used {
            Some(used) => Self::Used(tried[used].rung, outcomes),
            None => Self::StandsBack(outcomes),
        }
    }

    /// Returns whether the refinement is used.
    pub(super) fn is_used(&self) -> bool {
        match self {
            Self::Used(..) => true,
            Self::NotTried { .. } | Self::Impossible | Self::StandsBack(_) => false,
        }
    }

    /// Returns the outcomes of the rungs that were tried.
    pub(super) fn outcomes(&self) -> &[(Rung, Outcome)] {
        match self {
            Self::Used(_, outcomes) | Self::StandsBack(outcomes) => outcomes,
            Self::NotTried { .. } | Self::Impossible => &[],
        }
    }

    /// Returns the outcomes of the rungs in words.
    fn rungs(&self) -> String {
        let each = self.outcomes().iter();
        each.map(|(rung, outcome)| {
            format!("{} ({}): {}", rung.name(), rung.about(), outcome.text())
        })
        .collect::<Vec<_>>()
        .join("; ")
    }

    /// Returns a finding that the values of least squares or a lower rung are used; `None` if the
    /// first rung is used.
    pub(super) fn finding(&self) -> Option<Finding> {
        let why = match self {
            Self::Used(Rung::Free, _) => return None,
            Self::Used(rung, _) => {
                return Some(Finding::new(
                    Severity::Info,
                    "refinement-rung",
                    format!(
                        "the refinement allows {}, because the model lacks an effect: {}",
                        rung.about(),
                        self.rungs()
                    ),
                    "try further friction laws; the intervals include the scatter of the residuals",
                ));
            }
            Self::NotTried { code } => {
                format!("it was not tried, because the log itself is wrong ({code})")
            }
            Self::Impossible => {
                "the log is too short, or no robot has parameters near the linear ones".to_owned()
            }
            Self::StandsBack(_) => self.rungs(),
        };
        // The findings about least squares judge the values of least squares.
        let severity = match self {
            Self::StandsBack(_) => Severity::Info,
            Self::Used(..) | Self::NotTried { .. } | Self::Impossible => Severity::Warning,
        };
        Some(Finding::new(
            severity,
            "refinement-failed",
            format!(
                "the refinement is not used: {why}. The values and intervals here are those of least \
                 squares"
            ),
            "look at signs, units and delays of the columns, at missing friction laws, and at the other \
             warnings",
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WORSE: HeldOut = HeldOut {
        refined: 0.061,
        linear: 0.05,
    };

    #[test]
    fn every_outcome_says_why_the_refinement_is_not_used() {
        let moved = vec![("m1".to_owned(), -0.25)];
        let cases = [
            (Outcome::NotFollowed, "does not follow the log"),
            (
                Outcome::AtBound {
                    rows: vec!["row".to_owned()],
                },
                "in row the torque",
            ),
            (
                Outcome::NotConverged { runs: 30, moved },
                "in 30 runs of the filter; last moves, in standard errors: m1 by -0.25",
            ),
            (
                Outcome::NotPredictive(WORSE),
                "6.10 % of the filtered torque of held-out blocks unexplained, least squares 5.00 %",
            ),
        ];
        for (outcome, words) in cases {
            let status = Status::StandsBack(vec![(Rung::Flat, outcome)]);
            let text = status.finding().unwrap().text;
            assert!(!status.is_used() && text.contains(words), "{text}");
            assert!(text.contains("flat (no slow disturbances): "), "{text}");
        }
        let status = Status::NotTried {
            code: "a-code".to_owned(),
        };
        let text = status.finding().unwrap().text;
        assert!(
            !status.is_used() && text.contains("is wrong (a-code)"),
            "{text}"
        );
    }

    #[test]
    fn a_lower_rung_is_reported_and_the_first_one_is_not() {
        let outcome = Outcome::Used(Some(WORSE));
        let status = |rung| Status::Used(rung, vec![(rung, outcome.clone())]);
        assert!(status(Rung::Free).is_used() && status(Rung::Free).finding().is_none());
        let finding = status(Rung::Cap10).finding().unwrap();
        assert_eq!(finding.severity, Severity::Info);
        assert!(finding.text.contains("up to 10 times the white noise"));
    }
}
