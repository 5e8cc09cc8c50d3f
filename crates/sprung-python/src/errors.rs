//! Exceptions: errors of the library with their code, place and remedy.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use sprung::description::Language;
use sprung::session::{ErrorKind, SessionError, split_remedy};

/// Returns the exception of an error.
pub(crate) fn exception(py: Python<'_>, error: &SessionError) -> PyErr {
    let class = match error.kind() {
        ErrorKind::Usage => "ExperimentError",
        ErrorKind::Log => "LogError",
        ErrorKind::File => "FileError",
        ErrorKind::Stopped => "Stopped",
    };
    let mut described = error.described();
    if let Some(text) = in_python(error) {
        let (fault, remedy) = split_remedy(&text);
        described.remedy = remedy.map(str::to_owned);
        fault.clone_into(&mut described.text);
    }
    let findings = serde_json::to_string(error.findings()).unwrap_or_default();
    raise(
        py,
        class,
        &described.text,
        &described.code,
        described.remedy.as_deref(),
        described.place.as_deref(),
        &findings,
    )
}

/// Returns the text for Python of an error whose usual text names words of the command line.
fn in_python(error: &SessionError) -> Option<String> {
    match error {
        SessionError::IsServo(call) => Some(call.text(Language::Python)),
        SessionError::Excite(refusal) => {
            let text = refusal
                .to_string()
                .replace("--parameters FILE", "parameters");
            Some(text.replace("--warm-up", "warm_up=True"))
        }
        SessionError::Control(refusal) => {
            let text = (refusal.to_string())
                .replace(
                    "; give --parameters FILE with an identification",
                    ", or give a Result",
                )
                .replace("--control belongs", "control belongs")
                .replace("--format ", "the format ");
            Some(text.replace("sprung control", "Experiment.control"))
        }
        SessionError::UnusableResult { .. } => {
            let text = error.to_string();
            Some(text.replace("accept unusable results", "give accept_unusable=True"))
        }
        _ => None,
    }
}

/// Returns an exception about the arguments of a call.
pub(crate) fn wrong_input(py: Python<'_>, code: &str, text: &str, remedy: &str) -> PyErr {
    raise(py, "InputError", text, code, Some(remedy), None, "[]")
}

/// Returns an exception that the package defines.
///
/// - `findings`: findings for which a log was refused, as JSON.
fn raise(
    py: Python<'_>,
    class: &str,
    text: &str,
    code: &str,
    remedy: Option<&str>,
    place: Option<&str>,
    findings: &str,
) -> PyErr {
    let made = py.import("sprung._errors").and_then(|module| {
        module.call_method1("described", (class, text, code, remedy, place, findings))
    });
    match made {
        Ok(exception) => PyErr::from_value(exception),
        Err(error) => error,
    }
}

/// Returns the exception of a defect of the library.
pub(crate) fn defect() -> PyErr {
    PyRuntimeError::new_err(
        "sprung failed without a message; this is a defect of sprung: report it with the experiment \
         and the log",
    )
}
