//! Errors of LSFF.

use sprung_core::filter::FilterError;
use sprung_core::recursive::RecursiveError;
use sprung_core::velocity::VelocityError;

/// Reason why the recursion cannot run.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LsffError {
    /// The filter pair cannot be built.
    #[error("{0}")]
    Filter(FilterError),
    /// The velocity estimator cannot be built.
    #[error("{0}")]
    Velocity(VelocityError),
    /// The recursion cannot be built.
    #[error("{0}")]
    Recursive(RecursiveError),
    /// The logs have different sampling periods.
    #[error(
        "estimator \"lsff\" runs at one sampling period, the logs have {first:.6} s and {other:.6} s; \
         identify them one by one, or by \"least-squares\" alone"
    )]
    Periods {
        /// Period of the first log, s.
        first: f64,
        /// Period of the other log, s.
        other: f64,
    },
}
