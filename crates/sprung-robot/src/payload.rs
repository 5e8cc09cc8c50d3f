//! `payload` of a log: a body that the robot carried while the log was recorded.

use schemars::JsonSchema;
use serde::Deserialize;
use sprung_core::spatial::BODY;

/// A body that a link carried while a log was recorded. With a mass it is known; without one, sprung
/// estimates its ten inertial parameters from this log and a log without it.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
pub struct Payload {
    /// Name in the results; `payload` if absent. Logs with the same name carried the same body.
    pub name: Option<String>,
    /// Link that carried the body; the last link if absent.
    pub link: Option<String>,
    /// Mass, kg; if absent, sprung estimates the payload.
    pub mass_kg: Option<f64>,
    /// Centre of mass in the frame of the link's joint, m; required with a mass.
    pub com_m: Option<[f64; 3]>,
    /// Inertia about the centre of mass in the axes of the link's joint, kg·m²: xx, xy, xz, yy, yz,
    /// zz; that of a point if absent.
    pub inertia_kg_m2: Option<[f64; 6]>,
}

impl Payload {
    /// Returns the name in the results.
    #[must_use]
    pub fn name(&self) -> &str {
        self.name.as_deref().unwrap_or("payload")
    }

    /// Returns the inertial parameters about the origin of the joint's frame; `None` if they are to be
    /// estimated.
    #[must_use]
    pub fn known(&self) -> Option<[f64; BODY]> {
        let (m, [x, y, z]) = (self.mass_kg?, self.com_m?);
        let [xx, xy, xz, yy, yz, zz] = self.inertia_kg_m2.unwrap_or_default();
        Some([
            m,
            m * x,
            m * y,
            m * z,
            xx + m * (y * y + z * z),
            xy - m * x * y,
            yy + m * (x * x + z * z),
            xz - m * x * z,
            yz - m * y * z,
            zz + m * (x * x + y * y),
        ])
    }
}
