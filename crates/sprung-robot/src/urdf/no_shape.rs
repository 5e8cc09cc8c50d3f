//! Why the shape of a link is not known.

use sprung_core::spatial::Vector;

use super::error::UrdfError;
use crate::numbers::Shown;

/// Largest number of bytes of a mesh: 1.3 million triangles.
pub(crate) const LARGEST_MESH: u64 = crate::input_limits::MESH_BYTES as u64;

/// Why the shape of a link is not known.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NoShape {
    /// The robot is a table, which has no geometry.
    #[error("a Denavit-Hartenberg table has no geometry")]
    Table,
    /// The file gives none.
    #[error("{link} has no <collision> or <visual>")]
    Absent {
        /// Name of the link.
        link: String,
    },
    /// An element of the file is wrong.
    #[error("{0}")]
    Element(UrdfError),
    /// The mesh has another format.
    #[error("the mesh {file} of {link} is no STL")]
    Format {
        /// Name of the link.
        link: String,
        /// File of the mesh as the URDF names it.
        file: String,
    },
    /// The mesh cannot be read.
    #[error("the mesh {file} of {link} cannot be read: {reason}")]
    Unreadable {
        /// Name of the link.
        link: String,
        /// File of the mesh as the URDF names it.
        file: String,
        /// Error of the operating system.
        reason: String,
    },
    /// The mesh is too large.
    #[error("the mesh {file} of {link} has more than {} MiB", LARGEST_MESH >> 20)]
    TooLarge {
        /// Name of the link.
        link: String,
        /// File of the mesh as the URDF names it.
        file: String,
    },
    /// The mesh is damaged.
    #[error("the mesh {file} of {link} is broken: {reason}")]
    Broken {
        /// Name of the link.
        link: String,
        /// File of the mesh as the URDF names it.
        file: String,
        /// What is wrong.
        reason: String,
    },
    /// The geometry is far larger than the robot.
    #[error("the {what} of {link} is {length:.0} m long: its unit is probably the millimetre")]
    Unit {
        /// Name of the link.
        link: String,
        /// The mesh with its file, or another form.
        what: String,
        /// Its length, m.
        length: f64,
        /// The scale that makes metres of millimetres; `None` for a form without a scale.
        scale: Option<Vector>,
    },
    /// The geometry is far from the joint.
    #[error("the geometry of {link} is {distance:.0} m away from its joint")]
    Far {
        /// Name of the link that the joint moves.
        link: String,
        /// Its largest distance, m.
        distance: f64,
    },
}

impl NoShape {
    /// Returns whether a length is so large that its unit is probably another.
    #[must_use]
    pub fn is_of_another_unit(&self) -> bool {
        matches!(self, Self::Unit { .. } | Self::Far { .. })
    }

    /// Returns what to do.
    #[must_use]
    pub fn remedy(&self) -> String {
        match self {
            Self::Table => "describe the robot by a URDF".to_owned(),
            Self::Absent { .. } => {
                "add a <collision>, such as a box about the link".to_owned()
            }
            Self::Element(_) => "correct the element".to_owned(),
            Self::Format { .. } => "convert the mesh to STL, or add a <collision> in STL".to_owned(),
            Self::Unreadable { .. } => {
                "give the path of the mesh relative to the URDF, or as package://NAME/path with the folder NAME \
                 beside or above the URDF"
                    .to_owned()
            }
            Self::TooLarge { .. } => "reduce the mesh, or add a <collision> with a box".to_owned(),
            Self::Broken { .. } => "export the mesh again as STL".to_owned(),
            Self::Unit {
                scale: Some([x, y, z]),
                ..
            } => format!("write scale=\"{} {} {}\" in its <mesh>", Shown(*x), Shown(*y), Shown(*z)),
            Self::Far { .. } => "write the <origin> of the geometry in metres".to_owned(),
            Self::Unit { scale: None, .. } => "write its lengths in metres".to_owned(),
        }
    }
}
