//! The form of the files of results.

use schemars::generate::SchemaSettings;

/// Returns the JSON schema of every type in the files of results, by its name, with the meaning of each field.
///
/// ```
/// let schema = sprung::session::results_schema();
/// let period = &schema["LogUsed"]["properties"]["period_s"];
/// assert_eq!(period["description"], "Sampling period, s.");
/// ```
#[must_use]
pub fn results_schema() -> serde_json::Map<String, serde_json::Value> {
    let mut generator = SchemaSettings::default().for_serialize().into_generator();
    generator.subschema_for::<sprung_method::check::CheckReport>();
    generator.subschema_for::<sprung_method::estimate::Identification>();
    generator.subschema_for::<sprung_method::validate::Validation>();
    generator.subschema_for::<sprung_method::compare::Comparison>();
    generator.subschema_for::<sprung_method::excite::Excitation>();
    generator.subschema_for::<sprung_method::control::ControlDesign>();
    generator.subschema_for::<sprung_method::watch::Watch>();
    generator.subschema_for::<sprung_servo::ServoIdentification>();
    generator.take_definitions(true)
}
