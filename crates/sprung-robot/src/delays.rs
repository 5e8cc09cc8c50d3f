//! `delay_s` of a log: delays by column, or all to be estimated.

use std::collections::BTreeMap;
use std::ops::{Deref, DerefMut};

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::factor::Delay;
use super::known_words::choose;

/// The delays of the columns of a log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DelaysOfLog {
    /// By column.
    by_column: BTreeMap<String, Delay>,
    /// Whether all other delays against the motor positions are to be estimated.
    estimates_all: bool,
}

impl DelaysOfLog {
    pub(super) fn new(by_column: BTreeMap<String, Delay>, estimates_all: bool) -> Self {
        Self {
            by_column,
            estimates_all,
        }
    }

    /// Returns whether the delays of all columns without one are to be estimated.
    #[must_use]
    pub fn estimates_all(&self) -> bool {
        self.estimates_all
    }

    /// Returns the delay of a column.
    ///
    /// - `names`: under which the delay of the column may be given, the most special one first.
    /// - `may_be_open`: whether `"estimate"` for all columns opens this one.
    #[must_use]
    pub fn of(&self, names: [&String; 2], may_be_open: bool) -> Option<Delay> {
        let is_open = self.estimates_all && may_be_open;
        let mut given = names
            .into_iter()
            .filter_map(|name| self.by_column.get(name));
        given.next().copied().or(is_open.then_some(Delay::Estimate))
    }
}

impl Deref for DelaysOfLog {
    type Target = BTreeMap<String, Delay>;

    fn deref(&self) -> &Self::Target {
        &self.by_column
    }
}

impl DerefMut for DelaysOfLog {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.by_column
    }
}

impl<'de> Deserialize<'de> for DelaysOfLog {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct OfLog;
        impl<'de> Visitor<'de> for OfLog {
            type Value = DelaysOfLog;

            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str(
                    "delays by column, such as { q1 = 0.002 }, or \"estimate\" for all columns",
                )
            }

            fn visit_str<E: Error>(self, word: &str) -> Result<DelaysOfLog, E> {
                choose("delay", word, &["estimate"]).map_err(E::custom)?;
                Ok(DelaysOfLog::new(BTreeMap::new(), true))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<DelaysOfLog, A::Error> {
                let by_column = BTreeMap::deserialize(MapAccessDeserializer::new(map))?;
                Ok(DelaysOfLog::new(by_column, false))
            }
        }
        deserializer.deserialize_any(OfLog)
    }
}

impl JsonSchema for DelaysOfLog {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "DelaysOfLog".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let delay = generator.subschema_for::<Delay>();
        schemars::json_schema!({
            "anyOf": [{ "type": "object", "additionalProperties": delay }, { "const": "estimate" }],
        })
    }
}
