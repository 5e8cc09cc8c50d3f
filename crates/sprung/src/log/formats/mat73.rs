//! MATLAB files of version 7.3: HDF5 with conventions of its own.
//!
//! A structure is a group, an array a dataset whose sides stand in reverse order; what MATLAB calls
//! it says the attribute `MATLAB_class`. Elements of structure arrays and cells lie in `#refs#` and
//! are pointed at. libhdf5 opens the file itself, so a log in memory cannot be read.

use std::io::ErrorKind;

use hdf5_metno::types::{FixedAscii, FloatSize, IntSize, Reference, TypeDescriptor};
use hdf5_metno::{
    Dataset, Error, File, Group, IndexType, IterationOrder, LinkType, Location, LocationType,
    ObjectReference1, ReferencedObject, Result as Hdf5Result, Selection, SliceOrIndex,
};

use super::array_shape::{Sides, no_topics, same_rows};
use super::damaged::guarded;
use super::matlab::find;
use super::number::Reading;
use super::table::{Opened, Readings, Reopen, Request, Table};
use crate::log::columns::names::{Names, Refused};
use crate::log::error::{LogError, Place};

/// Structures within structures that are believed.
const MAX_NESTING: usize = 16;

/// Variables, fields and elements of structures that are looked at.
const MAX_ENTRIES: usize = 1 << 16;

/// Numbers of a column that are read at once: at least so many, and those of a chunk if it has
/// more, so that none is unpacked twice; but no more than would take much memory.
const NUMBERS_AT_ONCE: std::ops::RangeInclusive<u64> = (1 << 13)..=(1 << 20);

/// How many times smaller packed numbers are at most; deflate does not reach 1032.
const MAX_COMPRESSION_RATIO: u64 = 4096;

/// Opens a MATLAB file.
pub(super) fn open(request: &Request<'_>, reopen: Reopen<'_>) -> Result<Opened, LogError> {
    no_topics(request)?;
    let file = request.file;
    let input = reopen()?;
    let Some(path) = input.path() else {
        return Err(LogError::format(
            file,
            " is a MATLAB file of version 7.3 (HDF5), which is read from a file and not from memory; \
             write it to one, or save it with save(…, \"-v7\")",
        ));
    };
    let what = "one of its variables";
    let contents = guarded(file, || {
        let read = || Contents::of(&File::open(path)?);
        read().map_err(|error| failed(file, what, &error))
    })?;
    let mut all = Vec::new();
    let mut columns = Vec::new();
    for array in &contents.arrays {
        for (name, place) in array.sides.columns_of(&array.name) {
            all.push(name);
            columns.push((array, place));
        }
    }
    let names = Names {
        file,
        all: &all,
        given: true,
    };
    let places = (request.picks.iter())
        .map(|pick| find(&names, pick, &contents.refused))
        .collect::<Result<Vec<usize>, LogError>>()?;
    let rows = same_rows(file, &places, |place| {
        (&all[place], columns[place].0.sides.samples())
    })?;
    let column_at = |&place: &usize| {
        let (array, column) = columns[place];
        guarded(file, || {
            Column::new(format!("\"{}\"", all[place]), array, column)
                .map_err(|error| failed(file, &all[place], &error))
        })
    };
    Ok(Opened {
        table: Box::new(Mat73 {
            file: file.to_owned(),
            columns: places.iter().map(column_at).collect::<Result<_, _>>()?,
            rows,
            before: 0,
            done: 0,
        }),
        names: places.iter().map(|&place| all[place].clone()).collect(),
        time_unit: None,
    })
}

/// Returns what libhdf5 says as an error of the file.
fn failed(file: &str, what: &str, error: &Error) -> LogError {
    let text = error.to_string();
    let cut = ["truncated", "eof", "past end", "addr overflow"];
    let kind = if cut.iter().any(|word| text.contains(word)) {
        ErrorKind::UnexpectedEof
    } else {
        ErrorKind::InvalidData
    };
    let short: String = text.chars().take(200).collect();
    LogError::read(file, what, std::io::Error::new(kind, short))
}

/// An array of numbers in a file.
struct Array {
    /// As MATLAB writes it: `t`, `data.q`, `s(2).values`.
    name: String,
    sides: Sides,
    dataset: Dataset,
    stored: Stored,
}

/// How numbers are handed over; libhdf5 converts the rest.
#[derive(Clone, Copy)]
enum Stored {
    Float,
    Integer,
    /// Beyond the largest signed integer.
    Unsigned,
}

/// What a file holds.
#[derive(Default)]
struct Contents {
    arrays: Vec<Array>,
    refused: Vec<Refused>,
    seen: usize,
}

impl Contents {
    fn of(file: &File) -> Hdf5Result<Self> {
        let mut contents = Self::default();
        contents.group(file, "", 0)?;
        Ok(contents)
    }

    /// Goes through the variables of a file, or the fields of a structure.
    fn group(&mut self, group: &Group, path: &str, depth: usize) -> Hdf5Result<()> {
        if depth > MAX_NESTING {
            return Err("structures within structures without end".into());
        }
        for (link, info) in group.links(IndexType::Name, IterationOrder::Increasing)? {
            // MATLAB keeps there what references point at.
            let own = depth == 0 && link.starts_with('#');
            if own || info.link_type != LinkType::Hard {
                continue;
            }
            let name = match path {
                "" => link.clone(),
                _ => format!("{path}.{link}"),
            };
            // Which kinds there are besides depends on the version of libhdf5.
            let kind = group.loc_type_by_name(&link)?;
            if kind == LocationType::Group {
                self.structure(&group.group(&link)?, &name, depth)?;
            } else if kind == LocationType::Dataset {
                self.dataset(group.dataset(&link)?, &name, depth)?;
            } else {
                self.refuse(&name, "is of a type that is not read");
            }
        }
        Ok(())
    }

    fn structure(&mut self, group: &Group, name: &str, depth: usize) -> Hdf5Result<()> {
        self.count()?;
        if group.attr("MATLAB_sparse").is_ok() {
            self.refuse(name, "is sparse; save full(…) of it");
            return Ok(());
        }
        match class_of(group).as_deref() {
            None | Some("struct") => self.group(group, name, depth + 1),
            Some(_) => {
                self.refuse(name, "is of a type that is not read");
                Ok(())
            }
        }
    }

    fn dataset(&mut self, dataset: Dataset, name: &str, depth: usize) -> Hdf5Result<()> {
        self.count()?;
        if dataset.attr("MATLAB_empty").is_ok() {
            return Ok(());
        }
        if dataset.attr("MATLAB_object_decode").is_ok() {
            self.refuse(
                name,
                "is an object (a table, timeseries or datetime); save its arrays instead",
            );
            return Ok(());
        }
        let class = class_of(&dataset);
        let kind = dataset.dtype().and_then(|kind| kind.to_descriptor());
        let stored = match (class.as_deref(), kind) {
            (None, Ok(TypeDescriptor::Reference(Reference::Object))) => {
                return self.elements(&dataset, name, depth);
            }
            (Some("char"), _) => Err("is text"),
            (Some("cell"), _) => Err("is a cell array"),
            (_, Ok(TypeDescriptor::Compound(_))) => Err("is complex"),
            (_, Ok(TypeDescriptor::Float(FloatSize::U4 | FloatSize::U8))) => Ok(Stored::Float),
            (_, Ok(TypeDescriptor::Unsigned(IntSize::U8))) => Ok(Stored::Unsigned),
            (_, Ok(TypeDescriptor::Integer(_) | TypeDescriptor::Unsigned(_))) => {
                Ok(Stored::Integer)
            }
            _ => Err("is of a type that is not read"),
        };
        let stored = match stored {
            Ok(stored) => stored,
            Err(why) => {
                self.refuse(name, why);
                return Ok(());
            }
        };
        let shape: Vec<u64> = dataset.shape().iter().rev().map(|&n| n as u64).collect();
        let count = shape.iter().try_fold(1_u64, |size, n| size.checked_mul(*n));
        let Some(count) = count else {
            return Err("absurd dimensions".into());
        };
        match Sides::of(&shape) {
            // Single numbers are settings, no channels.
            Ok(_) if count <= 1 => {}
            Ok(sides) => self.arrays.push(Array {
                name: name.to_owned(),
                sides,
                dataset,
                stored,
            }),
            Err(why) => self.refuse(name, &why),
        }
        Ok(())
    }

    /// Goes through a field of all elements of a structure array.
    fn elements(&mut self, field: &Dataset, name: &str, depth: usize) -> Hdf5Result<()> {
        if depth > MAX_NESTING {
            return Err("structures within structures without end".into());
        }
        if field.size() > MAX_ENTRIES {
            return Err("a structure with absurdly many elements".into());
        }
        let (before, last) = name.rsplit_once('.').unwrap_or(("", name));
        let references = field.read_raw::<ObjectReference1>()?;
        let one = references.len() == 1;
        for (i, reference) in references.iter().enumerate() {
            let name = match before {
                _ if one => name.to_owned(),
                "" => format!("{last}({})", i + 1),
                _ => format!("{before}({}).{last}", i + 1),
            };
            match field.dereference(reference) {
                Ok(ReferencedObject::Group(group)) => self.structure(&group, &name, depth + 1)?,
                Ok(ReferencedObject::Dataset(dataset)) => {
                    self.dataset(dataset, &name, depth + 1)?;
                }
                Ok(ReferencedObject::Datatype(_)) => {}
                Err(_) => self.refuse(&name, "is missing from the file, which only names it"),
            }
        }
        Ok(())
    }

    fn refuse(&mut self, name: &str, why: &str) {
        self.refused.push(Refused {
            name: name.to_owned(),
            why: why.to_owned(),
        });
    }

    /// Counts what was looked at: a group may hold itself.
    fn count(&mut self) -> Hdf5Result<()> {
        self.seen += 1;
        if self.seen > MAX_ENTRIES {
            return Err("absurdly many variables".into());
        }
        Ok(())
    }
}

/// Returns what MATLAB calls it.
fn class_of(object: &Location) -> Option<String> {
    let class = object.attr("MATLAB_class").ok()?;
    let class = class.read_scalar::<FixedAscii<64>>().ok()?;
    Some(class.as_str().to_owned())
}

/// Numbers as they are handed over.
enum Numbers {
    Float(Vec<f64>),
    Integer(Vec<i64>),
    Unsigned(Vec<u64>),
}

impl Numbers {
    fn len(&self) -> usize {
        match self {
            Self::Float(values) => values.len(),
            Self::Integer(values) => values.len(),
            Self::Unsigned(values) => values.len(),
        }
    }

    fn push_to(&self, part: std::ops::Range<usize>, out: &mut Readings) {
        match self {
            Self::Float(values) => values[part].iter().for_each(|&value| out.push(value)),
            Self::Integer(values) => {
                (values[part].iter()).for_each(|&value| out.push_integer(value));
            }
            Self::Unsigned(values) => (values[part].iter()).for_each(|&value| {
                let reading = i64::try_from(value);
                out.push_reading(reading.map_or(Reading::Float(value as f64), Reading::Integer));
            }),
        }
    }
}

/// A column of an array, read in parts.
struct Column {
    name: String,
    dataset: Dataset,
    stored: Stored,
    /// Where it is along each side; the samples run along one of them.
    fixed: Vec<usize>,
    along: usize,
    at_once: usize,
    part: Numbers,
    /// Numbers of the part that were handed on.
    taken: usize,
}

impl Column {
    /// - `place`: of the column along the shorter side.
    fn new(name: String, array: &Array, place: u64) -> Hdf5Result<Self> {
        let dataset = array.dataset.clone();
        let shape = dataset.shape();
        let samples = array.sides.samples();
        let long: Vec<usize> = (0..shape.len()).filter(|&side| shape[side] != 1).collect();
        // Sides stand in reverse order.
        let (along, across) = match (&long[..], array.sides.lies()) {
            (&[rows], _) => (rows, None),
            (&[along, across], true) | (&[across, along], false) => (along, Some(across)),
            _ => return Err("an array of another shape than before".into()),
        };
        let mut fixed = vec![0; shape.len()];
        if let Some(across) = across {
            fixed[across] = place as usize;
        }
        let size = dataset.dtype()?.size() as u64;
        let claimed = (array.sides.rows * array.sides.columns).saturating_mul(size);
        if dataset.storage_size().saturating_mul(MAX_COMPRESSION_RATIO) < claimed {
            return Err("less than the numbers that it should have".into());
        }
        let chunk = dataset.chunk().map_or(0, |chunk| chunk[along] as u64);
        let at_once = chunk
            .clamp(*NUMBERS_AT_ONCE.start(), *NUMBERS_AT_ONCE.end())
            .min(samples);
        Ok(Self {
            name,
            dataset,
            stored: array.stored,
            fixed,
            along,
            at_once: at_once as usize,
            part: Numbers::Float(Vec::new()),
            taken: 0,
        })
    }

    /// Hands `count` numbers on.
    ///
    /// - `row`: the first of them.
    fn read(&mut self, row: usize, count: usize, out: &mut Readings) -> Hdf5Result<()> {
        let mut done = 0;
        while done < count {
            if self.taken == self.part.len() {
                self.part = self.next(row + done)?;
                self.taken = 0;
            }
            let some = (count - done).min(self.part.len() - self.taken);
            if some == 0 {
                return Err("fewer numbers than it says".into());
            }
            self.part.push_to(self.taken..self.taken + some, out);
            self.taken += some;
            done += some;
        }
        Ok(())
    }

    fn next(&self, row: usize) -> Hdf5Result<Numbers> {
        let rows = self.dataset.shape()[self.along];
        let end = rows.min(row + self.at_once);
        let side = |(side, &at): (usize, &usize)| {
            if side == self.along {
                SliceOrIndex::from(row..end)
            } else {
                SliceOrIndex::Index(at)
            }
        };
        let sides: Vec<SliceOrIndex> = self.fixed.iter().enumerate().map(side).collect();
        let part = Selection::from(hdf5_metno::Hyperslab::from(sides));
        let dataset = &self.dataset;
        Ok(match self.stored {
            Stored::Float => Numbers::Float(dataset.read_slice_1d(part)?.to_vec()),
            Stored::Integer => Numbers::Integer(dataset.read_slice_1d(part)?.to_vec()),
            Stored::Unsigned => Numbers::Unsigned(dataset.read_slice_1d(part)?.to_vec()),
        })
    }
}

/// Columns of one length.
struct Mat73 {
    file: String,
    columns: Vec<Column>,
    rows: u64,
    before: u64,
    done: u64,
}

impl Table for Mat73 {
    fn read(&mut self, limit: usize, out: &mut [Readings]) -> Result<usize, LogError> {
        let left = usize::try_from(self.rows - self.done).unwrap_or(usize::MAX);
        let count = limit.min(left);
        let (file, row) = (&self.file, self.done as usize);
        for (column, out) in self.columns.iter_mut().zip(out) {
            guarded(file, || {
                (column.read(row, count, out)).map_err(|error| failed(file, &column.name, &error))
            })?;
        }
        self.before = self.done;
        self.done += count as u64;
        Ok(count)
    }

    fn place(&self, i: usize) -> Place {
        Place::Row(self.before + i as u64 + 1)
    }
}
