//! Many logs of one robot: choices, factors of each log, and the result of all factors.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use pyo3::prelude::*;
use sprung::estimate::IdentifyError;
use sprung::log::{Input, LogSource};
use sprung::session::{Choices, Disk, Files, LogFactors, SessionError};

use crate::errors::{exception, wrong_input};
use crate::results::Identified;
use crate::runner::Run;
use crate::session::Session;

/// A file as a log, with the name that it has in results.
struct Source {
    name: String,
    path: PathBuf,
    folder: PathBuf,
}

impl Source {
    /// Calls a function with the log.
    fn with<T>(self, call: impl FnOnce(LogSource<'_>) -> T) -> T {
        let Self { name, path, folder } = self;
        let mut opener = |other: Option<&Path>| -> std::io::Result<Box<dyn Input>> {
            match other {
                None => Disk.open(&path),
                Some(other) => Disk.open(&folder.join(other)),
            }
        };
        call(LogSource::files(name, &mut opener))
    }
}

fn source(session: &sprung::session::Session, name: String, path: PathBuf) -> Source {
    Source {
        name,
        path,
        folder: session.folder().to_owned(),
    }
}

/// What sprung chose from the first log of a robot, which holds for all its logs.
#[pyclass(frozen, eq, name = "Choices", module = "sprung._sprung")]
#[derive(PartialEq)]
pub(crate) struct RobotChoices(Choices);

#[pymethods]
impl RobotChoices {
    /// Reads what `to_json` returned.
    #[staticmethod]
    fn from_json(py: Python<'_>, text: &str) -> PyResult<Self> {
        let read = serde_json::from_str(text).map_err(|error| {
            let message = format!("the choices cannot be read: {error}");
            let remedy = "give what Choices.to_json returned";
            wrong_input(py, "choices", &message, remedy)
        })?;
        Ok(Self(read))
    }

    /// The choices as JSON.
    fn to_json(&self) -> String {
        // Names of keys are texts, so nothing can fail.
        serde_json::to_string(&self.0).unwrap_or_default()
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        Ok((slf.getattr("from_json")?, (slf.get().to_json(),)))
    }
}

/// The logs of a robot, reduced to the factors of least squares.
#[pyclass(frozen, eq, name = "LogFactors", module = "sprung._sprung")]
#[derive(PartialEq)]
pub(crate) struct ReducedLogs(LogFactors);

#[pymethods]
impl ReducedLogs {
    /// Reads what `to_json` returned.
    #[staticmethod]
    fn from_json(py: Python<'_>, text: &str) -> PyResult<Self> {
        let read = LogFactors::from_json(text).map_err(|error| {
            let remedy = "give what LogFactors.to_json returned";
            wrong_input(py, "factors", &error.to_string(), remedy)
        })?;
        Ok(Self(read))
    }

    /// The factors as JSON.
    fn to_json(&self) -> String {
        self.0.to_json()
    }

    /// Joins the factors of other logs of the same robot.
    fn merge(&self, py: Python<'_>, other: &Self) -> PyResult<Self> {
        let merged = self.0.clone().merge(other.0.clone());
        merged
            .map(Self)
            .map_err(|error| exception(py, &SessionError::from(IdentifyError::from(error))))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        Ok((slf.getattr("from_json")?, (slf.get().to_json(),)))
    }
}

/// Makes the choices that hold for all logs of a robot.
#[pyfunction]
pub(crate) fn choices(
    py: Python<'_>,
    session: &Session,
    name: String,
    path: PathBuf,
    run: Run,
) -> PyResult<RobotChoices> {
    let session = Arc::new(session.inner().without_files());
    let first = source(&session, name, path);
    let made = run.work(py, move |progress| {
        first.with(|log| session.choices_with(log, progress))
    })?;
    Ok(RobotChoices(made))
}

/// Reduces a log with choices.
///
/// - `order`: its number among all logs of the robot.
#[pyfunction]
pub(crate) fn factors(
    py: Python<'_>,
    session: &Session,
    choices: &RobotChoices,
    order: usize,
    name: String,
    path: PathBuf,
    run: Run,
) -> PyResult<ReducedLogs> {
    let choices = choices.0.clone();
    let session = Arc::new(session.inner().without_files());
    let log = source(&session, name, path);
    let reduced = run.work(py, move |progress| {
        log.with(|log| session.factors_with(&choices, (order, log), progress))
    })?;
    Ok(ReducedLogs(reduced))
}

/// Identifies the parameters from the factors of all logs.
///
/// - `name`, `path`: the log of the choices, of which the beginning is read again.
#[pyfunction]
pub(crate) fn identify_factors(
    py: Python<'_>,
    session: &Session,
    factors: &ReducedLogs,
    name: String,
    path: PathBuf,
    run: Run,
) -> PyResult<Identified> {
    let text = session.inner().text().to_owned();
    let all = factors.0.clone();
    let session = Arc::new(session.inner().without_files());
    let first = source(&session, name, path);
    let found = run.work(py, move |progress| {
        first.with(|log| session.identify_factors_with(log, &all, progress))
    })?;
    Ok(Identified::new(found, text))
}
