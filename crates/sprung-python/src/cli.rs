//! The command line inside the wheel.

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the command line and returns its exit code.
///
/// - `words`: the typed words, the program first.
#[pyfunction]
pub(crate) fn run_command(py: Python<'_>, words: Vec<OsString>) -> u8 {
    py.detach(|| sprung_cli::run(words))
}
