//! Experiment files from JSON, robots and logs.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use sprung::session::{NewExperiment, start_from_logs, start_from_urdf};

use crate::errors::{exception, wrong_input};
use crate::runner::Run;

/// Returns an experiment file from JSON.
#[pyfunction]
pub(crate) fn toml_of_json(py: Python<'_>, json: &str) -> PyResult<String> {
    let wrong = |error: &dyn std::fmt::Display| {
        let text = format!("the experiment cannot be written as TOML: {error}");
        wrong_input(
            py,
            "experiment",
            &text,
            "give tables, lists, texts and numbers as in experiment.toml",
        )
    };
    let value: serde_json::Value = serde_json::from_str(json).map_err(|error| wrong(&error))?;
    let value = toml::Value::try_from(value).map_err(|error| wrong(&error))?;
    toml::to_string(&value).map_err(|error| wrong(&error))
}

/// Returns the names of the joints of a URDF that move.
#[pyfunction]
pub(crate) fn joints_of_urdf(py: Python<'_>, path: PathBuf) -> PyResult<Vec<String>> {
    let folder = path.parent().map_or_else(PathBuf::new, Path::to_owned);
    let start = start_from_urdf(&path, &folder).map_err(|error| exception(py, &error))?;
    Ok(start.joint_names())
}

/// Chooses the columns of logs; returns the text of an experiment file and the findings as JSON.
#[pyfunction]
pub(crate) fn experiment_from_log(
    py: Python<'_>,
    logs: Vec<PathBuf>,
    urdf: Option<PathBuf>,
    joints: Option<usize>,
    topics: Option<String>,
    folder: PathBuf,
    run: Run,
) -> PyResult<(String, String)> {
    let new = run.work(py, move |progress| {
        let start = match urdf {
            Some(urdf) => start_from_urdf(&urdf, &folder)?,
            None => start_from_logs(&logs, joints, 1)?,
        };
        if logs.is_empty() {
            return Ok(NewExperiment::without_log(&start));
        }
        NewExperiment::from_logs(&start, (&logs, topics.as_deref()), &folder, progress)
    })?;
    let findings = serde_json::to_string(&new.findings).unwrap_or_default();
    Ok((new.text, findings))
}
