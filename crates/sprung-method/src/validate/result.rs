//! The contents of `validation.json`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::changes::change_in_words;
use super::proof::JointProof;
use crate::finding::Finding;
use crate::named::Named;

/// Results of a validation; format 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Validation {
    /// Version of the file format; 1.
    pub format: u32,
    /// Program and version that wrote the file.
    pub generator: String,
    /// Name of the robot.
    pub robot: String,
    /// One entry per validation experiment.
    pub runs: Vec<RunResult>,
}

/// One experiment and all parameter sets on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "ValidationRun")]
pub struct RunResult {
    /// Name of the experiment.
    pub name: String,
    /// Log file.
    pub log: String,
    /// Whether the parameters come from this log, which is then no proof.
    #[serde(default)]
    pub same_log: bool,
    /// Number of samples.
    pub samples: u64,
    /// Cut-off of the position filter for the filtered torque, Hz: that of the identification if
    /// `position_cutoff_hz` is `"auto"`.
    #[serde(default)]
    pub position_cutoff_hz: Option<f64>,
    /// Whether the closed loop was simulated, which needs a controller.
    pub simulated: bool,
    /// Findings about the log.
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

/// Outcome of simulating a closed loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// The simulation ran to the end of the log, or to its first gap.
    Simulated,
    /// The simulated loop ran away.
    RanAway,
    /// The loop cannot be simulated with these parameters.
    NotSimulable,
    /// The experiment has no controller.
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "ValidatedSet")]
pub struct SetResult {
    /// Origin of the parameters.
    pub parameters: String,
    /// Changes of the parameters that make the loop stable, if there are any.
    pub modified: Option<String>,
    /// Outcome of simulating the closed loop.
    pub outcome: Outcome,
    /// Errors of the simulated closed loop; absent unless it was simulated.
    pub e_rms: Option<RootMeanSquares>,
    /// Prediction errors of each joint and the promised ones; empty if a value of the set is missing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub predictions: Vec<JointProof>,
    /// Whether no error exceeds 1.5 times the promised one; absent without a promise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub promise_kept: Option<bool>,
    /// Residual of the filtered motor torque along the measured motion, root mean square, N·m (N),
    /// by joint.
    pub torque_residual_nm: Named,
    /// Residual over torque, root mean squares, by joint.
    pub torque_relative_residual: Named,
    /// Findings about this parameter set.
    pub findings: Vec<Finding>,
}

impl SetResult {
    /// Returns the code of the finding about the change that explains a broken promise, if there is
    /// one.
    #[must_use]
    pub fn change_code(&self) -> Option<&str> {
        let mut codes = self.findings.iter().map(|finding| finding.code.as_str());
        codes.find(|code| change_in_words(code).is_some())
    }
}

/// Root mean squares of measured minus simulated signals, by joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "LoopErrors")]
pub struct RootMeanSquares {
    /// Motor torque, N·m.
    pub tau_nm: Named,
    /// Link position, rad.
    pub q_rad: Named,
    /// Motor position, rad.
    pub phi_rad: Named,
}
