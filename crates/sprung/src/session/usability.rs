//! Whether what came out can be used.

use crate::check::CheckReport;
use crate::estimate::{Identification, Verdict};
use crate::finding::Severity;
use crate::validate::Validation;

/// Whether what came out can be used; the numbers are there in any case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Usability {
    /// Nothing serious is known against it.
    Usable,
    /// Something serious is.
    Unusable,
    /// The log is wrong.
    WrongLog,
}

impl From<&CheckReport> for Usability {
    fn from(report: &CheckReport) -> Self {
        match report.worst() {
            Some(Severity::Error) => Self::WrongLog,
            Some(Severity::Serious) => Self::Unusable,
            Some(Severity::Warning | Severity::Info) | None => Self::Usable,
        }
    }
}

impl From<&Identification> for Usability {
    /// Judges the first estimator.
    fn from(identification: &Identification) -> Self {
        match identification.results.first() {
            Some(result) if result.verdict == Verdict::Unusable => Self::Unusable,
            _ => Self::Usable,
        }
    }
}

impl From<&Validation> for Usability {
    /// A first parameter set that cannot be simulated is of no use.
    fn from(validation: &Validation) -> Self {
        let serious = validation.runs.iter().any(|run| {
            run.sets.first().is_some_and(|set| {
                (set.findings.iter()).any(|finding| finding.severity == Severity::Serious)
            })
        });
        if serious {
            Self::Unusable
        } else {
            Self::Usable
        }
    }
}
