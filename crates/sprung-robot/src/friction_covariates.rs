//! Covariates of a joint's friction. Keys and explanations follow from the table of the core.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{IgnoredAny, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::{Map, Value, json};
use sprung_core::covariate::Covariate;

/// Quantities on which friction depends linearly: a friction parameter `p`, such as `"motor_viscous"`,
/// becomes `p + p_per_k (T - T_ref)`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrictionCovariates {
    parameters: [Option<Vec<String>>; Covariate::COUNT],
    references: [Option<f64>; Covariate::COUNT],
}

impl FrictionCovariates {
    /// Returns the friction parameters that depend on a covariate, and its reference.
    #[must_use]
    pub fn of(&self, covariate: Covariate) -> (&[String], Option<f64>) {
        let parameters = self.parameters[covariate as usize].as_deref();
        (
            parameters.unwrap_or_default(),
            self.references[covariate as usize],
        )
    }
}

/// Returns the covariate with a key.
pub(super) fn with_key(
    key: &str,
    key_of: impl Fn(Covariate) -> &'static str,
    has_key: impl Fn(Covariate) -> bool,
) -> Option<usize> {
    Covariate::ALL
        .into_iter()
        .position(|covariate| has_key(covariate) && key_of(covariate) == key)
}

impl<'de> Deserialize<'de> for FrictionCovariates {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Both;
        impl<'de> Visitor<'de> for Both {
            type Value = FrictionCovariates;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a table of covariates")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
                let mut read = FrictionCovariates::default();
                while let Some(key) = map.next_key::<String>()? {
                    if let Some(at) = with_key(&key, Covariate::word, |_| true) {
                        read.parameters[at] = Some(map.next_value()?);
                    } else if let Some(at) = with_key(&key, Covariate::key_of_reference, |_| true) {
                        read.references[at] = Some(map.next_value()?);
                    } else {
                        map.next_value::<IgnoredAny>()?;
                    }
                }
                Ok(read)
            }
        }
        deserializer.deserialize_map(Both)
    }
}

/// Returns the schema of a table.
pub(super) fn table(properties: Map<String, Value>) -> Schema {
    let mut schema = json_schema!({ "type": "object" });
    schema.insert("properties".to_owned(), Value::Object(properties));
    schema
}

impl JsonSchema for FrictionCovariates {
    fn schema_name() -> Cow<'static, str> {
        "FrictionCovariates".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let mut properties = Map::new();
        for covariate in Covariate::ALL {
            let (of, unit) = (covariate.of(), covariate.unit());
            let parameters = json!({
                "description": format!("Friction parameters that change with the {of}."),
                "type": "array",
                "items": { "type": "string" },
                "default": [],
            });
            let reference = json!({
                "description": format!(
                    "Value of the {of} at which the friction parameters hold, {unit}; best the mean of the log."
                ),
                "type": ["number", "null"],
                "format": "double",
            });
            properties.insert(covariate.word().to_owned(), parameters);
            properties.insert(covariate.key_of_reference().to_owned(), reference);
        }
        let mut schema = table(properties);
        schema.insert(
            "description".to_owned(),
            "Quantities on which friction depends linearly: a friction parameter `p`, such as \
             `\"motor_viscous\"`, becomes `p + p_per_k (T - T_ref)`."
                .into(),
        );
        schema
    }
}
