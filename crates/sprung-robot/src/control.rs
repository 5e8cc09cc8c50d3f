//! `[control]`: the controller that `sprung control` designs.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::known_words::choose;
use super::payload::Payload;

/// The controller that `sprung control` designs.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Control {
    /// The feedback that is designed.
    pub feedback: Feedback,
    /// Bandwidth of each joint, Hz: one number for all joints or one per joint; the largest that keeps the margins if absent.
    #[schemars(with = "Option<Vec<f64>>")]
    pub bandwidth_hz: Vec<f64>,
    /// Damping ratio of the motion of each joint; `state-feedback` needs at least 0.71.
    pub damping: f64,
    /// Period of the controller, s; if absent, `controller_period_s` of `[log]`, or the period of the log if that is longer.
    pub period_s: Option<f64>,
    /// Windows `p1`, `p2` of the velocity estimator, samples; those of `[controller]`, or [4, 4], if absent.
    pub velocity_window: Option<[usize; 2]>,
    /// Least gain margin of each motor's loop, dB.
    pub gain_margin_db: f64,
    /// Least phase margin of each motor's loop, degrees.
    pub phase_margin_deg: f64,
    /// Velocity within which the compensation of friction changes its direction, rad/s (m/s); chosen by the motion if
    /// absent, 0 without compensation.
    pub friction_compensation_speed_rad_per_s: Option<f64>,
    /// Number of vibrations that the input shaper removes, from the lowest; if absent, 2 for a declared controller
    /// without feedforward, else 0.
    pub shaper_modes: Option<usize>,
    /// Number of robots that are drawn from the posterior.
    pub draws: usize,
    /// Number of these robots on which the loop is simulated.
    pub simulations: usize,
    /// Seed of the draws and of the twin.
    pub seed: u64,
    /// Number of poses of the workspace, within `position_rad` of the joints' limits.
    pub poses: usize,
    /// CSV file of link positions with one column per joint, named as the joint: its poses replace those of the workspace.
    /// Relative to the experiment file; rad (m).
    pub path: Option<PathBuf>,
    /// A body that the last link carries.
    pub payload: Option<Payload>,
}

impl Default for Control {
    fn default() -> Self {
        Self {
            feedback: Feedback::default(),
            bandwidth_hz: Vec::new(),
            damping: 1.0,
            period_s: None,
            velocity_window: None,
            gain_margin_db: 6.0,
            phase_margin_deg: 40.0,
            friction_compensation_speed_rad_per_s: None,
            shaper_modes: None,
            draws: 100,
            simulations: 10,
            seed: 1,
            poses: 20,
            path: None,
            payload: None,
        }
    }
}

/// The feedback that is designed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(try_from = "String", into = "String")]
#[schemars(extend("enum" = ["state-feedback", "pd", "link-damping", "declared"]))]
pub enum Feedback {
    /// Feedback of the whole state, Eq. (33).
    #[default]
    StateFeedback,
    /// Feedback of positions and velocities of the motors.
    Pd,
    /// Feedback of the motors that also damps the links and keeps the structure of the springs.
    LinkDamping,
    /// That of `[controller]`, whose margins and vibrations are computed.
    Declared,
}

const FEEDBACKS: [(&str, Feedback); 4] = [
    ("state-feedback", Feedback::StateFeedback),
    ("pd", Feedback::Pd),
    ("link-damping", Feedback::LinkDamping),
    ("declared", Feedback::Declared),
];

impl Feedback {
    /// Returns its word in an experiment file.
    #[must_use]
    pub fn word(self) -> &'static str {
        let mut all = FEEDBACKS.iter();
        all.find(|(_, variant)| *variant == self)
            .map_or("", |(word, _)| *word)
    }
}

impl From<Feedback> for String {
    fn from(feedback: Feedback) -> Self {
        feedback.word().to_owned()
    }
}

impl TryFrom<String> for Feedback {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let index = choose("feedback", &word, &FEEDBACKS.map(|(word, _)| word))?;
        Ok(FEEDBACKS[index].1)
    }
}
