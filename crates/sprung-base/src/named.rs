//! Named values in a fixed order, base joint first; the nearest of known names.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::{MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Longest words that are compared, in bytes; the time grows with the product of both lengths.
const MAX_COMPARED_BYTES: usize = 256;

/// Returns the number of edits that turn one word into another; the largest number if one of them is absurdly long.
#[must_use]
pub fn edits(word: &str, other: &str) -> usize {
    if word.len().max(other.len()) > MAX_COMPARED_BYTES {
        return usize::MAX;
    }
    strsim::damerau_levenshtein(word, other)
}

/// Returns the word of `available` nearest to `word`, if its edit distance is small.
#[must_use]
pub fn nearest<'a>(word: &str, available: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    available
        .into_iter()
        .map(|candidate| (edits(word, candidate), candidate))
        .filter(|&(distance, candidate)| {
            distance <= 1 + candidate.len() / 3 || candidate.starts_with(word)
        })
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, candidate)| candidate)
}

/// A short list of named values. In files it is a map, in the order of the robot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Named(Vec<(String, f64)>);

impl Named {
    /// Returns the value with this name.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<f64> {
        self.iter()
            .find(|(known, _)| *known == name)
            .map(|(_, value)| value)
    }

    /// Returns whether the list is empty.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns names and values in their order.
    pub fn iter(&self) -> impl Iterator<Item = (&str, f64)> {
        self.0.iter().map(|(name, value)| (name.as_str(), *value))
    }
}

impl FromIterator<(String, f64)> for Named {
    fn from_iter<I: IntoIterator<Item = (String, f64)>>(items: I) -> Self {
        Self(items.into_iter().collect())
    }
}

impl JsonSchema for Named {
    fn schema_name() -> Cow<'static, str> {
        "Named".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        BTreeMap::<String, f64>::json_schema(generator)
    }
}

impl Serialize for Named {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, value) in &self.0 {
            map.serialize_entry(name, value)?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for Named {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Pairs;
        impl<'de> Visitor<'de> for Pairs {
            type Value = Named;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a map from names to numbers")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Named, A::Error> {
                let mut pairs = Vec::new();
                while let Some(pair) = map.next_entry()? {
                    pairs.push(pair);
                }
                Ok(Named(pairs))
            }
        }
        deserializer.deserialize_map(Pairs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_keep_the_order() {
        let named: Named = [("shoulder", 1.5), ("elbow", -2.0), ("a10", 0.25)]
            .into_iter()
            .map(|(name, value)| (name.to_owned(), value))
            .collect();
        let text = serde_json::to_string(&named).unwrap();
        assert_eq!(text, r#"{"shoulder":1.5,"elbow":-2.0,"a10":0.25}"#);
        assert_eq!(serde_json::from_str::<Named>(&text).unwrap(), named);
        assert_eq!(named.get("elbow"), Some(-2.0));
        assert_eq!(named.get("wrist"), None);
    }
}
