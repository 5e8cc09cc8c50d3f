//! Arrays of NumPy as columns of a log, without copies, and the columns of simulated logs.

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyUntypedArrayMethods, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use sprung::log::{Array, Arrays};

use crate::arrow::Numbers;
use crate::errors::wrong_input;

/// Numbers in the memory of another owner.
struct Lent<T> {
    first: *const T,
    count: usize,
    // Keeps the memory alive.
    _owner: Py<PyAny>,
}

// SAFETY: the memory is only read, and the owner keeps it at its place. Python's users do not write
// to an array while a call reads it, as for every function of NumPy that releases the lock.
unsafe impl<T: Send> Send for Lent<T> {}
// SAFETY: see above.
unsafe impl<T: Sync> Sync for Lent<T> {}

impl<T> AsRef<[T]> for Lent<T> {
    fn as_ref(&self) -> &[T] {
        if self.count == 0 {
            return &[];
        }
        // SAFETY: `of` took pointer and length from one contiguous array, and `_owner` keeps it.
        unsafe { std::slice::from_raw_parts(self.first, self.count) }
    }
}

/// The arrays of one name: an array of one dimension, or one column for each joint.
pub(crate) fn arrays(array: &Bound<'_, PyAny>) -> PyResult<Vec<Array>> {
    if let Ok(numbers) = array.cast::<Numbers>() {
        return Ok(vec![numbers.get().0.clone()]);
    }
    if let Ok(array) = array.cast::<PyArray1<f64>>()
        && array.is_contiguous()
    {
        return Ok(vec![Array::float(Lent {
            first: array.data(),
            count: array.len(),
            _owner: array.clone().unbind().into_any(),
        })]);
    }
    if let Ok(array) = array.cast::<PyArray1<i64>>()
        && array.is_contiguous()
    {
        return Ok(vec![Array::integer(Lent {
            first: array.data(),
            count: array.len(),
            _owner: array.clone().unbind().into_any(),
        })]);
    }
    if let Ok(array) = array.cast::<PyArray2<f64>>() {
        let [rows, columns] = [array.shape()[0], array.shape()[1]];
        if array.is_c_contiguous() {
            let matrix = Lent {
                first: array.data(),
                count: array.len(),
                _owner: array.clone().unbind().into_any(),
            };
            return Ok(Array::columns(matrix, columns));
        }
        if array.is_fortran_contiguous() {
            let of = |column: usize| Lent {
                // SAFETY: the array has rows × columns numbers, column by column.
                first: unsafe { array.data().add(column * rows) }.cast_const(),
                count: rows,
                _owner: array.clone().unbind().into_any(),
            };
            return Ok((0..columns)
                .map(|column| Array::float(of(column)))
                .collect());
        }
    }
    Err(wrong_input(
        array.py(),
        "array",
        "an array is not one of contiguous float64 or int64 numbers with one or two dimensions",
        "convert it by numpy.ascontiguousarray(x, dtype=float)",
    ))
}

/// Named arrays as a log; columns of a matrix `q` are called `q[:,0]`, `q[:,1]`.
pub(crate) fn log(py: Python<'_>, named: Vec<(String, Bound<'_, PyAny>)>) -> PyResult<Arrays> {
    let mut columns = Vec::new();
    for (name, array) in named {
        let arrays = arrays(&array)?;
        let is_matrix = array.cast::<PyArray2<f64>>().is_ok();
        for (place, array) in arrays.into_iter().enumerate() {
            let name = if is_matrix {
                format!("{name}[:,{place}]")
            } else {
                name.clone()
            };
            columns.push((name, array));
        }
    }
    Arrays::new(columns)
        .map_err(|error| crate::errors::exception(py, &sprung::session::SessionError::from(error)))
}

/// Returns the columns of a CSV that the twin wrote, as arrays by name.
pub(crate) fn columns_by_name<'py>(py: Python<'py>, csv: &[u8]) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    for (name, numbers) in columns_of_csv(csv) {
        let array: Bound<'py, PyArray1<f64>> = numbers.to_pyarray(py);
        all.set_item(name, array)?;
    }
    Ok(all)
}

/// Returns the columns of a CSV that the twin wrote.
fn columns_of_csv(csv: &[u8]) -> Vec<(String, Vec<f64>)> {
    let text = String::from_utf8_lossy(csv);
    let mut lines = text.lines();
    let header = lines.next().unwrap_or_default();
    let mut columns: Vec<(String, Vec<f64>)> = header
        .split(',')
        .map(|name| (name.to_owned(), Vec::new()))
        .collect();
    for line in lines {
        for ((_, numbers), cell) in columns.iter_mut().zip(line.split(',')) {
            numbers.push(cell.parse().unwrap_or(f64::NAN));
        }
    }
    columns
}
