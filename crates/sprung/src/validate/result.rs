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

/// One parameter set on one experiment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SetResult {
    /// Where the parameters come from.
    pub parameters: String,
    /// What was changed to make the loop stable, if anything.
    pub modified: Option<String>,
    /// Errors of the simulated closed loop; absent if none was simulated or
    /// the loop ran away.
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
