//! Writes a commented `experiment.toml` for a new robot.

mod decisions;
mod gripper;
mod write;

#[cfg(test)]
mod tests;

use sprung_core::chain::JointKind::{self, Prismatic, Revolute};

use super::check::check_name;
use super::quantities::Key;
use super::urdf::{Urdf, UrdfJoint};
use gripper::of_gripper;

pub use decisions::{Chosen, ChosenJoint, ChosenLine};
pub use write::quoted;
pub use write::template;

/// Largest number of rows of a Denavit-Hartenberg table.
pub(crate) const MAX_TABLE_ROWS: usize = 32;

/// A robot for which [`template`] writes an experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    name: String,
    kinematics: Kinematics,
    joints: Vec<Joint>,
    /// Joints that mimic another, and the joints that they follow.
    mimics: Vec<(String, String)>,
    /// Sentences about the file of the robot, without their last full stops.
    notes: Vec<String>,
    /// Whether a file describes its bodies.
    has_bodies: bool,
    /// Decisions about its log, if there is a log.
    chosen: Option<Chosen>,
}

/// A joint of a robot, for the search of its columns in a log.
#[derive(Clone, Debug, PartialEq)]
pub struct JointOfStart {
    /// Its name.
    pub name: String,
    /// Revolute or prismatic.
    pub kind: JointKind,
    /// Limits of its position, rad or m, if the description has them.
    pub range: Option<(f64, f64)>,
    /// Why it is taken as a joint of a gripper; `None` for a joint of the arm.
    pub gripper: Option<String>,
}

#[derive(Clone, Debug, PartialEq)]
enum Kinematics {
    /// Path of the URDF file for the experiment.
    Urdf(String),
    /// A Denavit-Hartenberg table to be filled in.
    Table,
}

#[derive(Clone, Debug, PartialEq)]
struct Joint {
    name: String,
    link: String,
    kind: JointKind,
    /// Limits of position, velocity and torque, in words.
    limits: Option<String>,
    /// Limits of its position, rad or m.
    range: Option<(f64, f64)>,
    gripper: Option<String>,
}

/// Why sprung cannot write an experiment for a robot.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum StartError {
    /// The name of a joint of the URDF file is not allowed in an experiment.
    #[error("{rule}; rename the joint in {file}")]
    JointName {
        /// Path of the URDF file.
        file: String,
        /// The name, and the characters that are allowed.
        rule: String,
    },
    /// A table would have no rows or too many rows.
    #[error("a table can be written for 1 to {MAX_TABLE_ROWS} joints, not for {joints}")]
    Joints {
        /// The requested number of rows.
        joints: usize,
    },
}

impl Start {
    /// Returns a robot with the movable joints of a URDF file.
    ///
    /// - `file`: its path, relative to the experiment file or absolute.
    ///
    /// # Errors
    ///
    /// [`StartError::JointName`] if the name of a joint contains characters that an experiment does
    /// not allow.
    pub fn urdf(urdf: &Urdf, file: &str) -> Result<Self, StartError> {
        let joint = |joint: &UrdfJoint| {
            check_name(&joint.name, &[]).map_err(|fault| StartError::JointName {
                file: file.to_owned(),
                rule: fault.message,
            })?;
            Ok(Joint {
                name: joint.name.clone(),
                link: joint.child.clone(),
                kind: joint.kind,
                limits: limits(joint),
                range: (joint.lower.zip(joint.upper)).filter(|(lower, upper)| lower < upper),
                gripper: of_gripper(joint, urdf),
            })
        };
        let mimics = urdf.mimics();
        Ok(Self {
            name: urdf.name().to_owned(),
            kinematics: Kinematics::Urdf(file.to_owned()),
            joints: urdf.movable().iter().map(joint).collect::<Result<_, _>>()?,
            mimics: mimics
                .map(|(follower, leader)| (follower.to_owned(), leader.to_owned()))
                .collect(),
            notes: (urdf.notes().iter())
                .map(|note| format!("{file}, {note}"))
                .collect(),
            has_bodies: urdf.has_bodies(),
            chosen: None,
        })
    }

    /// Returns the names of its joints.
    #[must_use]
    pub fn joint_names(&self) -> Vec<String> {
        self.joints.iter().map(|joint| joint.name.clone()).collect()
    }

    /// Returns a robot with a Denavit-Hartenberg table to be filled in.
    ///
    /// - `joints`: number of its rows, 1 to 32.
    ///
    /// # Errors
    ///
    /// [`StartError::Joints`] for another number.
    pub fn table(joints: usize) -> Result<Self, StartError> {
        if !(1..=MAX_TABLE_ROWS).contains(&joints) {
            return Err(StartError::Joints { joints });
        }
        let joint = |i| Joint {
            name: format!("joint{i}"),
            link: format!("link{i}"),
            kind: Revolute,
            limits: None,
            range: None,
            gripper: None,
        };
        Ok(Self {
            name: "my robot".to_owned(),
            kinematics: Kinematics::Table,
            joints: (1..=joints).map(joint).collect(),
            mimics: Vec::new(),
            notes: Vec::new(),
            has_bodies: false,
            chosen: None,
        })
    }

    /// Returns a robot with a Denavit-Hartenberg table to be filled in for joints with names.
    ///
    /// # Errors
    ///
    /// As of [`Start::table`], and [`StartError::JointName`] for a name with characters that an experiment does not allow.
    pub fn named(names: Vec<String>) -> Result<Self, StartError> {
        let mut start = Self::table(names.len())?;
        for (joint, name) in start.joints.iter_mut().zip(names) {
            check_name(&name, &[]).map_err(|fault| StartError::JointName {
                file: "the log".to_owned(),
                rule: fault.message,
            })?;
            joint.name = name;
        }
        Ok(start)
    }

    /// Returns its joints.
    #[must_use]
    pub fn joints(&self) -> Vec<JointOfStart> {
        let joint = |joint: &Joint| JointOfStart {
            name: joint.name.clone(),
            kind: joint.kind,
            range: joint.range,
            gripper: joint.gripper.clone(),
        };
        self.joints.iter().map(joint).collect()
    }

    /// Returns the names of the joints that mimic another.
    #[must_use]
    pub fn mimics(&self) -> Vec<String> {
        self.mimics
            .iter()
            .map(|(follower, _)| follower.clone())
            .collect()
    }

    /// Returns whether a file describes its bodies, so that the scale of torques can be told.
    #[must_use]
    pub fn has_bodies(&self) -> bool {
        self.has_bodies
    }

    /// Returns the robot with decisions about its log.
    #[must_use]
    pub fn with(&self, chosen: Chosen) -> Self {
        Self {
            chosen: Some(chosen),
            ..self.clone()
        }
    }

    /// Returns the joints for which the experiment has a block, with the decisions about them.
    fn blocks(&self) -> Vec<(&Joint, Option<&ChosenJoint>)> {
        match &self.chosen {
            None => self.joints.iter().map(|joint| (joint, None)).collect(),
            Some(chosen) => (chosen.joints.iter())
                .filter_map(|joint| Some((self.joints.get(joint.joint)?, Some(joint))))
                .collect(),
        }
    }

    /// Returns sentences about the file of the robot and about joints that mimic another, without their last full stops.
    #[must_use]
    pub fn remarks(&self) -> Vec<String> {
        let blocks = self.blocks();
        let sentence = |(follower, leader): &(String, String)| {
            if blocks.iter().any(|(joint, _)| joint.name == *leader) {
                format!(
                    "{follower} mimics {leader}, which moves. sprung holds {follower} at zero, so the values of the bodies \
                     that it carries are wrong by as much as it moves"
                )
            } else {
                format!("{follower} mimics {leader}, so both are fixed at zero")
            }
        };
        let mimics = self.mimics.iter().map(sentence);
        self.notes.iter().cloned().chain(mimics).collect()
    }

    /// Returns a list of column names for a key, one for each of its joints; `None` if it has no
    /// joints.
    ///
    /// - `stem`: the part of a name before the number of the joint; the key's unit follows.
    fn columns(&self, key: &Key, stem: &str) -> Option<String> {
        let (_, unit) = key.name.rsplit_once('_')?;
        let of_kind = (self.joints.iter().zip(1..))
            .filter(|(joint, _)| key.kind.is_none_or(|kind| joint.kind == kind));
        let names: Vec<String> = of_kind
            .map(|(_, i)| format!("\"{stem}{i}_{unit}\""))
            .collect();
        (!names.is_empty()).then(|| format!("[{}]", names.join(", ")))
    }

    /// Returns a list with a number for each joint, as TOML.
    ///
    /// - `turning`, `sliding`: the number for revolute and for prismatic joints.
    fn list(&self, turning: &str, sliding: &str) -> String {
        let blocks = self.blocks();
        let numbers = blocks.iter().map(|(joint, _)| match joint.kind {
            Revolute => turning,
            Prismatic => sliding,
        });
        format!("[{}]", numbers.collect::<Vec<_>>().join(", "))
    }
}

/// Returns a joint's limits in words; `None` if the URDF file has no limits.
fn limits(joint: &UrdfJoint) -> Option<String> {
    let (length, force) = match joint.kind {
        Revolute => ("rad", "N·m"),
        Prismatic => ("m", "N"),
    };
    // Exporters write 0 or a huge number for an unknown limit.
    let known = |limit: Option<f64>| limit.filter(|x| *x != 0.0 && x.abs() < 1e6);
    let mut parts = Vec::new();
    if let (Some(lower), Some(upper)) = (joint.lower, joint.upper)
        && lower < upper
        && upper - lower < 1e6
    {
        let [lower, upper] = [lower, upper].map(rounded);
        parts.push(format!("{lower} to {upper} {length}"));
    }
    if let Some(velocity) = known(joint.velocity) {
        parts.push(format!("{} {length}/s", rounded(velocity)));
    }
    if let Some(effort) = known(joint.effort) {
        parts.push(format!("{} {force}", rounded(effort)));
    }
    (!parts.is_empty()).then(|| parts.join(", "))
}

fn rounded(value: f64) -> f64 {
    // Adding zero turns -0 into 0.
    (value * 1e4).round() / 1e4 + 0.0
}
