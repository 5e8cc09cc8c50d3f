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
    /// Dynamics as code in C99.
    C,
    /// Dynamics as code in Rust, without the standard library.
    Rust,
}

impl Format {
    /// Returns whether a file has only viscous and Coulomb friction.
    #[must_use]
    pub fn has_few_laws(self) -> bool {
        match self {
            Self::Urdf | Self::Mjcf | Self::Sdf => true,
            Self::Json | Self::C | Self::Rust => false,
        }
    }

    /// All formats.
    pub const ALL: [Self; 6] = [
        Self::Urdf,
        Self::Mjcf,
        Self::Sdf,
        Self::Json,
        Self::C,
        Self::Rust,
    ];

    /// Returns the word by which a user chooses the format.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Urdf => "urdf",
            Self::Mjcf => "mjcf",
            Self::Sdf => "sdf",
            Self::Json => "json",
            Self::C => "c",
            Self::Rust => "rust",
        }
    }

    /// Returns the format that a user chooses by a word; `None` if there is none.
    #[must_use]
    pub fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.word() == word)
    }

    /// Returns the name of the format.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Urdf => "URDF",
            Self::Mjcf => "MJCF",
            Self::Sdf => "SDF",
            Self::Json => "JSON",
            Self::C => "C",
            Self::Rust => "Rust",
        }
    }

    /// Returns the names of the exported files.
    #[must_use]
    pub const fn files(self) -> &'static [&'static str] {
        match self {
            Self::Urdf => &["robot.urdf"],
            Self::Mjcf => &["robot.xml"],
            Self::Sdf => &["robot.sdf"],
            Self::Json => &["robot.json"],
            Self::C => &["robot.h", "robot.c", "robot_test.c"],
            Self::Rust => &["robot.rs"],
        }
    }

    /// Returns whether the format is code.
    #[must_use]
    pub const fn is_code(self) -> bool {
        matches!(self, Self::C | Self::Rust)
    }
}
