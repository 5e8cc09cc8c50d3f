//! A payload in the form of the files.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::named::Named;

/// Inertial parameters of a payload.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "Payload")]
pub struct PayloadResult {
    /// Name of the payload.
    pub name: String,
    /// The link that carried it.
    pub link: String,
    /// Estimator of the parameters of the robot.
    pub estimator: String,
    /// Logs with the payload.
    pub logs: Vec<String>,
    /// Mass, first moments and inertia about the origin of the link's joint, in the axes of this joint.
    pub parameters: Vec<PayloadParameter>,
    /// Centre of mass in the frame of the link's joint with its standard error, m; absent where the logs
    /// do not determine it.
    pub centre_of_mass_m: [Option<(f64, f64)>; 3],
    /// Residual of each row of the loaded logs, N·m.
    pub residual_rms: Named,
}

impl PayloadResult {
    /// Returns mass and centre of mass in a sentence.
    #[must_use]
    pub fn summary(&self) -> String {
        let mass = self
            .parameters
            .first()
            .and_then(|parameter| parameter.value.zip(parameter.standard_error));
        let mass = mass.map_or_else(
            || "mass not determined".to_owned(),
            |(value, error)| format!("{value:.3} ± {error:.3} kg"),
        );
        let centre = self.centre_of_mass_m.map(|centre| match centre {
            Some((value, error)) => format!("{:.1} ± {:.1}", 1e3 * value, 1e3 * error),
            None => "-".to_owned(),
        });
        format!(
            "{} at {}: {mass}, centre of mass ({}) mm in the frame of the link's joint, from {}",
            self.name,
            self.link,
            centre.join(", "),
            self.logs.join(", ")
        )
    }
}

/// One inertial parameter of a payload.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PayloadParameter {
    /// Name, as in `gripper.izz`.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Estimate; absent if the logs do not determine it.
    pub value: Option<f64>,
    /// Standard error by the loaded logs and by the errors of the robot's parameters.
    pub standard_error: Option<f64>,
    /// 95 % confidence interval.
    pub ci95: Option<[f64; 2]>,
    /// Value of the nearest body that can exist; absent if none was found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub physical: Option<f64>,
}
