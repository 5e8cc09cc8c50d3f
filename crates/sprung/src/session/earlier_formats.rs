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
    let laws: Vec<Value> = rungs
        .into_iter()
        .flatten()
        .map(|rung| as_unknown(rung, &json))
        .collect();
    if let Some(contents) = json.as_object_mut() {
        let unknowns = contents.entry("unknowns").or_insert_with(|| json!([]));
        if let Some(unknowns) = unknowns.as_array_mut() {
            unknowns.extend(laws);
        }
    }
    serde_json::from_value(json)
}

/// Returns a law of version 2 as an unknown, with the value of its parameter in the first result.
fn as_unknown(rung: &Value, identification: &Value) -> Value {
    let text = |key: &str| rung[key].as_str().unwrap_or_default();
    let id = format!("law {}.{}.{}", text("joint"), text("of"), text("law"));
    let is_made = rung["made"].as_bool().unwrap_or_default();
    let gain = rung["gain"].as_f64().unwrap_or_default();
    let side = text("of").trim_end_matches("_friction");
    let parameter = match (text("of"), text("law")) {
        ("spring", "cubic") => "cubic_stiffness".to_owned(),
        ("spring", law) => law.to_owned(),
        (_, law) => format!("{side}_{}", law.trim_end_matches("-asymmetric")),
    };
    // A law of both directions has one parameter for each, named by its direction.
    let start = format!("{}.{parameter}", text("joint"));
    let all = identification.pointer("/results/0/parameters");
    let mut all = all.and_then(Value::as_array).into_iter().flatten();
    let found = all.find(|found| {
        let name = found["name"].as_str();
        name.is_some_and(|name| name.starts_with(&start))
    });
    let number = |key: &str| found.and_then(|found| found[key].as_f64());
    json!({
        "id": id.trim_end_matches('.'),
        "kind": "law",
        "place": text("joint"),
        "value": number("value").unwrap_or_default(),
        "standard_error": number("standard_error").unwrap_or(f64::MAX),
        "unit": found.and_then(|found| found["unit"].as_str()).unwrap_or_default(),
        "law": rung,
        "status": if is_made { "applied" } else { "found" },
        "effect": 1.0 - (1.0 - gain).powi(2),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_law_of_version_2_has_the_value_of_its_parameter() {
        let rung = json!({ "joint": "shoulder", "of": "motor_friction",
            "law": "viscous-asymmetric", "gain": 0.5, "made": true });
        let parameter = |name: &str, value: f64| {
            json!({ "name": name, "value": value,
            "standard_error": value / 10.0, "unit": "N·m·s/rad" })
        };
        let identification = json!({ "results": [{ "parameters": [
            parameter("shoulder.link_viscous", 1.0),
            parameter("shoulder.motor_viscous_positive", 2.0),
            parameter("shoulder.motor_viscous_negative", 3.0),
        ] }] });
        let law = as_unknown(&rung, &identification);
        assert_eq!(law["value"], 2.0);
        assert_eq!(law["standard_error"], 0.2);
        assert_eq!(law["unit"], "N·m·s/rad");
        assert_eq!(law["status"], "applied");
        assert_eq!(law["effect"], 0.75);
    }

    #[test]
    fn a_law_without_a_parameter_has_no_small_error() {
        let rung = json!({ "joint": "a", "of": "spring", "law": "cubic" });
        let law = as_unknown(&rung, &json!({}));
        assert_eq!(law["standard_error"], f64::MAX);
        assert_eq!(law["status"], "found");
    }
}
