//! Nominal values of a joint, at most one for each kind of joint parameter of the core.

use std::borrow::Cow;
use std::collections::BTreeMap;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde_json::{Map, Value, json};
use sprung_core::chain::JointKind;
use sprung_core::parameters::JointParameter;

/// Nominal values of a joint, as given by its maker, SI units.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(transparent)]
pub struct Nominal(BTreeMap<String, f64>);

impl Nominal {
    /// Returns the given names and values, in the order of the core's parameters.
    pub fn all(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let names = kinds().map(JointParameter::name);
        names.filter_map(|name| Some((name, self.0.get(name).copied()?)))
    }

    /// Returns the value of a kind of parameter.
    #[must_use]
    pub fn get(&self, kind: JointParameter) -> Option<f64> {
        self.0.get(kind.name()).copied()
    }

    /// Removes the value of a kind of parameter.
    pub fn remove(&mut self, kind: JointParameter) {
        self.0.remove(kind.name());
    }
}

impl JsonSchema for Nominal {
    fn schema_name() -> Cow<'static, str> {
        "Nominal".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let properties: Map<String, Value> = kinds()
            .map(|kind| (kind.name().to_owned(), property(kind)))
            .collect();
        json_schema!({
            "description": "Nominal values of a joint, as given by its maker, SI units.",
            "type": "object",
            "properties": properties,
        })
    }
}

/// Returns the kinds of parameter that have nominal values; the back-EMF follows from the constants of
/// the drive, and changes with covariates and elements of curves have no usual value.
fn kinds() -> impl Iterator<Item = JointParameter> {
    (JointParameter::ALL.into_iter())
        .filter(|kind| !matches!(kind, JointParameter::BackEmf | JointParameter::Change(..)))
        .filter(|kind| !kind.is_of_curve())
}

fn property(kind: JointParameter) -> Value {
    let side = match kind {
        JointParameter::Friction(side, _) => format!(" on the {} side", side.name()),
        JointParameter::RotorInertia
        | JointParameter::Stiffness
        | JointParameter::CubicStiffness
        | JointParameter::Damping
        | JointParameter::Hysteresis(_)
        | JointParameter::Preload
        | JointParameter::Change(..)
        | JointParameter::BackEmf
        | JointParameter::TorqueOffset => String::new(),
    };
    let about = kind.about().trim().trim_end_matches('.');
    let [turning, sliding] =
        [JointKind::Revolute, JointKind::Prismatic].map(|joint| kind.unit(joint));
    json!({
        "description": format!("{about}{side}, {turning} ({sliding})."),
        "type": ["number", "null"],
        "format": "double",
    })
}
