//! Lists in the columns of Parquet and Arrow: their lengths, and the names of their elements.

use std::io::BufReader;

use arrow_array::cast::AsArray;
use arrow_array::{Array, RecordBatch};
use arrow_schema::{ArrowError, DataType, Schema};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::errors::ParquetError;

use super::arrow_shared::Shared;
use super::damaged::damaged;
use super::table::{NAMES, Reopen};
use crate::error::LogError;
use crate::input::Kind;

/// Most elements of a list that become columns.
const MAX_ELEMENTS: usize = 1 << 12;

/// A step into a structure or a list.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Step {
    Field(usize),
    Element(usize),
    /// The element with this name; another list in the same row names the elements.
    Named(String),
}

/// The lists of numbers in the first row of a file.
#[derive(Clone, Debug, Default)]
pub(super) struct Lists {
    /// Indices of the columns and the numbers of their elements.
    lengths: Vec<(usize, usize)>,
    /// Index of the column that names the elements, and the names in the first row.
    names: Option<(usize, Vec<String>)>,
}

impl Lists {
    /// Reads the first row of the columns that hold lists.
    ///
    /// # Errors
    ///
    /// [`LogError`] if the file is damaged.
    pub(super) fn of(file: &str, kind: Kind, reopen: Reopen<'_>) -> Result<Self, LogError> {
        let failed = |error: ArrowError| damaged(file, &error);
        let of_parquet = |error: ParquetError| damaged(file, &error);
        let input = reopen()?;
        // Index in the file of each column of the batch.
        let columns: Vec<usize>;
        let batch = if kind == Kind::Parquet {
            let shared = Shared::new(input).map_err(|error| LogError::read(file, "it", error))?;
            let builder = ParquetRecordBatchReaderBuilder::try_new(shared).map_err(of_parquet)?;
            columns = lists_of(builder.schema());
            if columns.is_empty() {
                return Ok(Self::default());
            }
            let mask = ProjectionMask::roots(builder.parquet_schema(), columns.clone());
            let reader = builder.with_projection(mask).with_batch_size(1).build();
            reader.map_err(of_parquet)?.next().transpose()
        } else {
            let read = BufReader::new(input);
            let is_file = kind == Kind::ArrowFile;
            let (schema, mut batches): (_, Box<dyn Iterator<Item = _>>) = if is_file {
                let reader = arrow_ipc::reader::FileReader::try_new(read, None).map_err(failed)?;
                (reader.schema(), Box::new(reader))
            } else {
                let reader =
                    arrow_ipc::reader::StreamReader::try_new(read, None).map_err(failed)?;
                (reader.schema(), Box::new(reader))
            };
            if lists_of(&schema).is_empty() {
                return Ok(Self::default());
            }
            columns = (0..schema.fields().len()).collect();
            batches
                .find(|batch| !matches!(batch, Ok(batch) if batch.num_rows() == 0))
                .transpose()
        };
        let batch = batch.map_err(failed)?;
        Ok(batch.map_or_else(Self::default, |batch| Self::in_row(&batch, &columns)))
    }

    /// - `columns`: index in the file of each column of the batch.
    fn in_row(batch: &RecordBatch, columns: &[usize]) -> Self {
        let mut lists = Self::default();
        let schema = batch.schema();
        for ((array, field), &column) in batch.columns().iter().zip(schema.fields()).zip(columns) {
            let Some(list) = list_at(&**array, 0) else {
                continue;
            };
            if is_text(list.data_type()) {
                if NAMES.contains(&field.name().as_str()) {
                    let names = (0..list.len()).filter_map(|k| text_at(&*list, k));
                    lists.names = Some((column, names.map(str::to_owned).collect()));
                }
            } else {
                lists.lengths.push((column, list.len().min(MAX_ELEMENTS)));
            }
        }
        lists
    }

    /// Returns the elements of the lists in a column: their names or indices, and the step to them.
    pub(super) fn elements(&self, column: usize) -> Vec<(String, Step)> {
        let length = self.lengths.iter().find(|(other, _)| *other == column);
        let length = length.map_or(0, |(_, length)| *length);
        match &self.names {
            Some((_, names)) if names.len() == length => (names.iter())
                .map(|name| (name.clone(), Step::Named(name.clone())))
                .collect(),
            _ => (0..length)
                .map(|k| (k.to_string(), Step::Element(k)))
                .collect(),
        }
    }

    /// Returns the index of the column with the names of the elements, if one of the ways needs it.
    pub(super) fn names_for<'a>(
        &self,
        mut ways: impl Iterator<Item = &'a [Step]>,
    ) -> Option<usize> {
        let (column, _) = self.names.as_ref()?;
        ways.any(|steps| matches!(steps, [Step::Named(_)]))
            .then_some(*column)
    }
}

/// Returns the indices of the columns that hold lists.
fn lists_of(schema: &Schema) -> Vec<usize> {
    let is_list = |kind: &DataType| {
        matches!(
            kind,
            DataType::List(_) | DataType::LargeList(_) | DataType::FixedSizeList(..)
        )
    };
    (schema.fields().iter().enumerate())
        .filter(|(_, field)| is_list(field.data_type()))
        .map(|(column, _)| column)
        .collect()
}

fn is_text(kind: &DataType) -> bool {
    matches!(
        kind,
        DataType::Utf8 | DataType::LargeUtf8 | DataType::Utf8View
    )
}

/// Returns the list in a row; `None` for another type and for a null.
fn list_at(array: &dyn Array, row: usize) -> Option<arrow_array::ArrayRef> {
    if row >= array.len() || array.is_null(row) {
        return None;
    }
    match array.data_type() {
        DataType::FixedSizeList(..) => Some(array.as_fixed_size_list().value(row)),
        DataType::List(_) => Some(array.as_list::<i32>().value(row)),
        DataType::LargeList(_) => Some(array.as_list::<i64>().value(row)),
        _ => None,
    }
}

fn text_at(array: &dyn Array, k: usize) -> Option<&str> {
    match array.data_type() {
        DataType::Utf8 => Some(array.as_string::<i32>().value(k)),
        DataType::LargeUtf8 => Some(array.as_string::<i64>().value(k)),
        DataType::Utf8View => Some(array.as_string_view().value(k)),
        _ => None,
    }
}

/// Returns the index of the element with this name in a row.
///
/// - `names`: the column that names the elements.
pub(super) fn place_of(names: &dyn Array, row: usize, name: &str) -> Option<usize> {
    let list = list_at(names, row)?;
    (0..list.len()).find(|&k| text_at(&*list, k) == Some(name))
}
