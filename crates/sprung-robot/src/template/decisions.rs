//! Decisions about a log, which a new experiment contains.

use super::super::unfilled::FILL_IN;

/// A line `key = value` of an experiment file, and the reason for it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChosenLine {
    /// Key of the line.
    pub key: String,
    /// The value, as TOML.
    pub value: String,
    /// The reason, as sentences without the last full stop; empty if the line needs none.
    pub why: String,
}

impl ChosenLine {
    /// Returns a line with its reason.
    pub fn new(key: &str, value: impl Into<String>, why: impl Into<String>) -> Self {
        Self {
            key: key.to_owned(),
            value: value.into(),
            why: why.into(),
        }
    }

    /// Returns a line whose value only the user knows.
    pub fn open(key: &str, why: impl Into<String>) -> Self {
        Self::new(key, format!("\"{FILL_IN}\""), why)
    }
}

/// Decisions about a log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chosen {
    /// Lines of `[log]`.
    pub lines: Vec<ChosenLine>,
    /// The joints of the log, in the order of the robot.
    pub joints: Vec<ChosenJoint>,
    /// Names of the joints that are not in the log.
    pub left_out: Vec<String>,
    /// Joints of a gripper, each with the reason why it is left out.
    pub grippers: Vec<(String, String)>,
    /// Sentences about columns that are not used.
    pub remarks: Vec<String>,
    /// What the log shows about the time for which its torques act, as a sentence without its last full stop.
    pub held: Option<String>,
}

/// Decisions about a joint.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChosenJoint {
    /// Index of the joint in the robot, from 0.
    pub joint: usize,
    /// Lines of its block.
    pub lines: Vec<ChosenLine>,
}

impl ChosenJoint {
    pub(crate) fn line(&self, key: &str) -> Option<&ChosenLine> {
        self.lines.iter().find(|line| line.key == key)
    }
}

impl Chosen {
    /// Returns the line of `[log]` with this key.
    #[must_use]
    pub fn line(&self, key: &str) -> Option<&ChosenLine> {
        self.lines.iter().find(|line| line.key == key)
    }
}
