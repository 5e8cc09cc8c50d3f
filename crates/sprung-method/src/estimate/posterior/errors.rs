//! Errors of draws.

/// Reason why no robots can be drawn.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PosteriorError {
    /// The result has no covariance of its errors.
    #[error(
        "the result of {estimator} has no covariance of its errors, so no robots can be drawn from it; identify with \
         least-squares or prediction-error, from a log of several periods"
    )]
    NoCovariance {
        /// Name of the estimator.
        estimator: String,
    },
    /// The covariance is that of no errors.
    #[error(
        "the covariance of the errors of {estimator} is not finite and positive definite; identify the robot again"
    )]
    Covariance {
        /// Name of the estimator.
        estimator: String,
    },
    /// The result has a parameter that the robot lacks.
    #[error(
        "the result has the parameter {name}, which the robot lacks; give the experiment of this identification"
    )]
    OtherRobot {
        /// Name of the parameter.
        name: String,
    },
    /// The log does not determine parameters, and no prior gives them.
    #[error(
        "the log does not determine {}, and the experiment gives no nominal value; give one, or a value in fixed",
        .names.join(", ")
    )]
    NoValue {
        /// Names of the parameters.
        names: Vec<String>,
    },
    /// No robot can exist with the given values and limits.
    #[error(
        "no robot can exist with the given values and limits: {0}; compare fixed, assume_zero, total_mass_kg and mass_kg \
         with the robot"
    )]
    NoRobot(String),
    /// Too few or too many robots are wanted.
    #[error("{count} robots cannot be drawn; draw 1 to {most}")]
    Count {
        /// Number of robots.
        count: usize,
        /// Largest number.
        most: usize,
    },
}
