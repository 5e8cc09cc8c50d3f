//! The reference of a controller in a file of its own.

use serde::Deserialize;

use super::check::check_reference;
use super::robot::Robot;
use super::run::Reference;

/// The part of a file with a reference.
#[derive(Deserialize)]
struct File {
    controller: Controller,
}

#[derive(Deserialize)]
struct Controller {
    reference: Reference,
}

/// Reads the `[controller.reference]` of a text, which may have other keys.
///
/// # Errors
///
/// A sentence with the faulty key.
pub fn read_reference(text: &str, robot: &Robot) -> Result<Reference, String> {
    let file: File = toml::from_str(text).map_err(|error| error.message().to_owned())?;
    let reference = file.controller.reference;
    match check_reference(&reference, &["controller", "reference"], robot) {
        Ok(()) => Ok(reference),
        Err(fault) => Err(format!("{}: {}", fault.path.join("."), fault.message)),
    }
}
