//! Outcome of a refinement.

use super::descent::Ending;
use super::hold_out::HeldOut;
use super::refined::Refined;
use crate::finding::{Finding, Severity};
use crate::model::Model;

/// Maximum number of parameters named if a refinement did not converge.
const MAX_NAMED_PARAMETERS: usize = 3;

/// Outcome of a refinement. It determines whether the refinement is used.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Status {
    /// The refinement converged to parameters that predict held-out samples, and is used.
    Converged,
    /// The refinement was not tried because a log itself is faulty; code of that finding.
    NotTried { code: String },
    /// The filter does not follow the log, or the log is too short.
    NotFollowed,
    /// Disturbances of these rows ended at their upper bound.
    AtBound { rows: Vec<String> },
    /// The search did not converge: number of filter runs, and the parameters that moved most in
    /// the last step, in standard errors.
    NotConverged {
        runs: usize,
        moved: Vec<(String, f64)>,
    },
    /// The refinement predicts held-out samples worse than least squares.
    NotPredictive(HeldOut),
}

impl Status {
    /// Judges a refinement.
    ///
    /// - `held_out`: residuals on held-out samples, if they are known.
    pub(super) fn of(model: &Model, refined: &Refined, held_out: Option<HeldOut>) -> Self {
        let bound: Vec<String> = (refined.levels.iter().enumerate())
            .filter(|(_, level)| level.at_bound)
            .map(|(row, _)| model.row_name(row))
            .collect();
        if !bound.is_empty() {
            return Self::AtBound { rows: bound };
        }
        match (refined.ending, held_out) {
            (Ending::AtBound | Ending::OutOfRuns, _) => Self::NotConverged {
                runs: refined.runs,
                moved: (refined.moved.iter().take(MAX_NAMED_PARAMETERS))
                    .map(|(index, by)| (model.parameters()[*index].short().into_owned(), *by))
                    .collect(),
            },
            (Ending::Converged, Some(held)) if held.is_worse() => Self::NotPredictive(held),
            (Ending::Converged, _) => Self::Converged,
        }
    }

    /// Returns whether the refinement is used.
    pub(super) fn is_used(&self) -> bool {
        match self {
            Self::Converged => true,
            Self::NotTried { .. }
            | Self::NotFollowed
            | Self::AtBound { .. }
            | Self::NotConverged { .. }
            | Self::NotPredictive(_) => false,
        }
    }

    /// Returns the reason why the refinement is not used; `None` if it is used.
    fn reason(&self) -> Option<String> {
        Some(match self {
            Self::Converged => return None,
            Self::NotTried { code } => {
                format!("it was not tried, because the log itself is wrong ({code})")
            }
            Self::NotFollowed => "the filter does not follow the log from the linear values, or \
                                  the log is too short"
                .to_owned(),
            Self::AtBound { rows } => format!(
                "in {} the torque that the model does not explain is a quarter of the motor's or more, \
                 which is not a disturbance but an effect that the model lacks",
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
            Self::NotPredictive(held) => format!(
                "estimated from the first three quarters of the logs, it leaves {:.1} % of the \
                 filtered torque of the last quarter unexplained, least squares {:.1} %: an effect \
                 that repeats with the motion is attributed to disturbances",
                100.0 * held.refined,
                100.0 * held.linear
            ),
        })
    }

    /// Returns a finding that the linear values stand; `None` if the refinement is used.
    pub(super) fn finding(&self) -> Option<Finding> {
        let why = self.reason()?;
        Some(Finding::new(
            Severity::Warning,
            "refinement-failed",
            format!(
                "the refinement is not used: {why}. The values here are those of least squares, and \
                 their intervals are lower bounds"
            ),
            "look at signs, units and delays of the columns, at missing friction laws, and at the other \
             warnings",
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_status_but_one_says_why_the_refinement_is_not_used() {
        let held = HeldOut {
            refined: 0.061,
            linear: 0.05,
        };
        let moved = vec![("m1".to_owned(), -0.25)];
        let cases = [
            (
                Status::NotTried {
                    code: "a-code".to_owned(),
                },
                "is wrong (a-code)",
            ),
            (Status::NotFollowed, "does not follow the log"),
            (
                Status::AtBound {
                    rows: vec!["row".to_owned()],
                },
                "in row the torque",
            ),
            (
                Status::NotConverged { runs: 30, moved },
                "in 30 runs of the filter; last moves, in standard errors: m1 by -0.25",
            ),
            (
                Status::NotPredictive(held),
                "6.1 % of the filtered torque of the last quarter unexplained, least squares 5.0 %",
            ),
        ];
        for (status, words) in cases {
            let text = status.finding().unwrap().text;
            assert!(!status.is_used() && text.contains(words), "{text}");
        }
        assert!(Status::Converged.is_used() && Status::Converged.finding().is_none());
    }
}
