//! Results: JSON, curves and reports.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use numpy::{PyArray1, ToPyArray};
use pyo3::prelude::*;
use serde::Serialize;
use sprung::compare::{Compared, Drift};
use sprung::curves::Curves;
use sprung::estimate::Identification;
use sprung::report::{
    Contents, Document, compose, compose_check, compose_comparison, compose_watch, render,
};
use sprung::session::{Disk, Files, SessionError, read_identification, results_schema};

use crate::errors::{exception, wrong_input};

/// Curves of one label: label, time, values by column with NaN at gaps.
type Set<'py> = (
    String,
    Bound<'py, PyArray1<f64>>,
    Vec<(String, Bound<'py, PyArray1<f64>>)>,
);

/// An identification with its curves.
#[pyclass(frozen, module = "sprung._sprung")]
pub(crate) struct Identified {
    found: Arc<sprung::estimate::Identified>,
    text: String,
    /// Time inside the library, s; zero for a result that was read.
    #[pyo3(get)]
    seconds: f64,
}

impl Identified {
    pub(crate) fn new(found: sprung::estimate::Identified, text: String) -> Self {
        Self {
            found: Arc::new(found),
            text,
            seconds: 0.0,
        }
    }

    pub(crate) fn after(self, seconds: f64) -> Self {
        Self { seconds, ..self }
    }

    pub(crate) fn found(&self) -> &sprung::estimate::Identified {
        &self.found
    }

    pub(crate) fn shared(&self) -> &Arc<sprung::estimate::Identified> {
        &self.found
    }
}

#[pymethods]
impl Identified {
    /// Rebuilds an identification from its parts.
    #[staticmethod]
    fn of_parts(
        py: Python<'_>,
        json: &str,
        trace: &str,
        fit: &str,
        text: String,
    ) -> PyResult<Self> {
        let wrong = |error: &dyn std::fmt::Display| {
            let message = format!("this is not an identification: {error}");
            wrong_input(
                py,
                "identification",
                &message,
                "give what Result.to_json returned",
            )
        };
        let found = sprung::estimate::Identified {
            identification: serde_json::from_str(json).map_err(|error| wrong(&error))?,
            trace: Curves::from_csv(trace).map_err(|error| wrong(&error))?,
            fit: Curves::from_csv(fit).map_err(|error| wrong(&error))?,
        };
        Ok(Self::new(found, text))
    }

    /// The text of `identification.json`.
    fn json(&self) -> String {
        file(&self.found.identification)
    }

    fn trace_csv(&self) -> String {
        self.found.trace.to_csv("estimator")
    }

    fn fit_csv(&self) -> String {
        self.found.fit.to_csv("source")
    }

    fn parameters_csv(&self) -> String {
        sprung::estimate::parameters_csv(&self.found.identification)
    }

    #[getter]
    fn text(&self) -> &str {
        &self.text
    }

    fn trace<'py>(&self, py: Python<'py>) -> Vec<Set<'py>> {
        sets(py, &self.found.trace)
    }

    fn fit<'py>(&self, py: Python<'py>) -> Vec<Set<'py>> {
        sets(py, &self.found.fit)
    }

    /// The report as HTML.
    fn report(&self, py: Python<'_>, truth: Option<BTreeMap<String, f64>>) -> PyResult<String> {
        let contents = Contents {
            identification: Some(&self.found.identification),
            trace: Some(&self.found.trace),
            fit: Some(&self.found.fit),
            truth: truth.as_ref(),
            command: "sprung.Experiment.identify",
            experiment: &self.text,
            ..Contents::default()
        };
        html(py, &compose(&contents))
    }
}

/// A check with its curves.
#[pyclass(frozen, module = "sprung._sprung")]
pub(crate) struct Checked {
    checked: sprung::check::Checked,
    text: String,
}

impl Checked {
    pub(crate) fn new(checked: sprung::check::Checked, text: String) -> Self {
        Self { checked, text }
    }
}

#[pymethods]
impl Checked {
    /// The text of `check.json`.
    fn json(&self) -> String {
        file(&self.checked.report)
    }

    /// The report as HTML.
    fn report(&self, py: Python<'_>) -> PyResult<String> {
        html(
            py,
            &compose_check(&self.checked, "sprung.Experiment.check", &self.text),
        )
    }
}

/// A validation with its signals.
#[pyclass(frozen, module = "sprung._sprung")]
pub(crate) struct Validated {
    both: sprung::validate::Validated,
    found: Arc<sprung::estimate::Identified>,
    text: String,
}

impl Validated {
    pub(crate) fn new(
        validated: sprung::validate::Validated,
        found: Arc<sprung::estimate::Identified>,
        text: String,
    ) -> Self {
        Self {
            both: validated,
            found,
            text,
        }
    }
}

#[pymethods]
impl Validated {
    /// The text of `validation.json`.
    fn json(&self) -> String {
        file(&self.both.validation)
    }

    /// The verdict in a sentence.
    fn sentence(&self) -> String {
        self.both.validation.sentence().clone()
    }

    fn signals<'py>(&self, py: Python<'py>) -> Vec<Set<'py>> {
        sets(py, &self.both.curves)
    }

    /// The report as HTML.
    fn report(&self, py: Python<'_>) -> PyResult<String> {
        let contents = Contents {
            identification: Some(&self.found.identification),
            trace: Some(&self.found.trace),
            fit: Some(&self.found.fit),
            validation: Some((&self.both.validation, &self.both.curves)),
            command: "sprung.Result.validate",
            experiment: &self.text,
            ..Contents::default()
        };
        html(py, &compose(&contents))
    }
}

/// What happened on a running robot.
#[pyclass(frozen, module = "sprung._sprung")]
pub(crate) struct Watched(sprung::watch::Watched);

impl Watched {
    pub(crate) fn new(watched: sprung::watch::Watched) -> Self {
        Self(watched)
    }
}

#[pymethods]
impl Watched {
    /// The text of `watch.json`.
    fn json(&self) -> String {
        file(&self.0.watch)
    }

    /// What was watched, in a sentence.
    fn sentence(&self) -> String {
        self.0.watch.sentence()
    }

    fn torques<'py>(&self, py: Python<'py>) -> Vec<Set<'py>> {
        sets(py, &self.0.curves)
    }

    /// The report as HTML.
    fn report(&self, py: Python<'_>) -> PyResult<String> {
        html(
            py,
            &compose_watch(&self.0.watch, &self.0.curves, "sprung.Result.watch"),
        )
    }
}

/// Compares identifications, given by a label and their JSON; returns JSON, HTML and the conclusion.
#[pyfunction]
pub(crate) fn compare(
    py: Python<'_>,
    results: Vec<(String, String)>,
) -> PyResult<(String, String, Vec<String>)> {
    let mut all = Vec::new();
    for (label, json) in results {
        let identification: Identification = serde_json::from_str(&json).map_err(|error| {
            let text = format!("{label} is not an identification: {error}");
            wrong_input(py, "identification", &text, "give a Result")
        })?;
        all.push((label, identification));
    }
    let compared: Vec<Compared<'_>> = (all.iter())
        .map(|(file, identification)| Compared {
            file,
            identification,
        })
        .collect();
    let comparison = sprung::compare::compare(&compared, &[])
        .map_err(|error| exception(py, &SessionError::from(error)))?;
    let document = compose_comparison(&comparison, "sprung.compare");
    let drifts = comparison.drift.iter().map(Drift::conclusion);
    let conclusion: Vec<String> = comparison.conclusion().into_iter().chain(drifts).collect();
    Ok((file(&comparison), html(py, &document)?, conclusion))
}

/// Reads an identification and its curves from a file or a folder of results; returns its path too.
#[pyfunction]
pub(crate) fn read_results(
    py: Python<'_>,
    path: PathBuf,
    text: String,
) -> PyResult<(Identified, PathBuf)> {
    let read = read_identification(&path).map_err(|error| exception(py, &error))?;
    let curves = |name: &str| {
        let text = Disk.text(&read.path.with_file_name(name)).ok();
        text.and_then(|text| Curves::from_csv(&text).ok())
            .unwrap_or_default()
    };
    let found = sprung::estimate::Identified {
        trace: curves("trace.csv"),
        fit: curves("fit.csv"),
        identification: read.identification,
    };
    Ok((Identified::new(found, text), read.path))
}

/// Returns the JSON schema of every type of results, by its name.
pub(crate) fn schema() -> String {
    serde_json::Value::from(results_schema()).to_string()
}

/// Returns the text of a file of results.
pub(crate) fn file(value: &impl Serialize) -> String {
    let mut text = serde_json::to_string_pretty(value).unwrap_or_default();
    text.push('\n');
    text
}

pub(crate) fn html(py: Python<'_>, document: &Document) -> PyResult<String> {
    render(document).map_err(|error| {
        let text = format!("the report cannot be made: {error}");
        wrong_input(py, "report", &text, "report this as a defect of sprung")
    })
}

fn sets<'py>(py: Python<'py>, curves: &Curves) -> Vec<Set<'py>> {
    (curves.sets.iter())
        .map(|set| {
            let values = (curves.columns.iter().zip(&set.values))
                .map(|(name, values)| {
                    let numbers: Vec<f64> = values
                        .iter()
                        .map(|value| value.unwrap_or(f64::NAN))
                        .collect();
                    (name.clone(), numbers.to_pyarray(py))
                })
                .collect();
            (set.label.clone(), set.time.to_pyarray(py), values)
        })
        .collect()
}
