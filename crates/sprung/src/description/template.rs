//! A commented `experiment.toml` to start from.

mod write;

#[cfg(test)]
mod tests;

use sprung_core::chain::JointKind::{self, Prismatic, Revolute};

use super::check::check_name;
use super::quantities::Key;
use super::urdf::{Urdf, UrdfJoint};

pub use write::template;

/// Most rows of a table to fill in.
pub(crate) const MOST_JOINTS: usize = 32;

/// A robot that an experiment is to be written for.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    name: String,
    kinematics: Kinematics,
    joints: Vec<Joint>,
}

#[derive(Clone, Debug, PartialEq)]
enum Kinematics {
    /// Path of the URDF file, as the experiment is to name it.
    Urdf(String),
    /// A Denavit-Hartenberg table to be filled in.
    Table,
}

#[derive(Clone, Debug, PartialEq)]
struct Joint {
    name: String,
    link: String,
    kind: JointKind,
    /// How far, how fast and how strongly it moves, in words.
    limits: Option<String>,
}

/// Why no experiment can be written for a robot.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum StartError {
    /// An experiment cannot name a joint of the URDF file.
    #[error("{rule}; rename the joint in {file}")]
    JointName {
        /// Path of the URDF file.
        file: String,
        /// The name, and what names consist of.
        rule: String,
    },
    /// A table has no rows or too many.
    #[error("a table can be written for 1 to {MOST_JOINTS} joints, not for {joints}")]
    Joints {
        /// How many rows it should have.
        joints: usize,
    },
}

impl Start {
    /// Returns a robot with the joints of a URDF file that can move.
    ///
    /// - `file`: its path, relative to the experiment file or absolute.
    ///
    /// # Errors
    ///
    /// [`StartError::JointName`] if a name holds characters that names in an
    /// experiment must not hold.
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
            })
        };
        Ok(Self {
            name: urdf.name().to_owned(),
            kinematics: Kinematics::Urdf(file.to_owned()),
            joints: urdf.movable().iter().map(joint).collect::<Result<_, _>>()?,
        })
    }

    /// Returns a robot with a Denavit-Hartenberg table to be filled in.
    ///
    /// - `joints`: number of its rows, 1 to `MOST_JOINTS`.
    ///
    /// # Errors
    ///
    /// [`StartError::Joints`] for another number.
    pub fn table(joints: usize) -> Result<Self, StartError> {
        if !(1..=MOST_JOINTS).contains(&joints) {
            return Err(StartError::Joints { joints });
        }
        let joint = |i| Joint {
            name: format!("joint{i}"),
            link: format!("link{i}"),
            kind: Revolute,
            limits: None,
        };
        Ok(Self {
            name: "my robot".to_owned(),
            kinematics: Kinematics::Table,
            joints: (1..=joints).map(joint).collect(),
        })
    }

    /// Returns a key's columns as a list: those of the joints of which it speaks.
    ///
    /// - `stem`: before the number of the joint; the key's unit follows.
    fn columns(&self, key: &Key, stem: &str) -> Option<String> {
        let (_, unit) = key.name.rsplit_once('_')?;
        let own = (self.joints.iter().zip(1..))
            .filter(|(joint, _)| key.kind.is_none_or(|kind| joint.kind == kind));
        let names: Vec<String> = own.map(|(_, i)| format!("\"{stem}{i}_{unit}\"")).collect();
        (!names.is_empty()).then(|| format!("[{}]", names.join(", ")))
    }

    /// Returns a list with a number for each joint.
    fn list(&self, turning: &str, sliding: &str) -> String {
        let numbers = self.joints.iter().map(|joint| match joint.kind {
            Revolute => turning,
            Prismatic => sliding,
        });
        format!("[{}]", numbers.collect::<Vec<_>>().join(", "))
    }
}

/// Says what a joint's limits are, as far as the file knows them.
fn limits(joint: &UrdfJoint) -> Option<String> {
    let (length, force) = match joint.kind {
        Revolute => ("rad", "N·m"),
        Prismatic => ("m", "N"),
    };
    // Exporters write 0 or a huge number for what they do not know.
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
    // Adding zero takes the sign from zero.
    (value * 1e4).round() / 1e4 + 0.0
}
