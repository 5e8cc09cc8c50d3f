//! Many logs of one robot: choices, factors of each log, and the result of all factors.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use pyo3::prelude::*;
use sprung::estimate::IdentifyError;
use sprung::log::{Input, LogSource};
use sprung::session::{Choices, Disk, Files, LogFactors, SessionError};

use crate::errors::wrong_input;
use crate::runner::Run;
use crate::session::Session;
use crate::worked::Identified;

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

/// Makes the choices that hold for all logs of a robot; returns JSON.
#[pyfunction]
pub(crate) fn choices(
    py: Python<'_>,
    session: &Session,
    name: String,
    path: PathBuf,
    run: Run,
) -> PyResult<String> {
    let session = Arc::new(session.inner().without_files());
    let first = source(&session, name, path);
    let made = run.work(py, move |progress| {
        first.with(|log| session.choices_with(log, progress))
    })?;
    Ok(serde_json::to_string(&made).unwrap_or_default())
}

/// Reduces a log with choices; returns JSON.
///
/// - `order`: its number among all logs of the robot.
#[pyfunction]
pub(crate) fn factors(
    py: Python<'_>,
    session: &Session,
    choices: &str,
    order: usize,
    name: String,
    path: PathBuf,
    run: Run,
) -> PyResult<String> {
    let choices: Choices = serde_json::from_str(choices).map_err(|error| {
        let text = format!("the choices cannot be read: {error}");
        wrong_input(
            py,
            "choices",
            &text,
            "give what Experiment.choices returned",
        )
    })?;
    let session = Arc::new(session.inner().without_files());
    let log = source(&session, name, path);
    let reduced = run.work(py, move |progress| {
        log.with(|log| session.factors_with(&choices, (order, log), progress))
    })?;
    Ok(reduced.to_json())
}

/// Identifies the parameters from the factors of all logs.
///
/// - `name`, `path`: the log of the choices, of which the beginning is read again.
#[pyfunction]
pub(crate) fn identify_factors(
    py: Python<'_>,
    session: &Session,
    factors: Vec<String>,
    name: String,
    path: PathBuf,
    run: Run,
) -> PyResult<Identified> {
    let text = session.inner().text().to_owned();
    let session = Arc::new(session.inner().without_files());
    let first = source(&session, name, path);
    let found = run.work(py, move |progress| {
        let mut all: Option<LogFactors> = None;
        for one in &factors {
            let one = LogFactors::from_json(one).map_err(IdentifyError::from)?;
            all = Some(match all {
                None => one,
                Some(all) => all.merge(one).map_err(IdentifyError::from)?,
            });
        }
        let all = all.ok_or(SessionError::NoLogFile)?;
        first.with(|log| session.identify_factors_with(log, &all, progress))
    })?;
    Ok(Identified::new(found, text))
}
