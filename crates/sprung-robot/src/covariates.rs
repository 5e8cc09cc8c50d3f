//! Covariates of logs and twins. Keys and explanations follow from the table of the core, so a
//! covariate is one row there.

use std::borrow::Cow;
use std::marker::PhantomData;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::{DeserializeOwned, IgnoredAny, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::Map;
use sprung_core::covariate::{Covariate, Source};

use super::columns::Columns;
use super::friction_covariates::{table, with_key};

/// Columns of the covariates in a log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CovariateColumns(PerCovariate<Columns>);

/// Covariates of a twin at the start and at the end, common to all joints.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drifts(PerCovariate<[f64; 2]>);

type PerCovariate<T> = [Option<T>; Covariate::COUNT];

impl CovariateColumns {
    /// Returns the columns of a covariate.
    #[must_use]
    pub const fn of(&self, covariate: Covariate) -> Option<&Columns> {
        self.0[covariate as usize].as_ref()
    }

    /// Returns the columns of a covariate, mutable.
    pub const fn of_mut(&mut self, covariate: Covariate) -> &mut Option<Columns> {
        &mut self.0[covariate as usize]
    }
}

impl Drifts {
    /// Returns the values of a covariate at the start and at the end.
    #[must_use]
    pub fn of(&self, covariate: Covariate) -> Option<[f64; 2]> {
        self.0[covariate as usize]
    }

    /// Returns whether all joints of a twin have the same values of a covariate, under its own key.
    #[must_use]
    pub fn has_key(covariate: Covariate) -> bool {
        // Joints have temperatures of their own: `temperature_start_c` and `temperature_end_c`.
        is_in_columns(covariate) && covariate != Covariate::Temperature
    }
}

fn is_in_columns(covariate: Covariate) -> bool {
    covariate.source() == Source::Columns
}

/// Reads the values under the keys of covariates, and leaves out all other keys.
struct Reader<T>(fn(Covariate) -> bool, PhantomData<T>);

impl<'de, T: DeserializeOwned> Visitor<'de> for Reader<T> {
    type Value = PerCovariate<T>;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("a table")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let mut values = std::array::from_fn(|_| None);
        while let Some(key) = map.next_key::<String>()? {
            match with_key(&key, Covariate::key, self.0) {
                Some(at) => {
                    let value = map.next_value::<T>();
                    values[at] =
                        Some(value.map_err(|error| {
                            serde::de::Error::custom(format!("{key}: {error}"))
                        })?);
                }
                None => drop(map.next_value::<IgnoredAny>()?),
            }
        }
        Ok(values)
    }
}

impl<'de> Deserialize<'de> for CovariateColumns {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let reader = Reader(is_in_columns, PhantomData);
        Ok(Self(deserializer.deserialize_map(reader)?))
    }
}

impl<'de> Deserialize<'de> for Drifts {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let reader = Reader(Self::has_key, PhantomData);
        Ok(Self(deserializer.deserialize_map(reader)?))
    }
}

impl JsonSchema for CovariateColumns {
    fn schema_name() -> Cow<'static, str> {
        "CovariateColumns".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut properties = Map::new();
        for covariate in Covariate::ALL.into_iter().filter(|one| is_in_columns(*one)) {
            let mut columns = generator.subschema_for::<Option<Columns>>();
            let text = format!(
                "Column of the {}, {}, for all joints whose friction depends on it, or one each.",
                covariate.of(),
                covariate.unit()
            );
            columns.insert("description".to_owned(), text.into());
            properties.insert(covariate.key().to_owned(), columns.to_value());
        }
        table(properties)
    }
}

impl JsonSchema for Drifts {
    fn schema_name() -> Cow<'static, str> {
        "Drifts".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut properties = Map::new();
        for covariate in Covariate::ALL.into_iter().filter(|one| Self::has_key(*one)) {
            let mut ends = generator.subschema_for::<Option<[f64; 2]>>();
            let text = format!(
                "The {} at the start and at the end, {}; `{}` if absent.",
                covariate.of(),
                covariate.unit(),
                covariate.key_of_reference()
            );
            ends.insert("description".to_owned(), text.into());
            properties.insert(covariate.key().to_owned(), ends.to_value());
        }
        table(properties)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FrictionCovariates, Log, Simulate};

    #[test]
    fn every_covariate_has_its_keys_in_all_tables() {
        for covariate in Covariate::ALL {
            let (word, reference) = (covariate.word(), covariate.key_of_reference());
            let text = format!("{word} = [\"motor_coulomb\"]\n{reference} = 2.5");
            let friction: FrictionCovariates = toml::from_str(&text).unwrap();
            assert_eq!(friction.of(covariate).0, ["motor_coulomb"]);
            assert_eq!(friction.of(covariate).1, Some(2.5));
            let key = covariate.key();
            if is_in_columns(covariate) {
                let log: Log = toml::from_str(&format!("{key} = [\"one\", \"two\"]")).unwrap();
                let columns = log.covariates.of(covariate).unwrap();
                assert_eq!(columns.0.len(), 2);
            }
            if Drifts::has_key(covariate) {
                let twin: Simulate = toml::from_str(&format!("{key} = [1, 2]")).unwrap();
                assert_eq!(twin.drifts.of(covariate), Some([1.0, 2.0]));
            }
        }
    }

    #[test]
    fn a_wrong_value_names_its_key() {
        let error = toml::from_str::<Simulate>("cycles = 3").unwrap_err();
        assert!(error.to_string().contains("cycles: "), "{error}");
    }
}
