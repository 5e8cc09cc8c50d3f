//! Columns of MATLAB files of versions 5 to 7, and names of columns as MATLAB writes them.

use std::io::{Read, Seek, SeekFrom};

use super::array_shape::{no_topics, same_rows, too_many};
use super::mat::{MatArray, contents};
use super::strips::{Cell, Strip, StripTable, skip};
use super::table::{Opened, Reopen, Request};
use crate::columns::names::{Names, Refused, instead};
use crate::columns::origin::Pick;
use crate::description::ColumnName;
use crate::error::LogError;
use crate::input_limits::COLUMNS;

/// A column of an array.
struct Column<'a> {
    array: &'a MatArray,
    /// Index along the shorter side, from 0.
    place: u64,
}

/// Opens a MATLAB file of versions 5 to 7.
pub(super) fn open(request: &Request<'_>, reopen: Reopen<'_>) -> Result<Opened, LogError> {
    let file = request.file;
    no_topics(request)?;
    let contents = contents(&mut *reopen()?)
        .map_err(|error| LogError::read(file, "one of its variables", error))?;
    let mut columns = Vec::new();
    let mut all = Vec::new();
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
            columns.push(Column { array, place });
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
        (&all[place], columns[place].array.sides.samples())
    })?;
    let mut strips: Vec<Strip> = Vec::new();
    for (out, &place) in places.iter().enumerate() {
        let (column, name) = (&columns[place], format!("\"{}\"", all[place]));
        let array = column.array;
        let size = array.number.size() as u64;
        // MATLAB stores a matrix column by column. Where the samples run along the second side, each of these
        // columns is a record; otherwise the numbers of a channel follow one another.
        let rows = array.sides.rows;
        let (record, before, at) = if array.sides.lies() {
            (rows * size, 0, column.place * size)
        } else {
            (size, column.place * rows * size, 0)
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
        all,
        has_names: true,
        units: Vec::new(),
    })
}

/// Finds a column; the column of a vector may be written `t`, `t(:)`, `t(:,1)` or `t(1,:)`.
///
/// - `refused`: arrays that are not read, with the reason.
///
/// # Errors
///
/// [`LogError`] if there is no such column, with the reason if its array is not read.
pub(super) fn find(names: &Names<'_>, pick: &Pick, refused: &[Refused]) -> Result<usize, LogError> {
    let error = match names.find(pick) {
        Ok(place) => return Ok(place),
        Err(error) => error,
    };
    if let Pick::Column(ColumnName::Name(name)) = pick {
        let plain: String = name.chars().filter(|c| !c.is_whitespace()).collect();
        let short = ["(:,1)", "(:)", "(1,:)"]
            .iter()
            .find_map(|end| plain.strip_suffix(end));
        for other in [Some(plain.as_str()), short].into_iter().flatten() {
            if let Some(place) = names.all.iter().position(|known| known == other) {
                return Ok(place);
            }
        }
    }
    Err(instead(names.file, refused, pick, error))
}
