//! Changes of the model and the timing by an identification, as a part of the results.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A change beyond the description, which the log requires.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Applied {
    /// Kind of change: `samples` (corrected ones), `timing` (of the torques), `sharpness` (of Coulomb friction) or
    /// `law`.
    pub kind: String,
    /// The change with its size, as a part of a sentence.
    pub what: String,
    /// Held-out error of the filtered torque without and with the change, relative to the torque; absent if it was not
    /// compared.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held_out: Option<[f64; 2]>,
    /// Setting that forbids the change.
    pub forbidden_by: String,
}

impl Applied {
    /// Returns the change, its gain and the setting that forbids it.
    #[must_use]
    pub fn sentence(&self) -> String {
        let gain = self.held_out.map_or_else(String::new, |[without, with]| {
            format!(
                "; held-out error {:.2} → {:.2} %",
                100.0 * without,
                100.0 * with
            )
        });
        format!("{}{gain} (forbidden by {})", self.what, self.forbidden_by)
    }
}
