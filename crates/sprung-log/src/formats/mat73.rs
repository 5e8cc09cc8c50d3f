//! MATLAB files of version 7.3: HDF5 with MATLAB's conventions.
//!
//! A structure is a group. An array is a dataset whose sides are in reverse order. The attribute
//! `MATLAB_class` gives the class of a variable in MATLAB. Elements of structure arrays and cells are objects
//! of the group `#refs#`, and the variable holds references to them. libhdf5 opens the file itself, so a log
//! in memory cannot be read.

use std::io::{Error as IoError, ErrorKind, Read, Result as IoResult, Seek, SeekFrom};
use std::path::Path;

use hdf5_metno::types::{FixedAscii, FloatSize, IntSize, Reference, TypeDescriptor};
use hdf5_metno::{
    Dataset, Error, File, Group, IndexType, IterationOrder, LinkType, Location, LocationType,
    ObjectReference1, ReferencedObject, Result as Hdf5Result, Selection, SliceOrIndex,
};

use super::array_shape::{Sides, no_topics, same_rows, too_many};
use super::damaged::guarded;
use super::matlab::find;
use super::number::Reading;
use super::table::{Opened, Readings, Reopen, Request, Table};
use crate::columns::names::{Names, Refused};
use crate::error::{LogError, Place};
use crate::input_limits::COLUMNS;

/// Deepest structure within structures; it bounds the recursion.
const MAX_NESTING: usize = 16;

/// Most variables, fields and elements of structures in a file; a group may contain itself.
const MAX_ENTRIES: usize = 1 << 16;

/// Numbers of a column that are read at once: those of a chunk, so that no chunk is decompressed twice, within
/// these limits. The upper limit bounds the memory: 8 MB a column.
const NUMBERS_AT_ONCE: std::ops::RangeInclusive<u64> = (1 << 13)..=(1 << 20);

/// Upper limit of the compression ratio; deflate reaches at most 1032.
const MAX_COMPRESSION_RATIO: u64 = 4096;

/// Opens a MATLAB file of version 7.3.
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
    let has_driver =
        names_driver(path).map_err(|error| LogError::read(file, "its header", error))?;
    if has_driver {
        let error = IoError::new(
            ErrorKind::InvalidData,
            "it names a driver, which MATLAB never does",
        );
        return Err(LogError::read(file, "its header", error));
    }
    let contents = guarded(file, || {
        let mut contents = Contents::default();
        match File::open(path).and_then(|file| contents.group(&file, "", 0)) {
            Ok(()) => Ok(contents),
            Err(error) => Err(failed(file, &contents.place(), &error)),
        }
    })?;
    let mut all = Vec::new();
    let mut columns = Vec::new();
    let mut refused = contents.refused.clone();
    for array in &contents.arrays {
        let width = array.sides.width();
        if width > (COLUMNS - all.len()) as u64 {
            refused.push(Refused {
                name: array.name.clone(),
                why: too_many(width),
            });
            continue;
        }
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
        .map(|pick| find(&names, pick, &refused))
        .collect::<Result<Vec<usize>, LogError>>()?;
    let rows = same_rows(file, &places, |place| {
        (&all[place], columns[place].0.sides.samples())
    })?;
    let column_at = |&place: &usize| {
        let (array, column) = columns[place];
        let name = format!("\"{}\"", all[place]);
        guarded(file, || {
            Column::new(name.clone(), array, column).map_err(|error| failed(file, &name, &error))
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
        all,
        has_names: true,
        units: Vec::new(),
    })
}

/// First bytes of the data in HDF5.
const SIGNATURE: [u8; 8] = *b"\x89HDF\r\n\x1a\n";

/// Returns whether a file names a driver of its parts. Libhdf5 allocates as much memory as the description of a driver
/// claims to need, up to 4 GB.
fn names_driver(path: &Path) -> IoResult<bool> {
    let mut file = std::fs::File::open(path)?;
    let length = file.seek(SeekFrom::End(0))?;
    // The data begin after a block of the user: at 0, 512, 1024, 2048, …
    let mut at = 0;
    while at < length {
        file.seek(SeekFrom::Start(at))?;
        let mut head = Vec::new();
        (&mut file).take(128).read_to_end(&mut head)?;
        if head.starts_with(&SIGNATURE) {
            let word = |k: usize| head.get(k).copied().unwrap_or_default();
            let begin = match word(8) {
                0 => 24,
                1 => 28,
                _ => return Ok(false),
            };
            // After three addresses.
            let bytes = usize::from(word(13));
            let address = begin + 3 * bytes;
            return Ok((address..address + bytes).any(|k| word(k) != u8::MAX));
        }
        at = (2 * at).max(512);
    }
    Ok(false)
}

/// Returns an error of libhdf5 as an error of the file.
///
/// libhdf5 has no error code for a file that was cut off, so its text decides.
///
/// - `what`: the part of the file that was read, for the message.
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
    /// The name as MATLAB writes it: `t`, `data.q`, `s(2).values`.
    name: String,
    sides: Sides,
    dataset: Dataset,
    stored: Stored,
}

/// The type in which libhdf5 gives the numbers; it converts from the stored one.
#[derive(Clone, Copy)]
enum Stored {
    Float,
    Integer,
    /// Unsigned integers of 64 bits, which may exceed `i64::MAX`.
    Unsigned,
}

/// What a file holds.
#[derive(Default)]
struct Contents {
    arrays: Vec<Array>,
    /// Variables and fields that are not read, with the reason.
    refused: Vec<Refused>,
    /// Variables, fields and elements that were visited.
    seen: usize,
    /// Name of the last of them.
    last: String,
}

impl Contents {
    /// Returns where the scan is, for messages.
    fn place(&self) -> String {
        match self.last.as_str() {
            "" => "its list of variables".to_owned(),
            name => format!("its variable \"{name}\""),
        }
    }

    /// Visits the variables of a file, or the fields of a structure.
    ///
    /// - `path`: name of the structure, empty for a file.
    /// - `depth`: structures around the variables.
    fn group(&mut self, group: &Group, path: &str, depth: usize) -> Hdf5Result<()> {
        if depth > MAX_NESTING {
            return Err("more than 16 structures within each other".into());
        }
        for (link, info) in group.links(IndexType::Name, IterationOrder::Increasing)? {
            // The groups `#refs#` and `#subsystem#` hold objects that references point to.
            let is_internal = depth == 0 && link.starts_with('#');
            if is_internal || info.link_type != LinkType::Hard {
                continue;
            }
            let name = match path {
                "" => link.clone(),
                _ => format!("{path}.{link}"),
            };
            name.clone_into(&mut self.last);
            // A match would not be exhaustive with every version of libhdf5: newer ones have more kinds.
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
        self.count(name)?;
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
        self.count(name)?;
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
            // A single number is a setting, not a channel.
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

    /// Visits a field in all elements of a structure array: a dataset of references.
    fn elements(&mut self, field: &Dataset, name: &str, depth: usize) -> Hdf5Result<()> {
        if depth > MAX_NESTING {
            return Err("more than 16 structures within each other".into());
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
                Err(_) => self.refuse(
                    &name,
                    "is a reference to an object that the file does not contain",
                ),
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

    /// Counts a visit, and ends a scan that does not end by itself.
    fn count(&mut self, name: &str) -> Hdf5Result<()> {
        self.seen += 1;
        name.clone_into(&mut self.last);
        if self.seen > MAX_ENTRIES {
            return Err("absurdly many variables".into());
        }
        Ok(())
    }
}

/// Returns the class in MATLAB: `double`, `char`, `struct`.
fn class_of(object: &Location) -> Option<String> {
    let class = object.attr("MATLAB_class").ok()?;
    let class = class.read_scalar::<FixedAscii<64>>().ok()?;
    Some(class.as_str().to_owned())
}

/// Numbers that were read from a file and not yet passed on.
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

    /// Appends some of the numbers to a column.
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
    /// Index of the column along each side of the dataset; that along the samples is not used.
    fixed: Vec<usize>,
    /// The side of the dataset along which the samples run.
    along: usize,
    /// Numbers that are read at once.
    at_once: usize,
    /// The numbers that were read last.
    part: Numbers,
    /// Numbers of `part` that were passed on.
    taken: usize,
}

impl Column {
    /// Prepares a column for reading.
    ///
    /// - `place`: index of the column along the shorter side, from 0.
    fn new(name: String, array: &Array, place: u64) -> Hdf5Result<Self> {
        let dataset = array.dataset.clone();
        let shape = dataset.shape();
        let samples = array.sides.samples();
        let long: Vec<usize> = (0..shape.len()).filter(|&side| shape[side] != 1).collect();
        // The sides of a dataset are in reverse order.
        let (along, across) = match (&long[..], array.sides.lies()) {
            (&[rows], _) => (rows, None),
            (&[along, across], true) | (&[across, along], false) => (along, Some(across)),
            _ => return Err("an array without a side for the samples".into()),
        };
        let mut fixed = vec![0; shape.len()];
        if let Some(across) = across {
            fixed[across] = place as usize;
        }
        let size = dataset.dtype()?.size() as u64;
        let claimed = (array.sides.rows * array.sides.columns).saturating_mul(size);
        if dataset.storage_size().saturating_mul(MAX_COMPRESSION_RATIO) < claimed {
            return Err("fewer stored bytes than its numbers need".into());
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

    /// Appends `count` numbers to a column.
    ///
    /// - `row`: index of the first of them, from 0.
    fn read(&mut self, row: usize, count: usize, out: &mut Readings) -> Hdf5Result<()> {
        let mut done = 0;
        while done < count {
            if self.taken == self.part.len() {
                self.part = self.next(row + done)?;
                self.taken = 0;
            }
            let some = (count - done).min(self.part.len() - self.taken);
            if some == 0 {
                return Err("fewer numbers than its dimensions say".into());
            }
            self.part.push_to(self.taken..self.taken + some, out);
            self.taken += some;
            done += some;
        }
        Ok(())
    }

    /// Reads the next numbers from the file, beginning with `row`.
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

/// The wanted columns, which are of equal length.
struct Mat73 {
    file: String,
    columns: Vec<Column>,
    rows: u64,
    /// Rows before the last block.
    before: u64,
    /// Rows that were read.
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
