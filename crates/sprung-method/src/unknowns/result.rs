//! The list of what was found, as files contain it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What sprung did with an unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum UnknownStatus {
    /// The experiment file gives it.
    Given,
    /// The experiment file asks for it, and it was estimated.
    Estimated,
    /// The log shows it, and all results use it.
    Applied,
    /// The log shows it, and the results do not use it.
    Found,
}

impl UnknownStatus {
    /// Returns the word for tables.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Given => "given",
            Self::Estimated => "estimated",
            Self::Applied => "applied",
            Self::Found => "found",
        }
    }
}

/// An unknown that may stand for another one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CompetingUnknown {
    /// Its name.
    pub id: String,
    /// Correlation of both effects beyond those of parameters and other unknowns.
    pub correlation: f64,
}

/// An unknown of a log: what differs from the description by a size that the log shows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "Unknown")]
pub struct UnknownResult {
    /// Stable name, as in `delay q1_rad`.
    pub id: String,
    /// Kind: `delay`, `timing`, `offset`, `gain`, `drift`, `lost-counts`, `eccentricity`,
    /// `saturation`, `sharpness`, `time-scale`, `torque-ripple`, `transmission-error`, `warm-up` or `law`.
    pub kind: String,
    /// Column, or joint of a law or a sharpness; the columns of one signal of all joints are separated by commas.
    pub place: String,
    /// Size, in `unit`: the time by which a delayed column is late; otherwise what a correction adds to the column, for a
    /// gain relative to it.
    pub value: f64,
    /// Standard error, in `unit`.
    pub standard_error: f64,
    /// Unit; empty for ratios.
    pub unit: String,
    /// Time at which it begins, s; absent if it acts during the whole log.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub begins_s: Option<f64>,
    /// Law that it adds to the joint of its place; absent for other kinds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub law: Option<AddedLaw>,
    /// What sprung did with it.
    pub status: UnknownStatus,
    /// Other unknowns that explain the log nearly as well.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub competing: Vec<CompetingUnknown>,
    /// Fall of the squared error of the torques on held-out parts of the log, relative to it; of an unknown that only the
    /// refinement shows, of its squared innovations.
    pub effect: f64,
}

/// A law of a joint beyond those of its description.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AddedLaw {
    /// The key that it concerns: `link_friction`, `motor_friction`, `spring`, or words for an effect that no key describes.
    pub of: String,
    /// The law, by its name in the description; empty without a key.
    pub law: String,
    /// Velocity at which Stribeck friction has fallen to 1/e, rad/s (m/s).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stribeck_velocity: Option<f64>,
    /// Standard error of this velocity, rad/s (m/s); absent unless the likelihood gave it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stribeck_velocity_error: Option<f64>,
    /// Half of the play of a spring, rad (m).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub play_half_width: Option<f64>,
    /// Deflection in the middle of the play, rad (m).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub play_centre: Option<f64>,
}

impl AddedLaw {
    /// Returns the law in words: `motor_friction "stribeck"` or `friction proportional to the torque`.
    #[must_use]
    pub fn words(&self) -> String {
        if self.law.is_empty() {
            self.of.clone()
        } else {
            format!("{} \"{}\"", self.of, self.law)
        }
    }
}

impl UnknownResult {
    /// Returns the law that it adds to the joint of its place, if all results use it.
    #[must_use]
    pub fn used_law(&self) -> Option<&AddedLaw> {
        let is_used = matches!(self.status, UnknownStatus::Applied | UnknownStatus::Given);
        self.law.as_ref().filter(|_| is_used)
    }
}
