//! The functions of an identified robot, for one or many states.

use std::sync::{Mutex, PoisonError};

use numpy::ndarray::{Array2, Array3, ArrayView2};
use numpy::{PyArray2, PyArray3, PyReadonlyArray2, ToPyArray};
use pyo3::prelude::*;
use sprung::simulate::{Accelerations, BothTorques, JointState};

use crate::errors::wrong_input;

/// States or motions of the joints, \[samples × joints\] each.
type Matrix<'py> = PyReadonlyArray2<'py, f64>;

/// A robot with known parameters.
#[pyclass(frozen, module = "sprung._sprung")]
pub(crate) struct Dynamics {
    inner: Mutex<sprung::simulate::Dynamics>,
}

impl Dynamics {
    pub(crate) fn new(inner: sprung::simulate::Dynamics) -> Self {
        Self {
            inner: Mutex::new(inner),
        }
    }

    /// Computes a vector for each sample.
    fn each<'py>(
        &self,
        py: Python<'py>,
        given: &[&Matrix<'_>],
        length: impl Fn(&sprung::simulate::Dynamics) -> usize + Send + Sync,
        compute: impl Fn(&mut sprung::simulate::Dynamics, &[Vec<f64>]) -> Vec<f64> + Send + Sync,
    ) -> Bound<'py, PyArray2<f64>> {
        let views: Vec<ArrayView2<'_, f64>> =
            given.iter().map(|matrix| matrix.as_array()).collect();
        let all = py.detach(|| {
            let mut dynamics = self.inner.lock().unwrap_or_else(PoisonError::into_inner);
            let samples = views.first().map_or(0, ArrayView2::nrows);
            let mut all = Array2::zeros((samples, length(&dynamics)));
            for (k, mut row) in all.rows_mut().into_iter().enumerate() {
                let rows: Vec<Vec<f64>> = views.iter().map(|view| view.row(k).to_vec()).collect();
                for (to, from) in row.iter_mut().zip(compute(&mut dynamics, &rows)) {
                    *to = from;
                }
            }
            all
        });
        all.to_pyarray(py)
    }
}

fn state(rows: &[Vec<f64>]) -> JointState {
    JointState {
        q: rows[0].clone(),
        dq: rows[1].clone(),
        phi: rows[2].clone(),
        dphi: rows[3].clone(),
    }
}

fn accelerations(rows: &[Vec<f64>]) -> Accelerations {
    Accelerations {
        ddq: rows[0].clone(),
        ddphi: rows[1].clone(),
    }
}

fn both(torques: BothTorques) -> Vec<f64> {
    [torques.link, torques.motor].concat()
}

#[pymethods]
impl Dynamics {
    #[getter]
    fn joints(&self) -> usize {
        self.inner
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .joints()
    }

    /// Names of the rows of the regressor.
    #[getter]
    fn rows(&self) -> Vec<String> {
        let dynamics = self.inner.lock().unwrap_or_else(PoisonError::into_inner);
        (0..dynamics.coordinates())
            .map(|row| dynamics.model().row_name(row))
            .collect()
    }

    /// Names and values of the parameters.
    #[getter]
    fn parameters(&self) -> Vec<(String, f64)> {
        let dynamics = self.inner.lock().unwrap_or_else(PoisonError::into_inner);
        let names = dynamics
            .model()
            .parameters()
            .iter()
            .map(|one| one.name.clone());
        names.zip(dynamics.theta().iter().copied()).collect()
    }

    fn gravity<'py>(&self, py: Python<'py>, q: Matrix<'_>) -> Bound<'py, PyArray2<f64>> {
        self.each(
            py,
            &[&q],
            sprung::simulate::Dynamics::joints,
            |dynamics, rows| dynamics.gravity(&rows[0]),
        )
    }

    fn coriolis_torques<'py>(
        &self,
        py: Python<'py>,
        q: Matrix<'_>,
        dq: Matrix<'_>,
    ) -> Bound<'py, PyArray2<f64>> {
        self.each(
            py,
            &[&q, &dq],
            sprung::simulate::Dynamics::joints,
            |dynamics, rows| dynamics.coriolis(&rows[0], &rows[1]),
        )
    }

    /// Mass matrices, \[samples × coordinates²\].
    fn mass_matrix<'py>(&self, py: Python<'py>, q: Matrix<'_>) -> Bound<'py, PyArray2<f64>> {
        let length =
            |dynamics: &sprung::simulate::Dynamics| dynamics.coordinates() * dynamics.coordinates();
        self.each(py, &[&q], length, |dynamics, rows| {
            dynamics.mass_matrix(&rows[0])
        })
    }

    /// Torques on links and motors, \[samples × 2 joints\].
    fn friction<'py>(&self, py: Python<'py>, motion: [Matrix<'_>; 4]) -> Bound<'py, PyArray2<f64>> {
        let given: Vec<&Matrix<'_>> = motion.iter().collect();
        self.each(
            py,
            &given,
            |dynamics| 2 * dynamics.joints(),
            |dynamics, rows| both(dynamics.friction(&state(rows))),
        )
    }

    fn spring<'py>(&self, py: Python<'py>, motion: [Matrix<'_>; 4]) -> Bound<'py, PyArray2<f64>> {
        let given: Vec<&Matrix<'_>> = motion.iter().collect();
        self.each(
            py,
            &given,
            sprung::simulate::Dynamics::joints,
            |dynamics, rows| dynamics.spring(&state(rows)),
        )
    }

    /// Torques on links and motors, \[samples × 2 joints\].
    fn predict<'py>(&self, py: Python<'py>, motion: [Matrix<'_>; 6]) -> Bound<'py, PyArray2<f64>> {
        let given: Vec<&Matrix<'_>> = motion.iter().collect();
        self.each(
            py,
            &given,
            |dynamics| 2 * dynamics.joints(),
            |dynamics, rows| {
                both(dynamics.inverse_dynamics(&state(rows), &accelerations(&rows[4..])))
            },
        )
    }

    /// Regressors, \[samples × coordinates · parameters\].
    fn regressor<'py>(
        &self,
        py: Python<'py>,
        motion: [Matrix<'_>; 6],
    ) -> Bound<'py, PyArray2<f64>> {
        let given: Vec<&Matrix<'_>> = motion.iter().collect();
        let length =
            |dynamics: &sprung::simulate::Dynamics| dynamics.coordinates() * dynamics.theta().len();
        self.each(py, &given, length, |dynamics, rows| {
            dynamics.regressor(&state(rows), &accelerations(&rows[4..]))
        })
    }

    /// Accelerations of links and motors, \[samples × 2 joints\].
    ///
    /// - `motion`: state, torques of the motors, torques on the links.
    fn forward_dynamics<'py>(
        &self,
        py: Python<'py>,
        motion: [Matrix<'_>; 6],
    ) -> Bound<'py, PyArray2<f64>> {
        let given: Vec<&Matrix<'_>> = motion.iter().collect();
        self.each(
            py,
            &given,
            |dynamics| 2 * dynamics.joints(),
            |dynamics, rows| {
                let torques = BothTorques {
                    motor: rows[4].clone(),
                    link: rows[5].clone(),
                };
                let found = dynamics.forward_dynamics(&state(rows), &torques);
                [found.ddq, found.ddphi].concat()
            },
        )
    }

    /// Simulates a motion; returns q, dq, phi and dphi, \[4 × samples + 1 × joints\].
    fn simulate<'py>(
        &self,
        py: Python<'py>,
        start: [Vec<f64>; 4],
        torques: Matrix<'_>,
        period: f64,
    ) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let [q, dq, phi, dphi] = start;
        let start = JointState { q, dq, phi, dphi };
        let rows: Vec<Vec<f64>> = torques
            .as_array()
            .rows()
            .into_iter()
            .map(|row| row.to_vec())
            .collect();
        let found = py.detach(|| {
            let dynamics = self
                .inner
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .clone();
            dynamics.simulate(&start, rows.iter().map(Vec::as_slice), period)
        });
        let states = found.map_err(|error| {
            let text = error.to_string();
            let (text, remedy) = text.split_once("; ").unwrap_or((&text, ""));
            wrong_input(py, "ran-away", text, remedy)
        })?;
        let n = start.q.len();
        let all = Array3::from_shape_fn((4, states.len(), n), |(part, k, joint)| {
            let state = &states[k];
            [&state.q, &state.dq, &state.phi, &state.dphi][part][joint]
        });
        Ok(all.to_pyarray(py))
    }
}
