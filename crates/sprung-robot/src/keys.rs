//! Finds keys that the schema does not contain, with their place in the file.

use std::ops::Range;
use std::sync::LazyLock;

use serde_json::Value;
use toml::de::{DeTable, DeValue};

use super::known_words::nearest;
use super::types::ExperimentFile;

/// A message and its place in the file.
pub(super) struct Misfit {
    /// Bytes of the text, if known.
    pub(super) span: Option<Range<usize>>,
    /// The fault and the remedy.
    pub(super) message: String,
    /// Code of a refusal of the table of what works with what.
    pub(super) code: Option<&'static str>,
}

/// Keys of earlier versions: block, key, and what replaces it.
const REMOVED: [(&str, &str, &str); 10] = [
    (
        "robot.joint",
        "residual_velocity_rad_per_s",
        "the law \"residual\" is no longer part of sprung: remove the key; \"presliding\" in motor_friction is friction \
         near reversals, and presliding_width_rad its width",
    ),
    (
        "identify",
        "instruments",
        "sprung no longer has instrumental variables, because they were no better than least squares; remove the \
         key. Where noise shrinks stiffnesses (finding stacked-below-motor-rows), set estimator = \
         \"prediction-error\"",
    ),
    (
        "identify",
        "initial_momentum",
        "there is no successor: remove the key; if the first velocity of the log is wrong, begin the log later with \
         file = { path = \"…\", from_s = … }",
    ),
    ("identify", "lsff_forgetting_per_s", OF_THE_PAPER),
    ("identify", "lsff_initial_gain", OF_THE_PAPER),
    ("identify", "lsff_velocity_window", OF_THE_PAPER),
    (
        "simulate",
        "torque_disturbance_hz",
        "there is no successor: the disturbances have a corner of 3 Hz; remove the key",
    ),
    (
        "excite",
        "bandwidth_hz",
        "the gains of [controller] replace it; without [controller] the motors have a bandwidth of 10 Hz",
    ),
    (
        "control",
        "residual_percent",
        "there is no successor: the shaper leaves at most 5 % of a vibration; remove the key",
    ),
    (
        "control",
        "vibrations",
        "\"log\" is no longer part of sprung: the shaper always removes the vibrations of the model, as with \"model\"; \
         remove the key",
    ),
];

const OF_THE_PAPER: &str =
    "there is no successor: LSFF has the values of its paper; remove the key";

/// Returns what replaces a key of an earlier version.
fn successor(place: &str, name: &str) -> Option<String> {
    let removed = (REMOVED.iter()).find(|(block, key, _)| *block == place && *key == name);
    if let Some((.., instead)) = removed {
        return Some((*instead).to_owned());
    }
    let (sensor, rest) = ["gyroscope_", "accelerometer_"]
        .into_iter()
        .find_map(|sensor| Some((sensor, name.strip_prefix(sensor)?)))?;
    let (axis, unit) = rest.split_once('_')?;
    let is_axis = place.ends_with("log") && ["x", "y", "z"].contains(&axis);
    is_axis.then(|| format!("write {sensor}{unit}.{axis} = …"))
}

/// The schema of the file, with its definitions of tables.
static SCHEMA: LazyLock<Value> = LazyLock::new(|| schemars::schema_for!(ExperimentFile).to_value());

/// Checks that every key is one of the schema's.
pub(super) fn check(table: &DeTable<'_>) -> Result<(), Misfit> {
    walk(table, &SCHEMA, "")
}

#[expect(clippy::wildcard_enum_match_arm, reason = "plain values have no keys")]
fn walk(table: &DeTable<'_>, schema: &Value, place: &str) -> Result<(), Misfit> {
    let Some(properties) = branch(schema, "properties").and_then(Value::as_object) else {
        return Ok(());
    };
    for (key, value) in table {
        let name = key.get_ref().as_ref();
        let Some(schema) = properties.get(name) else {
            let successor = successor(place, name);
            let place = if place.is_empty() {
                "the file".to_owned()
            } else {
                format!("[{place}]")
            };
            let known: Vec<&str> = properties.keys().map(String::as_str).collect();
            let hint = match (successor, nearest(name, known.iter().copied())) {
                (Some(successor), _) => successor,
                (None, Some(one)) => format!("did you mean \"{one}\"?"),
                (None, None) => format!("known keys are {}", known.join(", ")),
            };
            return Err(Misfit {
                span: Some(key.span()),
                message: format!("unknown key \"{name}\" in {place}; {hint}"),
                code: None,
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

/// Returns a part of a schema, also from its definition or from the alternatives of `anyOf`.
fn branch<'a>(schema: &'a Value, part: &str) -> Option<&'a Value> {
    if let Some(name) = schema.get("$ref").and_then(Value::as_str) {
        return branch(SCHEMA.pointer(name.strip_prefix('#')?)?, part);
    }
    schema.get(part).or_else(|| {
        (schema.get("anyOf")?.as_array()?.iter()).find_map(|alternative| branch(alternative, part))
    })
}

/// Returns the place of a path of keys and indices in the file: that of the deepest part of the
/// path that exists.
pub(super) fn span_of(table: &DeTable<'_>, path: &[&str]) -> Option<Range<usize>> {
    let (first, rest) = path.split_first()?;
    let Some((key, value)) = table.get_key_value(*first) else {
        // The key of an axis has the form of a dotted key.
        let (sensor, axis) = first.split_once('.')?;
        return span_of(table, &[&[sensor, axis], rest].concat());
    };
    Some(span_in(value.get_ref(), rest).unwrap_or_else(|| key.span()))
}

#[expect(clippy::wildcard_enum_match_arm, reason = "plain values have no parts")]
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

#[cfg(test)]
mod tests {
    use crate::{no_files, read};
    use sprung_base::demo;

    #[test]
    fn a_removed_key_names_what_replaces_it() {
        let text =
            demo::EXPERIMENT.replace("[identify]", "[identify]\ninstruments = \"simulated\"");
        let error = read("experiment.toml", &text, &[], &mut no_files).unwrap_err();
        let error = error.to_string();
        let line = 1 + text
            .lines()
            .position(|line| line.starts_with("instruments"))
            .unwrap();
        let line = format!("line {line}");
        let unknown = "unknown key \"instruments\" in [identify]";
        for part in [line.as_str(), unknown, "prediction-error"] {
            assert!(error.contains(part), "{error}");
        }
    }
}
