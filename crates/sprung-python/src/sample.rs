//! Robots drawn from the posterior of an identification, as arrays.

use std::collections::BTreeMap;

use numpy::ndarray::{Array2, Array3, Array4};
use numpy::{IntoPyArray, PyArray2, PyArray3, PyArray4};
use pyo3::prelude::*;
use sprung::estimate::Samples;

/// Masses, centres of mass and inertias, \[robots × links × …\].
type Bodies<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray3<f64>>,
    Bound<'py, PyArray4<f64>>,
);

/// Drawn robots.
#[pyclass(frozen, module = "sprung._sprung")]
pub(crate) struct Drawn(Samples);

impl Drawn {
    pub(crate) fn new(samples: Samples) -> Self {
        Self(samples)
    }
}

#[pymethods]
impl Drawn {
    #[getter]
    fn parameters(&self) -> Vec<String> {
        self.0.parameters.clone()
    }

    /// Parameters, \[robots × parameters\].
    fn theta<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let own = &self.0.theta;
        let shape = (own.len(), self.0.parameters.len());
        Array2::from_shape_fn(shape, |(robot, at)| own[robot][at]).into_pyarray(py)
    }

    #[getter]
    fn standard_parameters(&self) -> Vec<String> {
        self.0.standard_parameters.clone()
    }

    /// Inertial parameters of single links, \[robots × standard parameters\].
    fn standard<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let own = &self.0.standard;
        let shape = (self.0.theta.len(), self.0.standard_parameters.len());
        Array2::from_shape_fn(shape, |(robot, at)| own[robot][at]).into_pyarray(py)
    }

    #[getter]
    fn links(&self) -> Vec<String> {
        self.0.links.clone()
    }

    /// Bodies of the links; `None` where the parameters do not determine them.
    fn bodies<'py>(&self, py: Python<'py>) -> Option<Bodies<'py>> {
        let count = self.0.theta.len();
        let all: Vec<_> = (0..count)
            .map(|robot| self.0.bodies(robot))
            .collect::<Option<_>>()?;
        let n = self.0.links.len();
        Some((
            Array2::from_shape_fn((count, n), |(robot, link)| all[robot][link].mass)
                .into_pyarray(py),
            Array3::from_shape_fn((count, n, 3), |(robot, link, i)| {
                all[robot][link].centre_of_mass[i]
            })
            .into_pyarray(py),
            Array4::from_shape_fn((count, n, 3, 3), |(robot, link, i, j)| {
                all[robot][link].inertia[i][j]
            })
            .into_pyarray(py),
        ))
    }

    #[getter]
    fn undetermined(&self) -> Vec<String> {
        self.0.undetermined.clone()
    }

    #[getter]
    fn undetermined_standard(&self) -> Vec<String> {
        self.0.undetermined_standard.clone()
    }

    /// Constants of friction laws by name, equal in all robots.
    #[getter]
    fn constants(&self) -> BTreeMap<String, f64> {
        self.0.constants.clone()
    }

    #[getter]
    fn effective(&self) -> f64 {
        self.0.effective
    }
}
