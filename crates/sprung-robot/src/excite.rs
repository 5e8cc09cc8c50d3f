//! `[excite]`: the experiment that `sprung excite` designs.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::known_words::choose;

/// Most samples of a trajectory.
pub const MOST_SAMPLES: f64 = 1e7;

/// The experiment that `sprung excite` designs.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Excite {
    /// Length of the motion, s, without the approach.
    pub duration_s: f64,
    /// Period of the controller that takes the trajectory, s.
    pub period_s: f64,
    /// Lowest frequency, Hz; one period fills the duration if absent. The motion repeats as often as whole
    /// periods fit.
    pub base_frequency_hz: Option<f64>,
    /// Number of multiples of the lowest frequency; chosen by the limits if absent.
    pub harmonics: Option<usize>,
    /// Whether the motion also has a multisine about each resonance of the springs, up to 1000 times the lowest frequency.
    pub resonances: bool,
    /// Length of a second, slow motion for friction, s; none if absent. Its lowest frequency has one period of this length.
    pub slow_sweep_s: Option<f64>,
    /// What the search makes best.
    pub objective: Objective,
    /// Names of the parameters that count; all if empty.
    pub parameters: Vec<String>,
    /// Largest number of steps of each search.
    pub steps: usize,
    /// Number of searches from different random motions.
    pub starts: usize,
    /// Seed of the random motions.
    pub seed: u64,
    /// Part of each limit that stays free.
    pub margin: f64,
    /// Relative error that the nominal values may have; the motion keeps its limits for such values too.
    pub value_error: f64,
    /// Number of random robots whose values have the errors of `value_error`, or of the identification that gives them.
    pub draws: usize,
    /// Position of the joints from which the robot approaches the motion, rad (m), one per joint.
    pub start_rad: Vec<f64>,
    /// Point of the tool in the frame of the last link, m.
    pub tool_xyz_m: [f64; 3],
    /// Largest speed of the tool, m/s.
    pub tool_speed_m_per_s: Option<f64>,
    /// Height, along the direction against gravity in the frame of the base, that no origin of a link and not the
    /// tool may pass, m.
    pub floor_m: Option<f64>,
    /// `excitation.json` of the design whose motion the log records, relative to the experiment file: check and identify
    /// compare standard errors with the promised ones.
    pub promise: Option<PathBuf>,
}

impl Default for Excite {
    fn default() -> Self {
        Self {
            duration_s: 10.0,
            period_s: 1e-3,
            base_frequency_hz: None,
            harmonics: None,
            resonances: false,
            slow_sweep_s: None,
            objective: Objective::default(),
            parameters: Vec::new(),
            steps: 150,
            starts: 4,
            seed: 1,
            margin: 0.02,
            value_error: 0.0,
            draws: 4,
            start_rad: Vec::new(),
            tool_xyz_m: [0.0; 3],
            tool_speed_m_per_s: None,
            floor_m: None,
            promise: None,
        }
    }
}

/// What the design of an experiment makes best.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(try_from = "String", into = "String")]
#[schemars(extend("enum" = ["d-optimal", "standard-errors", "worst-error", "condition-number"]))]
pub enum Objective {
    /// The determinant of the information of all parameters.
    #[default]
    DOptimal,
    /// The geometric mean of the standard errors.
    StandardErrors,
    /// The largest relative standard error.
    WorstError,
    /// The condition number of the information with scaled columns.
    ConditionNumber,
}

const OBJECTIVES: [(&str, Objective); 4] = [
    ("d-optimal", Objective::DOptimal),
    ("standard-errors", Objective::StandardErrors),
    ("worst-error", Objective::WorstError),
    ("condition-number", Objective::ConditionNumber),
];

impl Objective {
    /// Returns its word in an experiment file.
    #[must_use]
    pub fn word(self) -> &'static str {
        let mut all = OBJECTIVES.iter();
        all.find(|(_, variant)| *variant == self)
            .map_or("", |(word, _)| *word)
    }
}

impl From<Objective> for String {
    fn from(objective: Objective) -> Self {
        objective.word().to_owned()
    }
}

impl TryFrom<String> for Objective {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let index = choose("objective", &word, &OBJECTIVES.map(|(word, _)| word))?;
        Ok(OBJECTIVES[index].1)
    }
}
