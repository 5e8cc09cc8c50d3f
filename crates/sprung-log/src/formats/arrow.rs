//! Parquet and Arrow IPC.

use std::io::BufReader;

use arrow_array::cast::AsArray;
use arrow_array::types::{
    DurationMicrosecondType, DurationMillisecondType, DurationNanosecondType, DurationSecondType,
    Float16Type, Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type,
    TimestampMicrosecondType, TimestampMillisecondType, TimestampNanosecondType,
    TimestampSecondType, UInt8Type, UInt16Type, UInt32Type, UInt64Type,
};
use arrow_array::{Array, ArrowNativeTypeOp, ArrowPrimitiveType, RecordBatch};
use arrow_schema::{ArrowError, DataType, Schema, TimeUnit};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::errors::ParquetError;

use super::arrow_claims::refuse_absurd;
use super::arrow_lists::{Lists, Step, place_of};
use super::arrow_shared::Shared;
use super::damaged::{damaged, guarded};
use super::table::{Opened, Readings, Reopen, Request, Table};
use crate::block::BLOCK;
use crate::columns::names::Names;
use crate::columns::origin::Pick;
use crate::description::ColumnName;
use crate::error::{LogError, Place};
use crate::input::Kind;
use crate::input_limits::COLUMNS;

type Batches = Box<dyn Iterator<Item = Result<RecordBatch, ArrowError>> + Send>;

/// A wanted column: its index in a batch, and the steps to the number in it.
#[derive(Clone, Debug)]
struct Wanted {
    column: usize,
    steps: Vec<Step>,
    name: String,
}

struct BatchTable {
    file: String,
    batches: Batches,
    wanted: Vec<Wanted>,
    batch: Option<RecordBatch>,
    // Rows of the batch that were read.
    done: usize,
    // Index of the column that names the elements of lists, if names are wanted.
    names: Option<usize>,
    // Rows of the file before the last block, and rows of the last block.
    before: u64,
    read: u64,
}

/// Opens a Parquet file or an Arrow file or stream.
pub(super) fn open(
    request: &Request<'_>,
    kind: Kind,
    reopen: Reopen<'_>,
) -> Result<Opened, LogError> {
    let file = request.file;
    if let Some(topic) = request.topic {
        return Err(LogError::format(
            request.whole_file(),
            format!(" is a table and has no topics, so there is no \"{topic}\"; name columns"),
        ));
    }
    let failed = |error: ArrowError| damaged(file, &error);
    let of_parquet = |error: ParquetError| damaged(file, &error);
    if kind != Kind::Parquet {
        guarded(file, || refuse_absurd(file, kind, reopen()?))?;
    }
    let lists = guarded(file, || Lists::of(file, kind, reopen))?;
    let input = reopen()?;
    let (schema, batches, wanted, names) = guarded(file, || match kind {
        Kind::Parquet => {
            let shared = Shared::new(input).map_err(|error| LogError::read(file, "it", error))?;
            let builder = ParquetRecordBatchReaderBuilder::try_new(shared).map_err(of_parquet)?;
            let schema = builder.schema().clone();
            let mut wanted = find(request, &schema, &lists)?;
            let names = lists.names_for(wanted.iter().map(|one| &one.steps[..]));
            // The reader returns only these columns, in the order of the file.
            let mut roots: Vec<usize> = wanted.iter().map(|one| one.column).chain(names).collect();
            roots.sort_unstable();
            roots.dedup();
            let among_roots =
                |column: usize| roots.iter().position(|&r| r == column).unwrap_or_default();
            for one in &mut wanted {
                one.column = among_roots(one.column);
            }
            let names = names.map(among_roots);
            let mask = ProjectionMask::roots(builder.parquet_schema(), roots);
            let reader = builder.with_projection(mask).with_batch_size(BLOCK).build();
            let batches: Batches = Box::new(reader.map_err(of_parquet)?);
            Ok((schema, batches, wanted, names))
        }
        Kind::ArrowFile => {
            let read = BufReader::new(input);
            let reader = arrow_ipc::reader::FileReader::try_new(read, None).map_err(failed)?;
            let schema = reader.schema();
            let wanted = find(request, &schema, &lists)?;
            let names = lists.names_for(wanted.iter().map(|one| &one.steps[..]));
            Ok((schema, Box::new(reader), wanted, names))
        }
        _ => {
            let read = BufReader::new(input);
            let reader = arrow_ipc::reader::StreamReader::try_new(read, None).map_err(failed)?;
            let schema = reader.schema();
            let wanted = find(request, &schema, &lists)?;
            let names = lists.names_for(wanted.iter().map(|one| &one.steps[..]));
            Ok((schema, Box::new(reader), wanted, names))
        }
    })?;
    let time = request.time.map(|time| &wanted[time]);
    let time_unit = time
        .and_then(|time| schema.field_with_name(&time.name).ok())
        .and_then(|field| unit_of(field.data_type()));
    let of_wanted = wanted.iter().map(|one| one.name.clone()).collect();
    let table = BatchTable {
        file: file.to_owned(),
        batches,
        wanted,
        names,
        batch: None,
        done: 0,
        before: 0,
        read: 0,
    };
    Ok(Opened {
        table: Box::new(table),
        names: of_wanted,
        time_unit,
        all: columns(&schema, &lists).0,
        has_names: true,
        units: Vec::new(),
    })
}

/// Returns the names of all columns, and the steps to those that are within another column; these
/// come last.
fn columns(schema: &Schema, lists: &Lists) -> (Vec<String>, Vec<(usize, Vec<Step>)>) {
    let mut all: Vec<String> = (schema.fields().iter())
        .map(|field| field.name().clone())
        .collect();
    let mut inner: Vec<(usize, Vec<Step>)> = Vec::new();
    for (column, field) in schema.fields().iter().enumerate() {
        match field.data_type() {
            DataType::FixedSizeList(..) | DataType::List(_) | DataType::LargeList(_) => {
                for (name, step) in lists.elements(column) {
                    all.push(format!("{}[{name}]", field.name()));
                    inner.push((column, vec![step]));
                }
            }
            DataType::Struct(fields) => {
                for (k, child) in fields.iter().enumerate() {
                    all.push(format!("{}.{}", field.name(), child.name()));
                    inner.push((column, vec![Step::Field(k)]));
                }
            }
            _ => {}
        }
    }
    (all, inner)
}

/// Finds the wanted columns.
fn find(request: &Request<'_>, schema: &Schema, lists: &Lists) -> Result<Vec<Wanted>, LogError> {
    let (all, inner) = columns(schema, lists);
    if all.len() > COLUMNS {
        return Err(LogError::format(
            request.file,
            format!(
                " has {} columns, and a log has at most {COLUMNS}; write those of the robot alone",
                all.len()
            ),
        ));
    }
    let plain = all.len() - inner.len();
    let names = Names {
        file: request.file,
        all: &all,
        given: true,
    };
    (request.picks.iter())
        .map(|pick| {
            let place = match names.find(pick) {
                Ok(place) => place,
                Err(error) => {
                    return element(schema, pick).ok_or(error);
                }
            };
            let (column, steps) = match place.checked_sub(plain) {
                None => (place, Vec::new()),
                Some(k) => inner[k].clone(),
            };
            Ok(Wanted {
                column,
                steps,
                name: all[place].clone(),
            })
        })
        .collect()
}

/// Finds an element of a list of any length, `q[0]`.
fn element(schema: &Schema, pick: &Pick) -> Option<Wanted> {
    let Pick::Column(ColumnName::Name(name)) = pick else {
        return None;
    };
    let (list, index) = name.strip_suffix(']')?.split_once('[')?;
    let column = schema.index_of(list).ok()?;
    let is_list = matches!(
        schema.field(column).data_type(),
        DataType::List(_) | DataType::LargeList(_) | DataType::FixedSizeList(..)
    );
    let index = index.parse().ok().filter(|_| is_list)?;
    Some(Wanted {
        column,
        steps: vec![Step::Element(index)],
        name: name.clone(),
    })
}

fn unit_of(kind: &DataType) -> Option<f64> {
    match kind {
        DataType::Timestamp(unit, _) | DataType::Duration(unit) => Some(match unit {
            TimeUnit::Second => 1.0,
            TimeUnit::Millisecond => 1e-3,
            TimeUnit::Microsecond => 1e-6,
            TimeUnit::Nanosecond => 1e-9,
        }),
        _ => None,
    }
}

impl Table for BatchTable {
    fn read(&mut self, limit: usize, out: &mut [Readings]) -> Result<usize, LogError> {
        self.before += self.read;
        self.read = 0;
        let batch = loop {
            match &self.batch {
                Some(batch) if self.done < batch.num_rows() => break batch.clone(),
                _ => {
                    let (file, batches) = (&self.file, &mut self.batches);
                    let next = guarded(file, || {
                        let next = batches.next().transpose();
                        next.map_err(|error| damaged(file, &error))
                    })?;
                    let Some(next) = next else { return Ok(0) };
                    self.batch = Some(next);
                    self.done = 0;
                }
            }
        };
        let count = limit.min(batch.num_rows() - self.done);
        let names = self.names.map(|names| batch.column(names));
        for (wanted, out) in self.wanted.iter().zip(out) {
            let column = batch.column(wanted.column);
            for row in self.done..self.done + count {
                let found = match &wanted.steps[..] {
                    [Step::Named(name)] => names
                        .and_then(|names| place_of(&**names, row, name))
                        .and_then(|k| push(&**column, &[Step::Element(k)], row, out)),
                    steps => push(&**column, steps, row, out),
                };
                found.ok_or_else(|| {
                    let place = Place::Row(self.before + (row - self.done) as u64 + 1);
                    unreadable(&self.file, place, &wanted.name, column.data_type())
                })?;
            }
        }
        self.done += count;
        self.read = count as u64;
        Ok(count)
    }

    fn place(&self, i: usize) -> Place {
        Place::Row(self.before + i as u64 + 1)
    }
}

#[cold]
fn unreadable(file: &str, place: Place, name: &str, kind: &DataType) -> LogError {
    let message = match kind {
        DataType::List(_) | DataType::LargeList(_) | DataType::FixedSizeList(..) => format!(
            ": {place}: column \"{name}\" holds lists that are too short or empty; name an element, \
             as \"{name}[0]\""
        ),
        DataType::Struct(_) => {
            format!(": column \"{name}\" holds structures; name a field, as \"{name}.position\"")
        }
        _ => format!(": column \"{name}\" is of type {kind}, which is no number"),
    };
    LogError::format(file, message)
}

/// Appends the number of a row, NaN for a null; returns `None` if the column contains no numbers.
fn push(array: &dyn Array, steps: &[Step], row: usize, out: &mut Readings) -> Option<()> {
    if array.is_null(row) {
        out.push(f64::NAN);
        return Some(());
    }
    if let Some((step, rest)) = steps.split_first() {
        return match (step, array.data_type()) {
            (Step::Field(k), DataType::Struct(_)) => {
                push(&**array.as_struct().columns().get(*k)?, rest, row, out)
            }
            (Step::Element(k), DataType::FixedSizeList(..)) => {
                of_list(&array.as_fixed_size_list().value(row), *k, rest, out)
            }
            (Step::Element(k), DataType::List(_)) => {
                of_list(&array.as_list::<i32>().value(row), *k, rest, out)
            }
            (Step::Element(k), DataType::LargeList(_)) => {
                of_list(&array.as_list::<i64>().value(row), *k, rest, out)
            }
            _ => None,
        };
    }
    match array.data_type() {
        DataType::Float64 => out.push(array.as_primitive::<Float64Type>().value(row)),
        DataType::Float32 => out.push(f64::from(array.as_primitive::<Float32Type>().value(row))),
        DataType::Float16 => out.push(array.as_primitive::<Float16Type>().value(row).to_f64()),
        DataType::Boolean => out.push(f64::from(u8::from(array.as_boolean().value(row)))),
        DataType::Int8 => integer::<Int8Type>(array, row, out),
        DataType::Int16 => integer::<Int16Type>(array, row, out),
        DataType::Int32 => integer::<Int32Type>(array, row, out),
        DataType::Int64 => integer::<Int64Type>(array, row, out),
        DataType::UInt8 => integer::<UInt8Type>(array, row, out),
        DataType::UInt16 => integer::<UInt16Type>(array, row, out),
        DataType::UInt32 => integer::<UInt32Type>(array, row, out),
        DataType::UInt64 => match i64::try_from(array.as_primitive::<UInt64Type>().value(row)) {
            Ok(value) => out.push_integer(value),
            Err(_) => out.push(array.as_primitive::<UInt64Type>().value(row) as f64),
        },
        DataType::Timestamp(unit, _) => match unit {
            TimeUnit::Second => integer::<TimestampSecondType>(array, row, out),
            TimeUnit::Millisecond => integer::<TimestampMillisecondType>(array, row, out),
            TimeUnit::Microsecond => integer::<TimestampMicrosecondType>(array, row, out),
            TimeUnit::Nanosecond => integer::<TimestampNanosecondType>(array, row, out),
        },
        DataType::Duration(unit) => match unit {
            TimeUnit::Second => integer::<DurationSecondType>(array, row, out),
            TimeUnit::Millisecond => integer::<DurationMillisecondType>(array, row, out),
            TimeUnit::Microsecond => integer::<DurationMicrosecondType>(array, row, out),
            TimeUnit::Nanosecond => integer::<DurationNanosecondType>(array, row, out),
        },
        _ => return None,
    }
    Some(())
}

fn of_list(list: &dyn Array, k: usize, rest: &[Step], out: &mut Readings) -> Option<()> {
    (k < list.len()).then(|| push(list, rest, k, out))?
}

fn integer<T: ArrowPrimitiveType>(array: &dyn Array, row: usize, out: &mut Readings)
where
    T::Native: Into<i64> + ArrowNativeTypeOp,
{
    out.push_integer(array.as_primitive::<T>().value(row).into());
}
