//! Columns of MATLAB files.

use std::io::{Read, Seek, SeekFrom};

use super::super::LogError;
use super::super::names::Names;
use super::super::origin::Pick;
use super::arrays::same_rows;
use super::mat::{MatArray, contents};
use super::strips::{Cell, Strip, StripTable, skip};
use super::{Opened, Reopen, Request};
use crate::description::ColumnName;

/// A column of an array.
struct Column<'a> {
    array: &'a MatArray,
    place: u64,
}

impl Column<'_> {
    /// Whether samples lie in a row; they run along the longer side.
    fn lies(&self) -> bool {
        self.array.columns > self.array.rows
    }

    fn samples(&self) -> u64 {
        self.array.rows.max(self.array.columns)
    }
}

/// Most columns of an array that are listed.
const MOST: u64 = 1 << 16;

/// Opens a MATLAB file.
pub(super) fn open(request: &Request<'_>, reopen: Reopen<'_>) -> Result<Opened, LogError> {
    let file = request.file;
    if let Some(topic) = request.topic {
        return Err(LogError::format(
            file,
            format!(" holds arrays and no topics, so there is no \"{topic}\"; name columns"),
        ));
    }
    let contents = contents(&mut *reopen()?)
        .map_err(|error| LogError::read(file, "one of its variables", error))?;
    let mut columns = Vec::new();
    let mut all = Vec::new();
    for array in &contents.arrays {
        let width = array.rows.min(array.columns);
        for place in 0..width.min(MOST) {
            let column = Column { array, place };
            all.push(match (width, column.lies()) {
                (1, _) => array.name.clone(),
                (_, false) => format!("{}(:,{})", array.name, place + 1),
                (_, true) => format!("{}({},:)", array.name, place + 1),
            });
            columns.push(column);
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
        (&all[place], columns[place].samples())
    })?;
    let mut strips: Vec<Strip> = Vec::new();
    for (out, &place) in places.iter().enumerate() {
        let (column, name) = (&columns[place], format!("\"{}\"", all[place]));
        let array = column.array;
        let size = array.number.size() as u64;
        // MATLAB stores column after column.
        let (record, before, at) = if column.lies() {
            (array.rows * size, 0, column.place * size)
        } else {
            (size, column.place * array.rows * size, 0)
        };
        let failed = |error| LogError::read(file, &name, error);
        let mut input = reopen()?;
        let skipped = array.at + before;
        let read: Box<dyn Read + Send> = if array.compressed {
            (input.seek(SeekFrom::Start(array.variable))).map_err(failed)?;
            let mut read = flate2::read::ZlibDecoder::new(input);
            skip(&mut read, skipped).map_err(failed)?;
            Box::new(read)
        } else {
            (input.seek(SeekFrom::Start(array.variable + skipped))).map_err(failed)?;
            Box::new(std::io::BufReader::new(input))
        };
        strips.push(Strip {
            name,
            read,
            record: record as usize,
            cells: vec![Cell {
                at: at as usize,
                number: array.number,
                out,
            }],
            big_endian: contents.big_endian,
        });
    }
    Ok(Opened {
        table: Box::new(StripTable::new(file, strips, rows)),
        names: places.iter().map(|&place| all[place].clone()).collect(),
        time_unit: None,
    })
}

/// Finds a column; that of a vector may be written `t`, `t(:)` or `t(:,1)`.
fn find(names: &Names<'_>, pick: &Pick, refused: &[String]) -> Result<usize, LogError> {
    let found = names.find(pick);
    let Pick::Column(ColumnName::Name(name)) = pick else {
        return found;
    };
    if found.is_ok() {
        return found;
    }
    let plain: String = name.chars().filter(|c| !c.is_whitespace()).collect();
    let short = ["(:,1)", "(:)", "(1,:)"]
        .iter()
        .find_map(|end| plain.strip_suffix(end));
    for other in [Some(plain.as_str()), short].into_iter().flatten() {
        if let Some(place) = names.all.iter().position(|known| known == other) {
            return Ok(place);
        }
    }
    if let Some(why) = refused
        .iter()
        .find(|why| why.starts_with(&format!("\"{name}\" ")))
    {
        return Err(LogError::format(names.file, format!(": {why}")));
    }
    found
}
