//! Errors of the choice of columns.

/// Why no columns of a log can be chosen.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ChooseError {
    /// No column belongs to a joint.
    #[error(
        "no column of {file} belongs to a joint of the robot. Joints: {joints}. {has}: {columns}{nearest}. \
         A column belongs to a joint if its name contains the name or the number of the joint; rename \
         the columns, or run sprung new without --log and name them in experiment.toml"
    )]
    NoJoint {
        /// Name of the log.
        file: String,
        /// The first names of joints.
        joints: String,
        /// What the log has: columns or topics.
        has: &'static str,
        /// The first names of columns.
        columns: String,
        /// The nearest pair of names; begins with a semicolon unless it is empty.
        nearest: String,
    },
    /// The joints of the log have no motion that could be a position.
    #[error(
        "{file} has columns of the joints, but none of them changes; a log of a moving robot is needed"
    )]
    NothingMoves {
        /// Name of the log.
        file: String,
    },
    /// The log has the joints of several robots.
    #[error(
        "{file} has the joints of {} robots, in topics that begin with {}; give those of one robot: --topics {}",
        .topics.len(), .topics.join(", "), .topics[0]
    )]
    SeveralRobots {
        /// Name of the log.
        file: String,
        /// Beginnings of the topics of each robot.
        topics: Vec<String>,
    },
    /// No topic begins with the given letters.
    #[error("{file} has no topic that begins with {beginning}: {topics}")]
    NoTopic {
        /// Name of the log.
        file: String,
        /// The given letters.
        beginning: String,
        /// The topics, in words.
        topics: String,
    },
    /// All joints of the log belong to a gripper.
    #[error(
        "{file} has only joints of a gripper: {joints}. A log of the arm is needed; for a gripper alone, run sprung \
         new without --log, keep the blocks of these joints and name their columns"
    )]
    OnlyGripper {
        /// Name of the log.
        file: String,
        /// The joints, each with the reason.
        joints: String,
    },
}
