//! The formats of an export.

/// Format of an exported robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Unified Robot Description Format, of ROS.
    Urdf,
    /// Format of MuJoCo.
    Mjcf,
    /// Simulation Description Format, of Drake and Gazebo.
    Sdf,
    /// Parameters of links and actuators in JSON.
    Json,
}

impl Format {
    /// Returns the name of the format.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Urdf => "URDF",
            Self::Mjcf => "MJCF",
            Self::Sdf => "SDF",
            Self::Json => "JSON",
        }
    }

    /// Returns the name of the exported file.
    #[must_use]
    pub const fn file(self) -> &'static str {
        match self {
            Self::Urdf => "robot.urdf",
            Self::Mjcf => "robot.xml",
            Self::Sdf => "robot.sdf",
            Self::Json => "robot.json",
        }
    }
}
