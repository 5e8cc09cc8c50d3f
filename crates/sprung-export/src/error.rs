//! Why a robot cannot be exported.

use crate::description::UrdfError;
use crate::model::ModelError;

/// Errors of an export.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The parameters belong to another robot.
    #[error(
        "the parameters are those of {found}, the experiment describes {expected}; give the \
         identification of this robot with --parameters FILE"
    )]
    OtherRobot {
        /// Robot of the parameters.
        found: String,
        /// Robot of the experiment.
        expected: String,
    },
    /// Single links have no parameters.
    #[error(
        "no inertial parameters of single links are known ({} and {more} more are missing); {remedy}",
        names.join(", ")
    )]
    NoBodies {
        /// The first missing names.
        names: Vec<String>,
        /// Number of further names.
        more: usize,
        /// Remedy.
        remedy: &'static str,
    },
    /// The log does not determine a parameter that a model needs.
    #[error(
        "no value for {}; a simulation needs it: record a motion that excites it, or give it in [robot.fixed]",
        names.join(", ")
    )]
    NotDetermined {
        /// Names of the parameters.
        names: Vec<String>,
    },
    /// A body or a drive cannot exist.
    #[error(
        "the parameters are not physical: {}; export an identification.json with standard_parameters, \
         which are the nearest possible values",
        reasons.join("; also ")
    )]
    NotPhysical {
        /// Links and joints with the reasons.
        reasons: Vec<String>,
    },
    /// A format forbids a name.
    #[error("{format} forbids the name \"{name}\": {reason}; rename it in the robot's description")]
    Name {
        /// Format.
        format: &'static str,
        /// The name.
        name: String,
        /// Reason.
        reason: &'static str,
    },
    /// The code of the robot would be too large.
    #[error("{format} cannot hold the robot: {what}; export it as JSON, or fewer joints")]
    TooLarge {
        /// Format.
        format: &'static str,
        /// The size and its limit.
        what: String,
    },
    /// A controller does not fit the robot.
    #[error("the controller does not fit the robot: {what}")]
    Controller {
        /// What is wrong.
        what: String,
    },
    /// An observer does not fit the robot.
    #[error("the code cannot have the observer: {what}")]
    Observer {
        /// What is wrong.
        what: String,
    },
    /// A name that the export adds exists already.
    #[error(
        "the robot already has a {what} \"{name}\", which the export adds for a motor; rename it, or \
         export with --rigid"
    )]
    Taken {
        /// `link` or `joint`.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// The URDF of the robot is wrong.
    #[error(transparent)]
    Urdf(#[from] UrdfError),
    /// The parameters do not match the robot.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The written file does not contain the identified robot.
    #[error(
        "the exported {format} was read back and differs from the identified model: {what}; nothing was \
         written, please report this"
    )]
    Differs {
        /// Format.
        format: &'static str,
        /// Quantity and difference.
        what: String,
    },
}
