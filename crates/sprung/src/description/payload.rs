//! `payload` of a log: a body that the robot carried while the log was recorded.

use schemars::JsonSchema;
use serde::Deserialize;

/// A known body that the last link carried while a log was recorded.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
pub struct Payload {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Centre of mass in the frame of the link's joint, m.
    pub com_m: [f64; 3],
    /// Inertia about the centre of mass in the axes of the link's joint, kg·m²: xx, xy, xz, yy, yz,
    /// zz; that of a point if absent.
    pub inertia_kg_m2: Option<[f64; 6]>,
}
