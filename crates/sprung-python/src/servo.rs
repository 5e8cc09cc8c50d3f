//! Results of position servos: JSON, tables and reports.

use pyo3::prelude::*;
use serde::Serialize;
use sprung::finding::Finding;
use sprung::report::compose_servo;
use sprung::servo::{ServoExpectation, ServoIdentification, servo_parameters_csv};

use crate::results::{file, html};

/// What the logs of a servo can tell: the contents of `servo-check.json`.
#[derive(Serialize)]
pub(crate) struct ServoCheck {
    format: u32,
    parameters: Vec<ServoExpectation>,
    findings: Vec<Finding>,
}

impl ServoCheck {
    pub(crate) fn new(parameters: Vec<ServoExpectation>, findings: Vec<Finding>) -> Self {
        Self {
            format: 1,
            parameters,
            findings,
        }
    }
}

/// An identified position servo.
#[pyclass(frozen, module = "sprung._sprung")]
pub(crate) struct IdentifiedServo {
    found: ServoIdentification,
    text: String,
}

impl IdentifiedServo {
    pub(crate) fn new(found: ServoIdentification, text: String) -> Self {
        Self { found, text }
    }

    pub(crate) fn found(&self) -> &ServoIdentification {
        &self.found
    }
}

#[pymethods]
impl IdentifiedServo {
    /// The text of `servo.json`.
    fn json(&self) -> String {
        file(&self.found)
    }

    fn parameters_csv(&self) -> String {
        servo_parameters_csv(&self.found)
    }

    /// The report as HTML.
    fn report(&self, py: Python<'_>) -> PyResult<String> {
        html(
            py,
            &compose_servo(&self.found, "sprung.Servo.identify", &self.text),
        )
    }
}
