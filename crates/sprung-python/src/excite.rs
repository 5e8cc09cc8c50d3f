//! Designed experiments: JSON, arrays, texts of files and reports.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2, ToPyArray};
use pyo3::prelude::*;
use sprung::excite::Trajectory;
use sprung::report::compose_excitation;
use sprung::session::{ExciteMethod, Parameters, Session, SessionError, excitation_files};

use crate::errors::wrong_input;
use crate::results::{Identified, file, html};

/// Names of what makes a motion.
const METHODS: [(&str, ExciteMethod); 3] = [
    ("optimal", ExciteMethod::Optimal),
    ("paper", ExciteMethod::Paper),
    ("random", ExciteMethod::Random),
];

/// Samples of a motion: names of the joints, times, positions, velocities and accelerations.
type Samples<'py> = (
    Vec<String>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
);

/// Values of a robot as Python gives them.
#[derive(FromPyObject)]
pub(crate) enum Values<'py> {
    /// One result of an identification.
    Identified(PyRef<'py, Identified>, usize),
    /// Values of a robot that was drawn from the posterior of an identification.
    Drawn(PyRef<'py, Identified>, BTreeMap<String, f64>),
    /// Values by name.
    Named(BTreeMap<String, f64>),
    /// A file of the command line.
    File(PathBuf),
}

/// The same, free of the interpreter.
pub(crate) enum Source {
    Known(Box<Parameters>),
    File(PathBuf),
}

impl From<Values<'_>> for Source {
    fn from(values: Values<'_>) -> Self {
        match values {
            Values::Identified(identified, set) => {
                let mut identification = identified.found().identification.clone();
                // A design takes the first result.
                if set < identification.results.len() {
                    identification.results.swap(0, set);
                }
                Self::Known(Box::new(Parameters::from(identification)))
            }
            Values::Drawn(identified, values) => {
                let parameters = Parameters::from(identified.found().identification.clone());
                let sets = Parameters::named("drawn", values).sets;
                Self::Known(Box::new(Parameters { sets, ..parameters }))
            }
            Values::Named(values) => Self::Known(Box::new(Parameters::named("given", values))),
            Values::File(path) => Self::File(path),
        }
    }
}

impl Source {
    /// Returns the parameters; reads the file if there is one.
    pub(crate) fn read(self) -> Result<Parameters, SessionError> {
        match self {
            Self::Known(parameters) => Ok(*parameters),
            Self::File(path) => Parameters::open(&path),
        }
    }
}

/// Returns what makes a motion, by its name.
pub(crate) fn method(py: Python<'_>, name: &str) -> PyResult<ExciteMethod> {
    let found = METHODS.into_iter().find(|(word, _)| *word == name);
    found.map(|(_, method)| method).ok_or_else(|| {
        let text = format!("the method \"{name}\" is not known");
        let remedy = format!("give one of {}", METHODS.map(|(word, _)| word).join(", "));
        wrong_input(py, "method", &text, &remedy)
    })
}

/// A designed experiment, and the session that writes its files.
#[pyclass(frozen, module = "sprung._sprung")]
pub(crate) struct Excited {
    session: Arc<Session>,
    excited: sprung::excite::Excited,
}

impl Excited {
    pub(crate) fn new(session: Arc<Session>, excited: sprung::excite::Excited) -> Self {
        Self { session, excited }
    }
}

#[pymethods]
impl Excited {
    /// The text of `excitation.json`.
    fn json(&self) -> String {
        file(&self.excited.excitation)
    }

    fn trajectory<'py>(&self, py: Python<'py>) -> Samples<'py> {
        samples(py, &self.excited.trajectory)
    }

    fn hold_out<'py>(&self, py: Python<'py>) -> Option<Samples<'py>> {
        (self.excited.hold_out.as_ref()).map(|trajectory| samples(py, trajectory))
    }

    fn slow<'py>(&self, py: Python<'py>) -> Option<Samples<'py>> {
        (self.excited.slow.as_ref()).map(|trajectory| samples(py, trajectory))
    }

    /// Names and texts of the files for controllers.
    fn files(&self, py: Python<'_>) -> Vec<(String, String)> {
        let files = py.detach(|| excitation_files(&self.session, &self.excited));
        (files.into_iter())
            .map(|(name, text)| (name.to_owned(), text))
            .collect()
    }

    /// The report as HTML.
    fn report(&self, py: Python<'_>) -> PyResult<String> {
        let text = self.session.text();
        html(
            py,
            &compose_excitation(&self.excited, "sprung.Experiment.excite", text),
        )
    }
}

/// Returns the samples of a motion, matrices \[samples × joints\].
fn samples<'py>(py: Python<'py>, trajectory: &Trajectory) -> Samples<'py> {
    let matrix = |joints: &[Vec<f64>]| {
        let shape = (trajectory.time_s.len(), joints.len());
        Array2::from_shape_fn(shape, |(t, joint)| joints[joint][t]).into_pyarray(py)
    };
    (
        trajectory.joints.clone(),
        trajectory.time_s.to_pyarray(py),
        matrix(&trajectory.position),
        matrix(&trajectory.velocity),
        matrix(&trajectory.acceleration),
    )
}
