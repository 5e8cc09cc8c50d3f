//! Builds the tree of joints from a URDF file or a Denavit-Hartenberg table.

use std::path::Path;

use sprung_core::chain::{ChainJoint, JointKind};

use super::check::{Fault, fault};
use super::limits::Limits;
use super::named_files::{NamedFiles, mesh};
use super::robot::{Robot, Tree};
use super::urdf::{NoShape, Urdf, UrdfError};

/// Why a robot's tree cannot be built.
#[derive(Debug)]
pub(super) enum TreeError {
    /// The experiment file is wrong.
    Fault(Fault),
    /// A file cannot be read.
    Unreadable(String),
    /// The URDF file is wrong; the message names file and line.
    Urdf(String),
}

/// Returns the tree that a robot describes; `None` for kinematics in closed form.
///
/// - `file`: the experiment file; paths in it are relative to its folder.
pub(super) fn tree(
    file: &str,
    robot: &Robot,
    files: &mut dyn NamedFiles,
) -> Result<Option<Tree>, TreeError> {
    if let Some(path) = &robot.urdf {
        return from_urdf(file, robot, path, files).map(Some);
    }
    let named = (0..robot.joint.len()).map(|i| format!("link{}", i + 1));
    let of = |joints: Vec<ChainJoint>| Tree {
        inertial: vec![None; joints.len()],
        limits: vec![Limits::default(); joints.len()],
        shapes: vec![Err(NoShape::Table); joints.len()],
        links: named.collect(),
        joints,
    };
    let kind = |prismatic: bool| {
        if prismatic {
            JointKind::Prismatic
        } else {
            JointKind::Revolute
        }
    };
    if let Some(rows) = &robot.dh_modified {
        let joints = rows.iter().enumerate().map(|(i, row)| ChainJoint {
            kind: kind(row.prismatic),
            ..ChainJoint::modified_dh(i.checked_sub(1), &row.row())
        });
        return Ok(Some(of(joints.collect())));
    }
    if let Some(rows) = &robot.dh_classic {
        let joints = rows.iter().enumerate().map(|(i, row)| {
            let parent = i.checked_sub(1);
            let before = parent.map(|p| rows[p].row());
            ChainJoint {
                kind: kind(row.prismatic),
                ..ChainJoint::classic_dh(parent, before.as_ref(), &row.row())
            }
        });
        return Ok(Some(of(joints.collect())));
    }
    Ok(None)
}

fn from_urdf(
    file: &str,
    robot: &Robot,
    path: &Path,
    files: &mut dyn NamedFiles,
) -> Result<Tree, TreeError> {
    let folder = Path::new(file).parent().unwrap_or(Path::new(""));
    let name = folder.join(path).display().to_string();
    let text = files.text(path).map_err(|error| {
        TreeError::Unreadable(format!(
            "cannot read {name}, the urdf of [robot]: {error}; its path is relative to the experiment file"
        ))
    })?;
    let urdf = Urdf::parse(&name, &text).map_err(|error| TreeError::Urdf(error.to_string()))?;
    if robot.joint.is_empty() {
        let movable: Vec<&str> = urdf.movable().iter().map(|j| j.name.as_str()).collect();
        return Err(TreeError::Fault(fault(
            &["robot"],
            format!(
                "the file names no joints; write a [[robot.joint]] block for each joint that moved, \
                 of {}",
                movable.join(", ")
            ),
        )));
    }
    let moving: Vec<&str> = robot.joint.iter().map(|j| j.name.as_str()).collect();
    let joints = urdf
        .tree(&moving)
        .map_err(|error| listed(&error, &moving))?;
    let shapes = urdf
        .shapes(&moving, &mut |name| mesh(files, path, name))
        .map_err(|error| listed(&error, &moving))?;
    Ok(Tree {
        shapes,
        limits: joints.iter().map(|joint| joint.limits).collect(),
        links: joints.iter().map(|joint| joint.link.clone()).collect(),
        inertial: joints.iter().map(|joint| joint.inertial).collect(),
        joints: joints.into_iter().map(|joint| joint.joint).collect(),
    })
}

/// Returns an error of the list of joints with its place in the experiment file; other errors are
/// unchanged.
#[expect(
    clippy::wildcard_enum_match_arm,
    reason = "the other errors have their place in the URDF"
)]
fn listed(error: &UrdfError, moving: &[&str]) -> TreeError {
    let name = match error {
        UrdfError::UnknownJoint { name, .. } | UrdfError::ListedTwice { name, .. } => name,
        UrdfError::Order { carrier, .. } => carrier,
        _ => return TreeError::Urdf(error.to_string()),
    };
    let index = moving.iter().rposition(|joint| joint == name);
    let index = index.unwrap_or_default().to_string();
    TreeError::Fault(fault(
        &["robot", "joint", &index, "name"],
        error.to_string(),
    ))
}
