//! The contents of `validation.json`.

use serde::{Deserialize, Serialize};

use crate::finding::Finding;
use crate::named::Named;

/// Everything that a validation found; format 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Validation {
    /// Version of the file format; 1.
    pub format: u32,
    /// Program and version that wrote it.
    pub generator: String,
    /// Name of the robot.
    pub robot: String,
    /// One entry per validation experiment.
    pub runs: Vec<RunResult>,
}

/// One experiment and all parameter sets on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunResult {
    /// Name of the experiment.
    pub name: String,
    /// Log file.
    pub log: String,
    /// Number of samples.
    pub samples: u64,
    /// Whether a controller was known, so that the closed loop was simulated.
    pub simulated: bool,
    /// What was noticed about the log.
    #[serde(default)]
    pub findings: Vec<Finding>,
    /// One entry per parameter set.
    pub sets: Vec<SetResult>,
}

impl RunResult {
    /// Returns the names of the joints, base first.
    #[must_use]
    pub fn joints(&self) -> Vec<&str> {
        (self.sets.iter())
            .map(|set| {
                set.torque_residual_nm
                    .iter()
                    .map(|(name, _)| name)
                    .collect()
            })
            .max_by_key(Vec::len)
            .unwrap_or_default()
    }
}

/// What became of a simulated closed loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// It ran to the end of the log.
    Simulated,
    /// It ran away.
    RanAway,
    /// It could not be simulated with these parameters.
    NotSimulable,
    /// No controller was given.
    NoController,
}

impl Outcome {
    /// Returns the outcome as words for a table.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Simulated => "simulated",
            Self::RanAway => "runs away",
            Self::NotSimulable => "impossible",
            Self::NoController => "–",
        }
    }
}

/// One parameter set on one experiment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SetResult {
    /// Where the parameters come from.
    pub parameters: String,
    /// What was changed to make the loop stable, if anything.
    pub modified: Option<String>,
    /// What became of the simulated closed loop.
    pub outcome: Outcome,
    /// Errors of the simulated closed loop; only if it ran to the end.
    pub e_rms: Option<RootMeanSquares>,
    /// Residual of the filtered motor torque along the measured motion, root
    /// mean square, N·m, by joint.
    pub torque_residual_nm: Named,
    /// The same over the torque.
    pub torque_relative_residual: Named,
    /// What to know about these numbers.
    pub findings: Vec<Finding>,
}

/// Root mean squares of measured minus simulated, by joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RootMeanSquares {
    /// Motor torque, N·m.
    pub tau_nm: Named,
    /// Link position, rad.
    pub q_rad: Named,
    /// Motor position, rad.
    pub phi_rad: Named,
}
