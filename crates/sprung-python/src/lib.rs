//! The extension module `sprung._sprung`: the library for Python.
//!
//! It takes and returns arrays, JSON and texts. The Python package around it gives them names.

mod arrays;
mod arrow;
mod cli;
mod control;
mod dynamics;
mod errors;
mod excite;
mod plots;
mod results;
mod runner;
mod sample;
mod servo;
mod session;
mod start;

use pyo3::prelude::*;

/// The extension module.
#[pymodule]
fn _sprung(module: &Bound<'_, PyModule>) -> PyResult<()> {
    sprung_cli::hide_caught_panics();
    module.add("GENERATOR", sprung::finding::GENERATOR)?;
    module.add("DEMO_EXPERIMENT", sprung::demo::EXPERIMENT)?;
    module.add("RESULTS", results::schema())?;
    module.add("DEMO_TRUTH", sprung::demo::TRUTH)?;
    module.add_class::<session::Session>()?;
    module.add_class::<results::Identified>()?;
    module.add_class::<results::Checked>()?;
    module.add_class::<results::Validated>()?;
    module.add_class::<results::Watched>()?;
    module.add_class::<servo::IdentifiedServo>()?;
    module.add_class::<excite::Excited>()?;
    module.add_class::<control::Designed>()?;
    module.add_class::<sample::Drawn>()?;
    module.add_class::<dynamics::Dynamics>()?;
    module.add_class::<arrow::Columns>()?;
    module.add_class::<arrow::Numbers>()?;
    module.add_function(wrap_pyfunction!(cli::run_command, module)?)?;
    module.add_function(wrap_pyfunction!(start::toml_of_json, module)?)?;
    module.add_function(wrap_pyfunction!(start::joints_of_urdf, module)?)?;
    module.add_function(wrap_pyfunction!(start::experiment_from_log, module)?)?;
    module.add_function(wrap_pyfunction!(plots::joint_figures, module)?)?;
    module.add_function(wrap_pyfunction!(plots::relative_scale, module)?)?;
    module.add_function(wrap_pyfunction!(sample::export_samples, module)?)?;
    module.add_function(wrap_pyfunction!(sample::mujoco_of_samples, module)?)?;
    module.add_function(wrap_pyfunction!(results::compare, module)?)?;
    module.add_function(wrap_pyfunction!(results::read_results, module)?)?;
    Ok(())
}
