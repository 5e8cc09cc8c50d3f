//! Reads identifications of all versions.

use serde_json::{Value, json};
use sprung_method::estimate::Identification;

/// Returns an identification of any version: until version 2 laws were no unknowns.
///
/// # Errors
///
/// [`serde_json::Error`] if it has other contents.
pub(super) fn identification_from(mut json: Value) -> Result<Identification, serde_json::Error> {
    let rungs = json.pointer("/laws/rungs").and_then(Value::as_array);
    let laws: Vec<Value> = rungs.into_iter().flatten().map(as_unknown).collect();
    if let Some(contents) = json.as_object_mut() {
        let unknowns = contents.entry("unknowns").or_insert_with(|| json!([]));
        if let Some(unknowns) = unknowns.as_array_mut() {
            unknowns.extend(laws);
        }
    }
    serde_json::from_value(json)
}

/// Returns a law of version 2 as an unknown. The coefficient is a parameter of the results.
fn as_unknown(rung: &Value) -> Value {
    let text = |key: &str| rung[key].as_str().unwrap_or_default();
    let id = format!("law {}.{}.{}", text("joint"), text("of"), text("law"));
    let is_made = rung["made"].as_bool().unwrap_or_default();
    let gain = rung["gain"].as_f64().unwrap_or_default();
    json!({
        "id": id.trim_end_matches('.'),
        "kind": "law",
        "place": text("joint"),
        "value": 0.0,
        "standard_error": 0.0,
        "unit": "",
        "law": rung,
        "status": if is_made { "applied" } else { "found" },
        "effect": 1.0 - (1.0 - gain).powi(2),
    })
}
