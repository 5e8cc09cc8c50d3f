//! Columns of MATLAB files.

use std::io::{Read, Seek, SeekFrom};

use super::super::LogError;
use super::super::names::{Names, Refused, instead};
use super::super::origin::Pick;
use super::arrays::same_rows;
use super::mat::{MatArray, contents};
use super::strips::{Cell, Strip, StripTable, skip};
use super::{Opened, Reopen, Request};
use crate::description::ColumnName;

/// The sides of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Sides {
    pub(super) rows: u64,
    pub(super) columns: u64,
}

impl Sides {
    /// Returns the two sides of an array that are longer than one; says what is wrong if there are
    /// more.
    ///
    /// - `dimensions`: as MATLAB counts them; their product is no overflow.
    pub(super) fn of(dimensions: &[u64]) -> Result<Self, String> {
        let long: Vec<u64> = dimensions.iter().copied().filter(|n| *n != 1).collect();
        match long[..] {
            [] => Ok(Self {
                rows: 1,
                columns: 1,
            }),
            [rows] => Ok(Self { rows, columns: 1 }),
            [rows, columns] => Ok(Self { rows, columns }),
            _ => {
                let sides: Vec<String> = dimensions.iter().map(u64::to_string).collect();
                Err(format!(
                    "is an array of {}, and a log has two dimensions; reshape it to samples × columns \
                     and save that",
                    sides.join(" × ")
                ))
            }
        }
    }

    /// Whether samples lie in a row; they run along the longer side.
    pub(super) fn lies(self) -> bool {
        self.columns > self.rows
    }

    pub(super) fn samples(self) -> u64 {
        self.rows.max(self.columns)
    }

    /// Returns the names of the columns of an array, `t`, `q(:,1)` or `q(1,:)`, with their
    /// places.
    pub(super) fn columns_of(self, array: &str) -> impl Iterator<Item = (String, u64)> + '_ {
        let width = self.rows.min(self.columns);
        (0..width.min(MOST)).map(move |place| {
            let name = match (width, self.lies()) {
                (1, _) => array.to_owned(),
                (_, false) => format!("{array}(:,{})", place + 1),
                (_, true) => format!("{array}({},:)", place + 1),
            };
            (name, place)
        })
    }
}

/// Most columns of an array that are listed.
const MOST: u64 = 1 << 16;

/// A column of an array.
struct Column<'a> {
    array: &'a MatArray,
    place: u64,
}

/// Opens a MATLAB file.
pub(super) fn open(request: &Request<'_>, reopen: Reopen<'_>) -> Result<Opened, LogError> {
    let file = request.file;
    no_topics(request)?;
    let contents = contents(&mut *reopen()?)
        .map_err(|error| LogError::read(file, "one of its variables", error))?;
    let mut columns = Vec::new();
    let mut all = Vec::new();
    for array in &contents.arrays {
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
        .map(|pick| find(&names, pick, &contents.refused))
        .collect::<Result<Vec<usize>, LogError>>()?;
    let rows = same_rows(file, &places, |place| {
        (&all[place], columns[place].array.sides.samples())
    })?;
    let mut strips: Vec<Strip> = Vec::new();
    for (out, &place) in places.iter().enumerate() {
        let (column, name) = (&columns[place], format!("\"{}\"", all[place]));
        let array = column.array;
        let size = array.number.size() as u64;
        // MATLAB stores column after column.
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
    })
}

/// Checks that no topic is asked for.
pub(super) fn no_topics(request: &Request<'_>) -> Result<(), LogError> {
    match request.topic {
        None => Ok(()),
        Some(topic) => Err(LogError::format(
            request.file,
            format!(" holds arrays and no topics, so there is no \"{topic}\"; name columns"),
        )),
    }
}

/// Finds a column; that of a vector may be written `t`, `t(:)` or `t(:,1)`.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_of_one_are_none() {
        let sides = |dimensions: &[u64]| {
            let sides = Sides::of(dimensions)?;
            Ok::<_, String>((sides.rows, sides.columns))
        };
        assert_eq!(sides(&[100, 2]), Ok((100, 2)));
        assert_eq!(sides(&[2, 1, 100]), Ok((2, 100)));
        assert_eq!(sides(&[1, 1, 100]), Ok((100, 1)));
        assert_eq!(sides(&[1, 1]), Ok((1, 1)));
        let told = sides(&[100, 7, 2]).unwrap_err();
        assert!(told.contains("array of 100 × 7 × 2"), "{told}");
    }
}
