//! Robots drawn from the posterior of an identification, as arrays.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use numpy::ndarray::{Array2, Array3, Array4, ArrayView1};
use numpy::{IntoPyArray, PyArray2, PyArray3, PyArray4, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use sprung::estimate::Samples;
use sprung::export::{Format, MujocoFields, MujocoNames};
use sprung::session::{ExportRequest, Parameters, SampledRobots};

use crate::results::Identified;
use crate::runner::Run;
use crate::session::{self, Session, format_of};

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
        let theta = &self.0.theta;
        let shape = (theta.len(), self.0.parameters.len());
        Array2::from_shape_fn(shape, |(robot, at)| theta[robot][at]).into_pyarray(py)
    }

    #[getter]
    fn standard_parameters(&self) -> Vec<String> {
        self.0.standard_parameters.clone()
    }

    /// Inertial parameters of single links, \[robots × standard parameters\].
    fn standard<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let standard = &self.0.standard;
        let shape = (self.0.theta.len(), self.0.standard_parameters.len());
        Array2::from_shape_fn(shape, |(robot, at)| standard[robot][at]).into_pyarray(py)
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

/// Some of the drawn robots as Python gives them.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Robots<'py> {
    /// Names of the columns of `values`.
    names: Vec<String>,
    /// \[robots × names\].
    values: PyReadonlyArray2<'py, f64>,
    /// Constants of friction laws by name.
    constants: BTreeMap<String, f64>,
    /// Number of the first of these robots, number of all, and their seed.
    draw: (usize, usize, u64),
}

impl Robots<'_> {
    fn sampled(&self) -> SampledRobots {
        let named = |row: ArrayView1<'_, f64>| {
            let mut values = self.constants.clone();
            values.extend(self.names.iter().cloned().zip(row.iter().copied()));
            values
        };
        let (first, count, seed) = self.draw;
        SampledRobots {
            values: self
                .values
                .as_array()
                .rows()
                .into_iter()
                .map(named)
                .collect(),
            first,
            count,
            seed,
        }
    }
}

/// Names of bodies, joints and tendons, and arrays by the names of fields with the robots along the first axis.
pub(crate) type OfMujoco<'py> = ((Vec<String>, Vec<String>, Vec<String>), Bound<'py, PyDict>);

/// Returns fields of robots for Python.
fn of_mujoco<'py>(
    py: Python<'py>,
    names: MujocoNames,
    robots: &[MujocoFields],
) -> PyResult<OfMujoco<'py>> {
    let arrays = PyDict::new(py);
    let scalar = |of: fn(&MujocoFields) -> &[f64]| {
        let width = robots.first().map_or(0, |robot| of(robot).len());
        Array2::from_shape_fn((robots.len(), width), |(robot, at)| of(&robots[robot])[at])
            .into_pyarray(py)
    };
    arrays.set_item("body_mass", scalar(|robot| &robot.body_mass))?;
    arrays.set_item("body_ipos", vectors(py, robots, |robot| &robot.body_ipos))?;
    arrays.set_item("body_iquat", vectors(py, robots, |robot| &robot.body_iquat))?;
    arrays.set_item(
        "body_inertia",
        vectors(py, robots, |robot| &robot.body_inertia),
    )?;
    arrays.set_item("dof_armature", scalar(|robot| &robot.dof_armature))?;
    arrays.set_item("dof_damping", scalar(|robot| &robot.dof_damping))?;
    arrays.set_item("dof_frictionloss", scalar(|robot| &robot.dof_frictionloss))?;
    arrays.set_item("tendon_stiffness", scalar(|robot| &robot.tendon_stiffness))?;
    arrays.set_item("tendon_damping", scalar(|robot| &robot.tendon_damping))?;
    let MujocoNames {
        bodies,
        joints,
        tendons,
    } = names;
    Ok(((bodies, joints, tendons), arrays))
}

/// Returns vectors of bodies, \[robots × bodies × N\].
fn vectors<'py, const N: usize>(
    py: Python<'py>,
    robots: &[MujocoFields],
    of: fn(&MujocoFields) -> &[[f64; N]],
) -> Bound<'py, PyArray3<f64>> {
    let width = robots.first().map_or(0, |robot| of(robot).len());
    let shape = (robots.len(), width, N);
    Array3::from_shape_fn(shape, |(robot, body, k)| of(&robots[robot])[body][k]).into_pyarray(py)
}

/// Writes drawn robots for simulators; returns the text of each.
///
/// - `identified`: an identification and the index of the result from which they were drawn.
/// - `form`: the format, and whether rigid joints replace springs.
/// - `file`: the file of the parameters, for the origin.
#[pyfunction]
pub(crate) fn export_samples(
    py: Python<'_>,
    session: &Session,
    identified: (PyRef<'_, Identified>, usize),
    robots: Robots<'_>,
    form: (&str, bool),
    file: PathBuf,
    run: Run,
) -> PyResult<Vec<String>> {
    let ((identified, set), (format, rigid)) = (identified, form);
    let format = format_of(py, format)?;
    let (session, robots) = (session.shared(), robots.sampled());
    let parameters = Parameters::from(identified.found().identification.clone());
    let exported = run.work(py, move |_| {
        let request = ExportRequest {
            file: &file,
            format,
            form: session::form(rigid),
            set,
            control: None,
            watch: None,
        };
        session.export_samples(&parameters, &request, &robots)
    })?;
    Ok(exported.into_iter().flat_map(|robot| robot.texts).collect())
}

/// Returns the fields of the models that MuJoCo compiles from the MJCF of drawn robots.
///
/// - `identified`: as for [`export_samples`].
#[pyfunction]
pub(crate) fn mujoco_of_samples<'py>(
    py: Python<'py>,
    session: &Session,
    identified: (PyRef<'py, Identified>, usize),
    robots: Robots<'py>,
    rigid: bool,
    run: Run,
) -> PyResult<OfMujoco<'py>> {
    let (identified, set) = identified;
    let (session, robots) = (session.shared(), robots.sampled());
    let parameters = Parameters::from(identified.found().identification.clone());
    let (names, fields) = run.work(py, move |_| {
        let request = ExportRequest {
            file: Path::new(""),
            format: Format::Mjcf,
            form: session::form(rigid),
            set,
            control: None,
            watch: None,
        };
        session.mujoco_of_samples(&parameters, &request, &robots)
    })?;
    of_mujoco(py, names, &fields)
}
