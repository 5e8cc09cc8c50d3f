//! Numbers that the description gives, or that are to be estimated.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer};

use super::known_words::choose;

/// A delay: a number, or `"estimate"`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Delay {
    /// Known, s.
    Known(f64),
    /// To be estimated from the log.
    Estimate,
}

/// A sign or a gain: a number, or `"estimate"`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Factor {
    /// Known factor of a column.
    Known(f64),
    /// To be estimated from the log.
    Estimate,
}

impl Factor {
    /// Returns the factor, if it is known.
    #[must_use]
    pub fn known(self) -> Option<f64> {
        match self {
            Self::Known(value) => Some(value),
            Self::Estimate => None,
        }
    }
}

/// Reads a number; returns `None` for the word `"estimate"`.
fn number_or_estimate<'de, D: Deserializer<'de>>(
    deserializer: D,
    what: &'static str,
    expected: &'static str,
) -> Result<Option<f64>, D::Error> {
    struct Visitor(&'static str, &'static str);
    impl serde::de::Visitor<'_> for Visitor {
        type Value = Option<f64>;

        fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
            f.write_str(self.1)
        }

        fn visit_f64<E>(self, value: f64) -> Result<Option<f64>, E> {
            Ok(Some(value))
        }

        fn visit_i64<E>(self, value: i64) -> Result<Option<f64>, E> {
            Ok(Some(value as f64))
        }

        fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<Option<f64>, E> {
            choose(self.0, word, &["estimate"])
                .map(|_| None)
                .map_err(E::custom)
        }
    }
    deserializer.deserialize_any(Visitor(what, expected))
}

impl<'de> Deserialize<'de> for Delay {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let expected = "a number of seconds or \"estimate\"";
        let number = number_or_estimate(deserializer, "delay", expected)?;
        Ok(number.map_or(Self::Estimate, Self::Known))
    }
}

impl<'de> Deserialize<'de> for Factor {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let expected = "a number or \"estimate\"";
        let number = number_or_estimate(deserializer, "value", expected)?;
        Ok(number.map_or(Self::Estimate, Self::Known))
    }
}

impl JsonSchema for Delay {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Delay".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "description": "seconds, or \"estimate\"",
            "anyOf": [{ "type": "number" }, { "const": "estimate" }],
        })
    }
}

impl JsonSchema for Factor {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Factor".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "description": "a number, or \"estimate\"",
            "anyOf": [{ "type": "number" }, { "const": "estimate" }],
        })
    }
}
