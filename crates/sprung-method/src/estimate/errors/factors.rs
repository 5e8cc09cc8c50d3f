//! Errors of factors that do not belong together.

use crate::description::NotSupported;

/// Reason why factors of logs cannot be used together.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FactorsError {
    /// There are no factors.
    #[error("there are no factors of logs; make them of each log first")]
    None,
    /// A text is not a value that sprung wrote.
    #[error("{what} cannot be read: {why}; make them again")]
    NotReadable {
        /// The kind of the value.
        what: &'static str,
        /// The fault.
        why: String,
    },
    /// Another version of sprung made the value.
    #[error(
        "{what} were made by {generator}, format {format}; this is sprung {}, which reads its own values of \
         format {known} alone: make them again with one version",
        env!("CARGO_PKG_VERSION")
    )]
    OtherVersion {
        /// The value.
        what: String,
        /// Program that made it.
        generator: String,
        /// Its format.
        format: u64,
        /// The format that this version reads.
        known: u64,
    },
    /// The robot has another name.
    #[error("{what} are those of the robot \"{found}\", not of \"{robot}\"")]
    OtherRobot {
        /// The value.
        what: String,
        /// Name of its robot.
        found: String,
        /// Name of the robot in use.
        robot: String,
    },
    /// The experiment differs.
    #[error(
        "{what} were made with another experiment: [robot], [identify] or the columns of [log] \
         differ; make them again with this one"
    )]
    OtherExperiment {
        /// The value.
        what: String,
    },
    /// The choices differ.
    #[error(
        "{what} were made with other choices ({differs} {differ}): all factors of one robot need the choices \
         from the same first log",
        differs = .differing.join(", "),
        differ = if .differing.len() == 1 { "differs" } else { "differ" }
    )]
    OtherChoices {
        /// The value.
        what: String,
        /// Names of the choices that differ.
        differing: Vec<&'static str>,
    },
    /// Two logs have one place in the order.
    #[error(
        "{first} and {second} both are log {order}; give each log once, with a number of its own"
    )]
    Twice {
        /// Name of the log.
        first: String,
        /// Name of the other log.
        second: String,
        /// Its number.
        order: usize,
    },
    /// The numbers do not have the shape of this robot's equations.
    #[error(
        "the factors of {log} do not have the shape of this robot's equations; make them again"
    )]
    OtherShape {
        /// Name of the log.
        log: String,
    },
    /// A log serves only a payload.
    #[error(transparent)]
    NotSupported(#[from] NotSupported),
}
