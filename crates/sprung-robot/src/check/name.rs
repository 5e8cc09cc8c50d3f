//! Checks names of joints and validation runs.

use super::fault::{Fault, fault};

/// Checks the characters of a name, because names become keys and column titles of files.
pub(crate) fn check_name(name: &str, path: &[&str]) -> Result<(), Fault> {
    let allowed = |c: char| c.is_alphanumeric() || "_-. ".contains(c);
    if !name.trim().is_empty() && name.chars().all(allowed) {
        return Ok(());
    }
    Err(fault(
        path,
        format!(
            "the name \"{name}\" must consist of letters, digits, spaces, \"_\", \"-\" and \".\""
        ),
    ))
}
