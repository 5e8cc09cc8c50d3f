//! Text of numbers between delimiters.

use std::io::Read;

use csv::{ByteRecord, Position, Reader, ReaderBuilder};

use super::delimited::{Delimiter, Form, date, number};
use super::table::{Opened, Readings, Request, Table};
use crate::columns::names::Names;
use crate::description::MissingValues;
use crate::error::{LogError, Place};

/// Largest number of characters of a cell that an error shows.
const MAX_SHOWN_CHARS: usize = 80;

type Source = Box<dyn Read + Send>;

struct CsvTable {
    file: String,
    what: String,
    reader: Reader<Source>,
    record: ByteRecord,
    // Names and indices of the wanted columns.
    names: Vec<String>,
    places: Vec<usize>,
    form: Form,
    time: Option<usize>,
    dates: bool,
    nan: MissingValues,
    // Lines before the first line of the reader.
    skipped: u64,
    // Line of each row of the last block.
    lines: Vec<u64>,
    // Whether `record` contains the first row, which was read to count the columns.
    pending: bool,
}

/// Opens a text.
///
/// - `what`: name of the text in errors.
/// - `start`: first bytes of the text.
/// - `whole`: whether `start` is the whole text.
pub(super) fn open(
    request: &Request<'_>,
    what: &str,
    start: &[u8],
    whole: bool,
    mut read: Source,
) -> Result<Opened, LogError> {
    let file = request.file;
    if let Some(topic) = request.topic {
        return Err(LogError::format(
            request.whole_file(),
            format!(" is text and has no topics, so there is no \"{topic}\"; name columns"),
        ));
    }
    if let Some(other) = other_text(start) {
        return Err(LogError::format(file, other));
    }
    let bom = start.starts_with(b"\xef\xbb\xbf");
    let (mut drop, mut skipped) = (if bom { 3 } else { 0 }, 0);
    for _ in 0..request.csv.skip_lines {
        let Some(end) = start[drop..].iter().position(|&byte| byte == b'\n') else {
            return Err(LogError::format(
                file,
                format!(
                    " ends before skip_lines = {} lines, or these are longer than 64 kB",
                    request.csv.skip_lines
                ),
            ));
        };
        drop += end + 1;
        skipped += 1;
    }
    std::io::copy(&mut read.by_ref().take(drop as u64), &mut std::io::sink())
        .map_err(|error| LogError::read(file, what, error))?;
    let start = &start[drop..];
    let end = if whole {
        start.len()
    } else {
        // The last line may be incomplete.
        (start.iter().rposition(|&byte| byte == b'\n')).map_or(start.len(), |end| end + 1)
    };
    let form = Form::of(&decoded(&start[..end]), request.csv);
    let read = match form.delimiter {
        Delimiter::Blanks => Box::new(Squeeze::new(read)),
        Delimiter::Byte(_) => read,
    };
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .buffer_capacity(1 << 18)
        .comment(Some(form.comment))
        .delimiter(match form.delimiter {
            Delimiter::Byte(byte) => byte,
            Delimiter::Blanks => b' ',
        })
        .from_reader(read);
    let mut record = ByteRecord::new();
    let any = reader
        .read_byte_record(&mut record)
        .map_err(|error| csv_error(file, what, error, skipped, form.header))?;
    if !any {
        return Err(LogError::TooShort {
            file: file.to_owned(),
            found: 0,
            needed: 2,
            why: "the file is empty, not even a header line is there".to_owned(),
        });
    }
    let given = form.header || form.commented_names.is_some();
    let all: Vec<String> = match &form.commented_names {
        Some(names) => names.clone(),
        None if form.header => (record.iter())
            .map(|name| decoded(name).trim().to_owned())
            .collect(),
        None => (1..=record.len())
            .map(|number| number.to_string())
            .collect(),
    };
    let names = Names {
        file,
        all: &all,
        given,
    };
    let places = (request.picks.iter())
        .map(|pick| names.find(pick))
        .collect::<Result<Vec<usize>, LogError>>()?;
    let names: Vec<String> = places.iter().map(|&place| all[place].clone()).collect();
    let table = CsvTable {
        file: file.to_owned(),
        what: what.to_owned(),
        reader,
        record,
        names: names.clone(),
        places,
        pending: !form.header,
        form,
        time: request.time,
        dates: request.dates,
        nan: request.nan,
        skipped,
        lines: Vec::new(),
    };
    Ok(Opened {
        table: Box::new(table),
        names,
        time_unit: request.dates.then_some(1e-9),
        all,
        has_names: given,
    })
}

/// Recognises a text that is no table by its first characters; returns the rest of the error.
fn other_text(start: &[u8]) -> Option<&'static str> {
    const MARKUP: [&[u8]; 4] = [b"<!doctype", b"<?xml", b"<html", b"<robot"];
    let start = start.trim_ascii_start();
    let begins = |with: &&[u8]| {
        (start.get(..with.len())).is_some_and(|beginning| beginning.eq_ignore_ascii_case(with))
    };
    if MARKUP.iter().any(begins) {
        return Some(" is a page of HTML or XML, not a table of numbers; give the log");
    }
    let inside = start.strip_prefix(b"{")?.trim_ascii_start();
    inside
        .starts_with(b"\"")
        .then_some(" is JSON, which sprung does not read; give the log as CSV or in another format")
}

impl Table for CsvTable {
    fn read(&mut self, limit: usize, out: &mut [Readings]) -> Result<usize, LogError> {
        self.lines.clear();
        while self.lines.len() < limit {
            if !std::mem::replace(&mut self.pending, false) {
                let more = (self.reader.read_byte_record(&mut self.record)).map_err(|error| {
                    let header = self.form.header;
                    csv_error(&self.file, &self.what, error, self.skipped, header)
                })?;
                if !more {
                    break;
                }
            }
            let line = self.record.position().map_or(0, Position::line) + self.skipped;
            self.lines.push(line);
            for (i, readings) in out.iter_mut().enumerate() {
                let cell = self.record.get(self.places[i]).unwrap_or_default();
                if self.nan == MissingValues::Gap && is_missing(cell) {
                    readings.push_missing();
                    continue;
                }
                if self.time == Some(i) {
                    push_time(readings, cell, self.dates, self.form.decimal_comma)
                } else {
                    number(cell, self.form.decimal_comma).map(|value| readings.push(value))
                }
                .ok_or_else(|| self.not_a_number(i, cell))?;
            }
        }
        Ok(self.lines.len())
    }

    fn place(&self, i: usize) -> Place {
        Place::Line(self.lines.get(i).copied().unwrap_or_default())
    }
}

fn push_time(readings: &mut Readings, cell: &[u8], dates: bool, decimal_comma: bool) -> Option<()> {
    if dates {
        return date(cell).map(|date| readings.push_integer(date));
    }
    let integer = std::str::from_utf8(cell)
        .ok()
        .and_then(|text| text.trim().parse().ok());
    match integer {
        Some(integer) => readings.push_integer(integer),
        None => readings.push(number(cell, decimal_comma)?),
    }
    Some(())
}

impl CsvTable {
    #[cold]
    fn not_a_number(&self, i: usize, cell: &[u8]) -> LogError {
        let text = decoded(cell).trim().to_owned();
        let is_time = self.time == Some(i);
        let hint = if text.is_empty() {
            "; the cell is empty: nan = \"gap\" in [log] leaves samples with empty cells out"
        } else if is_missing(cell) {
            "; nan = \"gap\" in [log] leaves samples without a value out"
        } else if is_time && self.dates {
            "; a date is written 2024-05-01T12:00:00.123"
        } else if is_time && date(cell).is_some() {
            "; it is a date: write time = { column = \"…\", unit = \"date\" } in [log]"
        } else if text.contains(',') || self.form.decimal_comma {
            "; write all decimals alike, with a point or (between semicolons) a comma, and no \
             thousands separators"
        } else {
            ""
        };
        LogError::NotANumber {
            file: self.file.clone(),
            place: Place::Line(self.record.position().map_or(0, Position::line) + self.skipped),
            column: self.names[i].clone(),
            cell: shortened(text),
            hint,
        }
    }
}

/// Words for a missing value, in lower case, as programs write them.
const MISSING_WORDS: [&[u8]; 6] = [b"", b"na", b"n/a", b"<na>", b"null", b"none"];

/// Returns whether a cell is empty or contains a word for a missing value. `NaN` is a number.
fn is_missing(cell: &[u8]) -> bool {
    let cell = cell.trim_ascii();
    MISSING_WORDS
        .iter()
        .any(|word| cell.eq_ignore_ascii_case(word))
}

/// Shortens a cell for an error; an unclosed quote may turn the whole file into one cell.
fn shortened(text: String) -> String {
    match text.char_indices().nth(MAX_SHOWN_CHARS) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

/// Decodes text as UTF-8, or as Latin-1 if it is not valid UTF-8.
fn decoded(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
    }
}

fn csv_error(file: &str, what: &str, error: csv::Error, skipped: u64, header: bool) -> LogError {
    match error.into_kind() {
        csv::ErrorKind::Io(source) => LogError::read(file, what, source),
        csv::ErrorKind::UnequalLengths {
            pos,
            expected_len,
            len,
        } => LogError::Width {
            file: file.to_owned(),
            place: Place::Line(pos.map_or(0, |pos| pos.line()) + skipped),
            above: if header {
                "the header has"
            } else {
                "those above have"
            },
            expected: expected_len,
            found: len,
        },
        other => LogError::format(file, format!(": {other:?}")),
    }
}

/// Replaces each run of blanks and tabs by one blank, and removes those at both ends of a line.
struct Squeeze<R> {
    inner: R,
    buffer: Vec<u8>,
    // Whether blanks precede the next character, and whether the line has a character already.
    owed: bool,
    begun: bool,
}

impl<R: Read> Squeeze<R> {
    fn new(inner: R) -> Self {
        Self {
            inner,
            buffer: Vec::new(),
            owed: false,
            begun: false,
        }
    }
}

impl<R: Read> Read for Squeeze<R> {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        // Each byte that is read may need a blank before it.
        let room = (out.len() / 2).clamp(1, 1 << 16);
        if out.len() < 2 {
            return Err(std::io::ErrorKind::InvalidInput.into());
        }
        self.buffer.resize(room, 0);
        loop {
            let count = self.inner.read(&mut self.buffer)?;
            if count == 0 {
                return Ok(0);
            }
            let mut written = 0;
            for &byte in &self.buffer[..count] {
                match byte {
                    b' ' | b'\t' => self.owed = self.begun,
                    b'\n' | b'\r' => {
                        (self.owed, self.begun) = (false, false);
                        out[written] = byte;
                        written += 1;
                    }
                    _ => {
                        if std::mem::replace(&mut self.owed, false) {
                            out[written] = b' ';
                            written += 1;
                        }
                        self.begun = true;
                        out[written] = byte;
                        written += 1;
                    }
                }
            }
            if written > 0 {
                return Ok(written);
            }
        }
    }
}
