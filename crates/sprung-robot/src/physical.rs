//! `[identify.physical]`: possible bodies.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use super::known_words::choose;

/// How sprung finds inertial parameters of single links that bodies can have.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Physical {
    /// Values that decide where the log does not: `"nominal"` (the default), those of the URDF or of
    /// `nominal`; or `"none"`.
    pub prior: Prior,
    /// Distance from the nominal bodies: `"entropic"` (the default), which does not depend on units
    /// and frames, or `"euclidean"`.
    pub distance: Distance,
    /// Relative standard error of the nominal values.
    pub prior_error: f64,
    /// Least and largest mass of all moving links together, kg.
    pub total_mass_kg: Option<[f64; 2]>,
    /// Least and largest mass of single links by the name of the link, kg.
    pub mass_kg: BTreeMap<String, [f64; 2]>,
}

impl Default for Physical {
    fn default() -> Self {
        Self {
            prior: Prior::Nominal,
            distance: Distance::Entropic,
            prior_error: 0.3,
            total_mass_kg: None,
            mass_kg: BTreeMap::new(),
        }
    }
}

/// Values that decide where the log does not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(extend("enum" = ["nominal", "none"]))]
pub enum Prior {
    /// The nominal values.
    Nominal,
    /// No values.
    None,
}

impl TryFrom<String> for Prior {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let index = choose("prior", &word, &["nominal", "none"])?;
        Ok([Self::Nominal, Self::None][index])
    }
}

/// Distance between bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(extend("enum" = ["entropic", "euclidean"]))]
pub enum Distance {
    /// Divergence of the second moments, `tr(J J₀⁻¹) − log det(J J₀⁻¹) − 4`.
    Entropic,
    /// Squared differences of the parameters, relative to the size of the nominal body.
    Euclidean,
}

impl TryFrom<String> for Distance {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let index = choose("distance", &word, &["entropic", "euclidean"])?;
        Ok([Self::Entropic, Self::Euclidean][index])
    }
}
