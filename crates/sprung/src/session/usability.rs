//! Rates the usability of results.

use sprung_base::finding::Severity;
use sprung_method::check::CheckReport;
use sprung_method::estimate::{Identification, Verdict};
use sprung_method::validate::Validation;

/// Usability of results. The numbers are available in any case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Usability {
    /// No serious finding exists.
    Usable,
    /// A serious finding exists.
    Unusable,
    /// The log contradicts the experiment file.
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
    /// Rates the result of the first estimator.
    fn from(identification: &Identification) -> Self {
        match identification.results.first() {
            Some(result) if result.verdict == Verdict::Unusable => Self::Unusable,
            _ => Self::Usable,
        }
    }
}

impl From<&Validation> for Usability {
    /// Rates the first parameter set of each run: it is unusable if its simulated loop diverges.
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
