//! Designed controllers: JSON, TOML and reports.

use std::sync::Arc;

use pyo3::prelude::*;
use sprung::control::{ControlDesign, Controlled};
use sprung::report::compose_control;
use sprung::session::{Session, controller_toml};
use sprung::watch::Watch;

use crate::errors::wrong_input;
use crate::results::{file, html};

/// A designed controller, and the session of its report.
#[pyclass(frozen, module = "sprung._sprung")]
pub(crate) struct Designed {
    session: Arc<Session>,
    controlled: Controlled,
}

impl Designed {
    pub(crate) fn new(session: Arc<Session>, controlled: Controlled) -> Self {
        Self {
            session,
            controlled,
        }
    }
}

#[pymethods]
impl Designed {
    /// The text of `control.json`.
    fn json(&self) -> String {
        file(&self.controlled.design)
    }

    /// The `[controller]` of an experiment file.
    fn toml(&self) -> String {
        controller_toml(&self.controlled.design)
    }

    /// The report as HTML.
    fn report(&self, py: Python<'_>) -> PyResult<String> {
        let text = self.session.text();
        html(
            py,
            &compose_control(&self.controlled, "sprung.Experiment.control", text),
        )
    }
}

/// Returns the watch of a `watch.json`.
pub(crate) fn watch_of(py: Python<'_>, text: &str) -> PyResult<Watch> {
    serde_json::from_str(text).map_err(|error| {
        let text = format!("this is no watch: {error}");
        wrong_input(py, "watch", &text, "give what Result.watch returned")
    })
}

/// Returns the design of a `control.json`.
pub(crate) fn design(py: Python<'_>, text: &str) -> PyResult<ControlDesign> {
    serde_json::from_str(text).map_err(|error| {
        let text = format!("this is no designed controller: {error}");
        wrong_input(
            py,
            "control",
            &text,
            "give what Experiment.control returned",
        )
    })
}
