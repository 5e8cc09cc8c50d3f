//! Tables of Arrow, by its C stream interface.

use std::ffi::CStr;

use arrow_array::ffi_stream::{FFI_ArrowArrayStream, RecordBatchStreamReader};
use arrow_array::types::{
    ArrowPrimitiveType, Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type,
    UInt8Type, UInt16Type, UInt32Type,
};
use arrow_array::{Array, PrimitiveArray, RecordBatch, RecordBatchReader};
use arrow_schema::{DataType, TimeUnit};
use pyo3::prelude::*;
use pyo3::types::PyCapsule;
use sprung::log::Array as LogArray;

use crate::errors::wrong_input;

const STREAM: &CStr = c"arrow_array_stream";

/// Numbers that the library owns or borrows, for a log.
#[pyclass(frozen, module = "sprung._sprung")]
pub(crate) struct Numbers(pub(crate) LogArray);

#[pymethods]
impl Numbers {
    fn __len__(&self) -> usize {
        self.0.len()
    }
}

/// The columns of a table.
#[pyclass(frozen, module = "sprung._sprung")]
pub(crate) struct Columns {
    #[pyo3(get)]
    names: Vec<String>,
    #[pyo3(get)]
    arrays: Vec<Py<Numbers>>,
    /// Names of columns that are no numbers.
    #[pyo3(get)]
    others: Vec<String>,
}

#[pymethods]
impl Columns {
    /// Reads all columns of numbers of an object with `__arrow_c_stream__`.
    ///
    /// - `wanted`: names of the columns; all if empty.
    #[staticmethod]
    fn read(py: Python<'_>, table: &Bound<'_, PyAny>, wanted: Vec<String>) -> PyResult<Self> {
        let capsule = table.call_method0("__arrow_c_stream__")?;
        let capsule = capsule.cast::<PyCapsule>()?;
        let pointer = capsule.pointer_checked(Some(STREAM))?;
        // SAFETY: a capsule of this name holds a stream; reading it moves the stream out of it.
        let reader = unsafe {
            RecordBatchStreamReader::from_raw(pointer.as_ptr().cast::<FFI_ArrowArrayStream>())
        };
        let broken = |error: &dyn std::fmt::Display| {
            wrong_input(
                py,
                "arrow",
                &format!("the table cannot be read: {error}"),
                "give NumPy arrays instead",
            )
        };
        let reader = reader.map_err(|error| broken(&error))?;
        let schema = reader.schema();
        let batches: Vec<RecordBatch> = reader
            .collect::<Result<_, _>>()
            .map_err(|error| broken(&error))?;
        let mut columns = Self {
            names: Vec::new(),
            arrays: Vec::new(),
            others: Vec::new(),
        };
        for (place, field) in schema.fields().iter().enumerate() {
            if !wanted.is_empty() && !wanted.contains(field.name()) {
                continue;
            }
            let parts = batches.iter().map(|batch| &**batch.column(place));
            match column(&parts.collect::<Vec<_>>()) {
                Some(array) => {
                    columns.names.push(field.name().clone());
                    columns.arrays.push(Py::new(py, Numbers(array))?);
                }
                None => columns.others.push(field.name().clone()),
            }
        }
        Ok(columns)
    }
}

/// Returns the numbers of a column: without a copy if they are in one piece, integers exactly, other
/// numbers as floats with NaN for nulls; `None` if it has no numbers.
fn column(parts: &[&dyn Array]) -> Option<LogArray> {
    let kind = (parts.first()).map_or(DataType::Float64, |part| part.data_type().clone());
    if parts.iter().all(|part| part.null_count() == 0) {
        if let [part] = parts {
            let any = part.as_any();
            if let Some(floats) = any.downcast_ref::<PrimitiveArray<Float64Type>>() {
                return Some(LogArray::float(floats.values().clone()));
            }
            if let Some(integers) = any.downcast_ref::<PrimitiveArray<Int64Type>>() {
                return Some(LogArray::integer(integers.values().clone()));
            }
        }
        let integers = match kind {
            DataType::Int64 => values::<Int64Type, i64>(parts, i64::from),
            DataType::Timestamp(unit, _) => stamps(parts, unit),
            _ => None,
        };
        if let Some(integers) = integers {
            return Some(LogArray::integer(integers));
        }
    }
    let floats = match kind {
        DataType::Float64 => values::<Float64Type, f64>(parts, |x| x),
        DataType::Float32 => values::<Float32Type, f64>(parts, f64::from),
        DataType::Int64 => values::<Int64Type, f64>(parts, |x| x as f64),
        DataType::Int32 => values::<Int32Type, f64>(parts, f64::from),
        DataType::Int16 => values::<Int16Type, f64>(parts, f64::from),
        DataType::Int8 => values::<Int8Type, f64>(parts, f64::from),
        DataType::UInt32 => values::<UInt32Type, f64>(parts, f64::from),
        DataType::UInt16 => values::<UInt16Type, f64>(parts, f64::from),
        DataType::UInt8 => values::<UInt8Type, f64>(parts, f64::from),
        _ => None,
    };
    Some(LogArray::float(floats?))
}

/// A number that a null becomes.
trait Missing {
    const MISSING: Self;
}

impl Missing for f64 {
    const MISSING: Self = f64::NAN;
}

impl Missing for i64 {
    const MISSING: Self = 0;
}

fn values<A: ArrowPrimitiveType, T: Missing>(
    parts: &[&dyn Array],
    convert: impl Fn(A::Native) -> T,
) -> Option<Vec<T>> {
    let mut all = Vec::with_capacity(parts.iter().map(|part| part.len()).sum());
    for part in parts {
        let part = part.as_any().downcast_ref::<PrimitiveArray<A>>()?;
        all.extend(part.iter().map(|value| value.map_or(T::MISSING, &convert)));
    }
    Some(all)
}

/// Returns time stamps in ns.
fn stamps(parts: &[&dyn Array], unit: TimeUnit) -> Option<Vec<i64>> {
    use arrow_array::types::{
        TimestampMicrosecondType, TimestampMillisecondType, TimestampNanosecondType,
        TimestampSecondType,
    };
    let times = |factor: i64| move |stamp: i64| stamp.saturating_mul(factor);
    match unit {
        TimeUnit::Second => values::<TimestampSecondType, i64>(parts, times(1_000_000_000)),
        TimeUnit::Millisecond => values::<TimestampMillisecondType, i64>(parts, times(1_000_000)),
        TimeUnit::Microsecond => values::<TimestampMicrosecondType, i64>(parts, times(1_000)),
        TimeUnit::Nanosecond => values::<TimestampNanosecondType, i64>(parts, times(1)),
    }
}
