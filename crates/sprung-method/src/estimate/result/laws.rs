//! Laws by hold-out, as a part of the results.

use serde::{Deserialize, Serialize};

/// Laws that reduce the held-out residual of a log.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LawsByHoldOut {
    /// Held-out residual of the filtered torque with the laws of the description, relative to the
    /// torque: eighths of the beginning of the first log are left out in turn.
    pub held_out: f64,
    /// Changes of the laws, each on top of the changes before it.
    pub rungs: Vec<LawRung>,
    /// Reason why the ladder ends.
    pub ended: String,
}

/// A change of the laws of one joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LawRung {
    /// Name of the joint.
    pub joint: String,
    /// The key that the change concerns: `link_friction`, `motor_friction`, `spring`, or
    /// words for an effect that no key describes.
    pub of: String,
    /// The law, by its name in the description; empty without a key.
    pub law: String,
    /// Decrease of the held-out residual of the joint's rows, as a fraction.
    pub gain: f64,
    /// Standard deviation of the gain over the parts of the log.
    pub gain_scatter: f64,
    /// Held-out residual of the filtered torque with this change, relative to the torque.
    pub held_out: f64,
    /// Equivalent changes of the joint, as `motor_friction "quadratic"`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub not_told_apart_from: Vec<String>,
    /// Velocity at which the friction has fallen to 1/e, rad/s (m/s); for Stribeck friction only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stribeck_velocity: Option<f64>,
    /// Standard error of this velocity, rad/s (m/s); absent unless the likelihood gave it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stribeck_velocity_error: Option<f64>,
    /// Whether the change was made. If not, the results have the laws without it.
    pub made: bool,
    /// Whether the change is that of an earlier identification; gain and residual are those of its log.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub earlier: bool,
}

impl LawsByHoldOut {
    /// Adds the changes that earlier identifications made.
    #[must_use]
    pub fn with_earlier(mut self, earlier: &[LawRung]) -> Self {
        let earlier = earlier.iter().map(|rung| LawRung {
            earlier: true,
            ..rung.clone()
        });
        self.rungs = earlier.chain(self.rungs).collect();
        self
    }
}

impl LawRung {
    /// Returns the change in words: `motor_friction "stribeck"` or `friction proportional to the torque`.
    #[must_use]
    pub fn words(&self) -> String {
        if self.law.is_empty() {
            self.of.clone()
        } else {
            format!("{} \"{}\"", self.of, self.law)
        }
    }
}
