//! NumPy arrays: `.npy`, and `.npz`, which is a zip archive of `.npy` members.

use std::io::{Read, SeekFrom};

use super::array_shape::{no_topics, same_rows, too_many};
use super::npy::{Npy, NpyColumn, header};
use super::strips::{Cell, Strip, StripTable, skip};
use super::table::{Opened, Reopen, Request};
use super::zip::{Member, members};
use crate::columns::names::{Names, Refused, instead, listed};
use crate::error::LogError;
use crate::input_limits::COLUMNS;

/// An array of a file.
struct Array {
    /// Its member in an archive; nothing in an `.npy` file, which holds one array.
    member: Option<Member>,
    npy: Npy,
}

impl Array {
    /// Returns the name of the array; empty in an `.npy` file.
    fn label(&self) -> String {
        match &self.member {
            Some(member) => member.name.trim_end_matches(".npy").to_owned(),
            None => String::new(),
        }
    }

    /// Returns the name of a column: `q`, `q[:,0]`, `log.q` or `[:,0]`.
    fn name_of(&self, column: &NpyColumn) -> String {
        let label = self.label();
        let joined = column.name.is_empty() || column.name.starts_with('[') || label.is_empty();
        format!("{label}{}{}", if joined { "" } else { "." }, column.name)
    }

    /// Returns a reader of the array that has skipped its first `before` bytes.
    ///
    /// - `name`: the column, for messages.
    fn read(
        &self,
        (file, name): (&str, &str),
        before: u64,
        reopen: Reopen<'_>,
    ) -> Result<Box<dyn Read + Send>, LogError> {
        let failed = |error| LogError::read(file, name, error);
        let mut input = reopen()?;
        if let Some(member) = &self.member {
            let mut read = member.open(file, input)?;
            skip(&mut *read, before).map_err(failed)?;
            return Ok(read);
        }
        input.seek(SeekFrom::Start(before)).map_err(failed)?;
        Ok(Box::new(input))
    }
}

/// Opens an `.npy` file.
pub(super) fn open_npy(request: &Request<'_>, reopen: Reopen<'_>) -> Result<Opened, LogError> {
    let npy = header(&mut *reopen()?)
        .map_err(|what| LogError::format(request.file, format!(" {what}")))?;
    open(request, &[Array { member: None, npy }], &[], reopen)
}

/// Opens an `.npz` file.
pub(super) fn open_npz(request: &Request<'_>, reopen: Reopen<'_>) -> Result<Opened, LogError> {
    let file = request.file;
    let members = members(file, &mut *reopen()?)?;
    let names: Vec<&str> = members.iter().map(|member| member.name.as_str()).collect();
    let is_array = |name: &str| name.strip_suffix(".npy").is_some();
    if !names.iter().any(|name| is_array(name)) {
        let what = if names.iter().any(|name| name.starts_with("xl/")) {
            " is a spreadsheet; save it as CSV: pandas.read_excel(\"run.xlsx\").to_csv(\"run.csv\", index=False)".to_owned()
        } else if names.iter().any(|name| name.ends_with("data.pkl")) {
            " is a file of PyTorch; write its arrays: d = torch.load(\"run.pt\"); numpy.savez(\"run.npz\", **{k: \
             numpy.asarray(v) for k, v in d.items()})"
                .to_owned()
        } else {
            format!(
                " is a zip archive without NumPy arrays; unpack it, it holds {}",
                listed(&names)
            )
        };
        return Err(LogError::format(file, what));
    }
    let mut arrays: Vec<Array> = Vec::new();
    let mut refused = Vec::new();
    let mut listed = 0;
    for member in members.into_iter().filter(|member| is_array(&member.name)) {
        let mut read = member.open(file, reopen()?)?;
        let name = || member.name.trim_end_matches(".npy").to_owned();
        match header(&mut *read) {
            Ok(npy) if npy.scalar => {}
            // Its checksum is compared only where all its bytes are read.
            Ok(npy) if npy.bytes() != Some(member.bytes()) => refused.push(Refused {
                name: name(),
                why: format!(
                    "has {} bytes in the archive, which is not what its header describes; copy or write \
                     the archive again",
                    member.bytes()
                ),
            }),
            Ok(npy) if listed + npy.columns.len() > COLUMNS => refused.push(Refused {
                name: name(),
                why: too_many(npy.columns.len() as u64),
            }),
            Ok(npy) => {
                listed += npy.columns.len();
                arrays.push(Array {
                    member: Some(member),
                    npy,
                });
            }
            // An array of text may accompany the columns, so it is an error only if it is requested.
            Err(why) => refused.push(Refused { name: name(), why }),
        }
    }
    if arrays.is_empty() && !refused.is_empty() {
        let all: Vec<String> = refused.iter().map(Refused::to_string).collect();
        return Err(LogError::format(file, format!(": {}", all.join(", "))));
    }
    open(request, &arrays, &refused, reopen)
}

/// Finds the wanted columns, and opens a reader for each array that has some of them.
///
/// - `refused`: arrays that are not read, with the reason.
fn open(
    request: &Request<'_>,
    arrays: &[Array],
    refused: &[Refused],
    reopen: Reopen<'_>,
) -> Result<Opened, LogError> {
    let file = request.file;
    no_topics(request)?;
    let columns: Vec<(usize, &NpyColumn)> = (arrays.iter().enumerate())
        .flat_map(|(i, array)| array.npy.columns.iter().map(move |column| (i, column)))
        .collect();
    let all: Vec<String> = (columns.iter())
        .map(|(i, column)| arrays[*i].name_of(column))
        .collect();
    let names = Names {
        file,
        all: &all,
        given: !(all
            .iter()
            .all(|name| name.is_empty() || name.starts_with('['))),
    };
    let places = (request.picks.iter())
        .map(|pick| {
            names
                .find(pick)
                .map_err(|error| instead(file, refused, pick, error))
        })
        .collect::<Result<Vec<usize>, LogError>>()?;
    let rows = same_rows(file, &places, |place| {
        (&all[place], arrays[columns[place].0].npy.rows)
    })?;
    let mut strips: Vec<Strip> = Vec::new();
    // Columns whose numbers lie in the same rows of an array share a reader. A column with consecutive numbers has its
    // own.
    let mut shared: Vec<(usize, bool, usize)> = Vec::new();
    for (out, &place) in places.iter().enumerate() {
        let (i, column) = columns[place];
        let array = &arrays[i];
        let cell = |at: usize| Cell {
            at,
            number: column.number,
            out,
        };
        let known =
            (shared.iter()).find(|(index, order, _)| *index == i && *order == column.big_endian);
        if let (Some((_, _, strip)), false) = (known, column.is_contiguous) {
            strips[*strip].cells.push(cell(column.at as usize));
            continue;
        }
        let name = format!("\"{}\"", all[place]);
        let before = array.npy.header_bytes + if column.is_contiguous { column.at } else { 0 };
        let read = array.read((file, &name), before, reopen)?;
        let (record, at) = if column.is_contiguous {
            (column.number.size(), 0)
        } else {
            shared.push((i, column.big_endian, strips.len()));
            (array.npy.row_bytes as usize, column.at as usize)
        };
        strips.push(Strip {
            name,
            read,
            record,
            cells: vec![cell(at)],
            big_endian: column.big_endian,
        });
    }
    let has_names = names.given;
    Ok(Opened {
        table: Box::new(StripTable::new(file, strips, rows)),
        names: places.iter().map(|&place| all[place].clone()).collect(),
        time_unit: (request.time).and_then(|time| columns[places[time]].1.time_unit),
        all,
        has_names,
        units: Vec::new(),
    })
}
