//! Finds keys that the schema does not contain, with their place in the file.

use std::ops::Range;
use std::sync::LazyLock;

use serde_json::Value;
use toml::de::{DeTable, DeValue};

use super::choice::nearest;
use super::types::ExperimentFile;

/// A message and its place in the file.
pub(super) struct Misfit {
    /// Bytes of the text, if known.
    pub(super) span: Option<Range<usize>>,
    /// The fault and the remedy.
    pub(super) message: String,
}

/// Checks that every key is one of the schema's.
pub(super) fn check(table: &DeTable<'_>) -> Result<(), Misfit> {
    static SCHEMA: LazyLock<Value> = LazyLock::new(|| {
        schemars::generate::SchemaSettings::default()
            .with(|settings| settings.inline_subschemas = true)
            .into_generator()
            .into_root_schema_for::<ExperimentFile>()
            .to_value()
    });
    walk(table, &SCHEMA, "")
}

fn walk(table: &DeTable<'_>, schema: &Value, place: &str) -> Result<(), Misfit> {
    let Some(properties) = branch(schema, "properties").and_then(Value::as_object) else {
        return Ok(());
    };
    for (key, value) in table {
        let name = key.get_ref().as_ref();
        let Some(schema) = properties.get(name) else {
            let place = if place.is_empty() {
                "the file".to_owned()
            } else {
                format!("[{place}]")
            };
            let known: Vec<&str> = properties.keys().map(String::as_str).collect();
            let hint = nearest(name, known.iter().copied()).map_or_else(
                || format!("known keys are {}", known.join(", ")),
                |one| format!("did you mean \"{one}\"?"),
            );
            return Err(Misfit {
                span: Some(key.span()),
                message: format!("unknown key \"{name}\" in {place}; {hint}"),
            });
        };
        let place = if place.is_empty() {
            name.to_owned()
        } else {
            format!("{place}.{name}")
        };
        match value.get_ref() {
            DeValue::Table(table) => match branch(schema, "items") {
                // An override selects elements by name or index; a table in place of a list is one
                // column and has its keys.
                Some(items) if !is_single_element(table, schema) => {
                    for (_, item) in table {
                        if let DeValue::Table(table) = item.get_ref() {
                            walk(table, items, &place)?;
                        }
                    }
                }
                _ => walk(table, schema, &place)?,
            },
            DeValue::Array(array) => {
                if let Some(items) = branch(schema, "items") {
                    for item in array {
                        if let DeValue::Table(table) = item.get_ref() {
                            walk(table, items, &place)?;
                        }
                    }
                }
            }
            _ => {}
        }
    }
    Ok(())
}

/// Returns whether a table in place of a list is a single element; otherwise it overrides elements
/// of the list.
fn is_single_element(table: &DeTable<'_>, schema: &Value) -> bool {
    let elements = |(_, value): (_, &toml::Spanned<DeValue<'_>>)| value.get_ref().is_table();
    branch(schema, "properties").is_some() && !table.iter().all(elements)
}

/// Returns a part of a schema, also from the alternatives of `anyOf`.
fn branch<'a>(schema: &'a Value, part: &str) -> Option<&'a Value> {
    schema.get(part).or_else(|| {
        (schema.get("anyOf")?.as_array()?.iter()).find_map(|alternative| branch(alternative, part))
    })
}

/// Returns the place of a path of keys and indices in the file: that of the deepest part of the
/// path that exists.
pub(super) fn span_of(table: &DeTable<'_>, path: &[&str]) -> Option<Range<usize>> {
    let (first, rest) = path.split_first()?;
    let (key, value) = table.get_key_value(*first)?;
    Some(span_in(value.get_ref(), rest).unwrap_or_else(|| key.span()))
}

fn span_in(value: &DeValue<'_>, path: &[&str]) -> Option<Range<usize>> {
    match value {
        DeValue::Table(table) => span_of(table, path),
        DeValue::Array(array) => {
            let (first, rest) = path.split_first()?;
            let item = array.get(first.parse::<usize>().ok()?)?;
            Some(span_in(item.get_ref(), rest).unwrap_or_else(|| item.span()))
        }
        _ => None,
    }
}
