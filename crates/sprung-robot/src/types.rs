//! The top-level keys of `experiment.toml`.

use schemars::JsonSchema;
use serde::Deserialize;

use super::control::Control;
use super::excite::Excite;
use super::identify::Identify;
use super::log::Log;
use super::robot::Robot;
use super::run::{Controller, Simulate, Validate};

/// The whole file.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[schemars(title = "sprung experiment")]
pub(super) struct ExperimentFile {
    /// Version of the file format: 1.
    pub(super) format: u32,
    /// The robot.
    pub(super) robot: Robot,
    /// The measured log, and the meaning of its columns.
    pub(super) log: Option<Log>,
    /// Settings of the identification.
    #[serde(default)]
    pub(super) identify: Identify,
    /// The controller that ran during the log. Without it a validation compares only the filtered
    /// torques and the deflections.
    pub(super) controller: Option<Controller>,
    /// Experiments to validate the model on.
    #[serde(default)]
    pub(super) validate: Vec<Validate>,
    /// The digital twin that `sprung simulate` runs.
    pub(super) simulate: Option<Simulate>,
    /// The experiment that `sprung excite` designs.
    #[serde(default)]
    pub(super) excite: Excite,
    /// The controller that `sprung control` designs.
    #[serde(default)]
    pub(super) control: Control,
}
