//! Names in files: forbidden characters of a format, and escapes of XML.

use super::error::ExportError;
use super::format::Format;
use super::robot::{Form, MOTOR, ROTOR, SPRING, StandardRobot};

/// Checks the names of links and joints, and that the names that the export adds are free.
///
/// # Errors
///
/// [`ExportError::Name`] and [`ExportError::Taken`].
pub(super) fn check(format: Format, form: Form, robot: &StandardRobot) -> Result<(), ExportError> {
    for joint in &robot.joints {
        for name in [&joint.name, &joint.link] {
            if let Some(reason) = forbidden(format, name) {
                return Err(ExportError::Name {
                    format: format.name(),
                    name: name.clone(),
                    reason,
                });
            }
        }
    }
    if format == Format::Json || format.is_code() {
        return Ok(());
    }
    let joints: Vec<&str> = robot
        .joints
        .iter()
        .map(|joint| joint.name.as_str())
        .collect();
    let links: Vec<&str> = robot
        .joints
        .iter()
        .map(|joint| joint.link.as_str())
        .collect();
    for joint in robot.joints.iter().filter(|joint| joint.has_spring(form)) {
        for (what, suffix, known) in [
            ("joint", MOTOR, &joints),
            ("joint", SPRING, &joints),
            ("link", ROTOR, &links),
        ] {
            free(what, &format!("{}{suffix}", joint.name), known)?;
        }
    }
    Ok(())
}

/// Checks that a name is free.
///
/// # Errors
///
/// [`ExportError::Taken`] if it is not.
pub(super) fn free(
    what: &'static str,
    name: &str,
    known: &[impl AsRef<str>],
) -> Result<(), ExportError> {
    if known.iter().any(|known| known.as_ref() == name) {
        return Err(ExportError::Taken {
            what,
            name: name.to_owned(),
        });
    }
    Ok(())
}

fn forbidden(format: Format, name: &str) -> Option<&'static str> {
    if name.chars().any(char::is_control) {
        return Some("it contains a control character");
    }
    match format {
        Format::Sdf if name.contains("::") => Some("\"::\" separates the names of nested models"),
        Format::Sdf if name.starts_with("__") && name.ends_with("__") => {
            Some("names between double underscores are reserved")
        }
        Format::Sdf | Format::Mjcf if name == "world" => Some("it is the name of the world"),
        Format::Urdf | Format::Mjcf | Format::Sdf | Format::Json | Format::C | Format::Rust => None,
    }
}

/// Returns a text as the value of an attribute, or as the text of an element.
pub(super) fn escaped(text: &str) -> String {
    (text.replace('&', "&amp;").replace('<', "&lt;")).replace('"', "&quot;")
}
