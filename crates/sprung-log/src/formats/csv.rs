//! Text of numbers between delimiters.

use std::io::{ErrorKind, Read};
use std::sync::Arc;

use csv::{ByteRecord, Position, Reader, ReaderBuilder};

use super::delimited::{Delimiter, Form, date, is_missing, number};
use super::recording::{Recording, Watch};
use super::table::{Opened, Readings, Request, Table};
use crate::columns::names::Names;
use crate::description::MissingValues;
use crate::error::{LogError, Place};
use crate::foreign::shortened;
use crate::input_limits::{CELL_BYTES, COLUMNS, LINE_BYTES, NAME_BYTES, size};

/// Bytes that the reader of lines takes at once.
const BUFFER_BYTES: usize = 1 << 18;

type Source = Box<dyn Read + Send>;

struct CsvTable {
    file: String,
    lines: Lines,
    // Names and indices of the wanted columns.
    names: Vec<String>,
    cells: Vec<usize>,
    form: Form,
    time: Option<usize>,
    dates: bool,
    nan: MissingValues,
    // Line of each row of the last block.
    places: Vec<u64>,
    // Line in the middle of which the text was cut off.
    cut: Option<u64>,
    // Whether `record` contains the first row, which was read to count the columns.
    pending: bool,
}

/// Opens a text.
///
/// - `what`: name of the text in errors.
/// - `start`: first bytes of the text.
/// - `whole`: whether `start` is the whole text.
/// - `watch`: that of the stream that contains the text.
pub(super) fn open(
    request: &Request<'_>,
    (what, watch): (&str, Arc<Watch>),
    (start, whole): (&[u8], bool),
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
    let start = start.split(|&byte| byte == 0).next().unwrap_or_default();
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
    let recording = Recording::new(read, Arc::clone(&watch));
    let read: Source = match form.delimiter {
        Delimiter::Blanks => Box::new(Squeeze::new(recording)),
        Delimiter::Byte(_) => Box::new(recording),
    };
    let mut lines = Lines {
        file: file.to_owned(),
        what: what.to_owned(),
        reader: reader(&form, read),
        watch,
        record: ByteRecord::new(),
        skipped,
        above: if form.header {
            "the header has"
        } else {
            "those above have"
        },
    };
    if !lines.next()? {
        if lines.watch.is_cut() {
            return Err(LogError::read(file, what, ErrorKind::UnexpectedEof.into()));
        }
        return Err(empty(file));
    }
    let given_by_header = form.header;
    let given = form.header || form.commented_names.is_some();
    let all = names_of(file, &form, &lines.record)?;
    if !form.units.is_empty() {
        lines.next()?;
    }
    let names = Names {
        file,
        all: &all,
        given,
    };
    let places = (request.picks.iter())
        .map(|pick| names.find(pick))
        .collect::<Result<Vec<usize>, LogError>>()?;
    let names: Vec<String> = places.iter().map(|&place| all[place].clone()).collect();
    let units = form.units.clone();
    let table = CsvTable {
        form,
        file: file.to_owned(),
        lines,
        names: names.clone(),
        cells: places,
        pending: !given_by_header,
        time: request.time,
        dates: request.dates,
        nan: request.nan,
        places: Vec::new(),
        cut: None,
    };
    Ok(Opened {
        table: Box::new(table),
        names,
        time_unit: request.dates.then_some(1e-9),
        all,
        has_names: given,
        units,
    })
}

fn empty(file: &str) -> LogError {
    LogError::TooShort {
        file: file.to_owned(),
        found: 0,
        needed: 2,
        why: "the file is empty, not even a header line is there".to_owned(),
    }
}

/// Returns the names of the columns, or their numbers if the text has no names.
///
/// - `first`: the first row.
fn names_of(file: &str, form: &Form, first: &ByteRecord) -> Result<Vec<String>, LogError> {
    let all: Vec<String> = match &form.commented_names {
        Some(names) => names.clone(),
        None if form.header => (first.iter())
            .map(|name| decoded(name).trim().to_owned())
            .collect(),
        None => (1..=first.len()).map(|number| number.to_string()).collect(),
    };
    match all.iter().find(|name| name.len() > NAME_BYTES) {
        None => Ok(all),
        Some(name) => Err(LogError::format(
            file,
            format!(
                ": the name of a column has {} bytes, and {} are the most; it begins with \"{}\"",
                name.len(),
                size(NAME_BYTES),
                shortened(name)
            ),
        )),
    }
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
    None
}

/// Returns a reader of the rows of a text.
fn reader(form: &Form, read: Source) -> Reader<Source> {
    ReaderBuilder::new()
        .has_headers(false)
        .buffer_capacity(BUFFER_BYTES)
        .comment(Some(form.comment))
        .delimiter(match form.delimiter {
            Delimiter::Byte(byte) => byte,
            Delimiter::Blanks => b' ',
        })
        .from_reader(read)
}

/// The rows of a text, of bounded length.
struct Lines {
    file: String,
    what: String,
    reader: Reader<Source>,
    watch: Arc<Watch>,
    // The last row.
    record: ByteRecord,
    // Lines before the first line of the reader.
    skipped: u64,
    // What the number of cells is compared with.
    above: &'static str,
}

impl Lines {
    /// Reads the next row; returns false at the end.
    fn next(&mut self) -> Result<bool, LogError> {
        self.watch.begin_row(BUFFER_BYTES);
        match self.reader.read_byte_record(&mut self.record) {
            Ok(more) => self.check().map(|()| more),
            Err(_) if self.watch.is_too_long() => Err(self.too_long()),
            Err(error) => {
                // A row with a wrong number of cells may be too long as well.
                self.check()?;
                Err(csv_error(self, error))
            }
        }
    }

    /// Returns the line of the last row.
    fn line(&self) -> u64 {
        self.record.position().map_or(0, Position::line) + self.skipped
    }

    /// Checks the number of cells of the last row, and their lengths.
    fn check(&self) -> Result<(), LogError> {
        if self.record.len() > COLUMNS {
            return Err(self.excess(&format!(
                "has {} cells, and a log has at most {COLUMNS} columns",
                self.record.len()
            )));
        }
        let bytes = self.record.as_slice().len();
        if bytes > LINE_BYTES {
            return Err(self.too_long());
        }
        if bytes > CELL_BYTES
            && let Some(cell) = self.record.iter().find(|cell| cell.len() > CELL_BYTES)
        {
            return Err(self.excess(&format!(
                "has a cell of {} bytes, and {} are the most; is a quote without its partner?",
                cell.len(),
                size(CELL_BYTES)
            )));
        }
        Ok(())
    }

    fn too_long(&self) -> LogError {
        let line = self.reader.position().line() + self.skipped;
        LogError::format(
            &self.file,
            format!(
                ": line {line} has more than {}, and no line of a log is longer; is a quote without its partner, or \
                 do the line ends lack?",
                size(LINE_BYTES)
            ),
        )
    }

    fn excess(&self, what: &str) -> LogError {
        LogError::format(&self.file, format!(": line {} {what}", self.line()))
    }
}

impl Table for CsvTable {
    fn read(&mut self, limit: usize, out: &mut [Readings]) -> Result<usize, LogError> {
        self.places.clear();
        while self.places.len() < limit && self.cut.is_none() {
            if !std::mem::replace(&mut self.pending, false) {
                match self.lines.next() {
                    Ok(true) => {}
                    Ok(false) => {
                        if self.lines.watch.is_cut() {
                            self.cut =
                                Some(self.lines.reader.position().line() + self.lines.skipped);
                        }
                        break;
                    }
                    Err(error @ LogError::Width { .. }) => {
                        let line = self.lines.line();
                        if !self.lines.watch.ends_in_row() {
                            return Err(error);
                        }
                        self.cut = Some(line);
                        break;
                    }
                    Err(error) => return Err(error),
                }
            }
            let line = self.lines.line();
            // A number at the end of a text that was cut off may lack digits.
            if self.lines.watch.is_cut() && self.lines.watch.ends_in_row() {
                self.cut = Some(line);
                break;
            }
            let fault = (out.iter_mut().enumerate())
                .find_map(|(i, readings)| self.take(i, readings).err().map(|error| (i, error)));
            if let Some((i, error)) = fault {
                if !self.lines.watch.ends_in_row() {
                    // The reader of a window keeps the complete rows.
                    self.places.push(line);
                    return Err(error);
                }
                for readings in &mut out[..i] {
                    readings.values.pop();
                }
                self.cut = Some(line);
                break;
            }
            self.places.push(line);
        }
        Ok(self.places.len())
    }

    fn place(&self, i: usize) -> Place {
        Place::Line(self.places.get(i).copied().unwrap_or_default())
    }

    fn cut(&self) -> Option<Place> {
        self.cut.map(Place::Line)
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
    /// Appends the reading of the `i`th wanted column.
    fn take(&self, i: usize, readings: &mut Readings) -> Result<(), LogError> {
        let cell = (self.lines.record.get(self.cells[i])).unwrap_or_default();
        if self.nan == MissingValues::Gap && is_missing(cell) {
            readings.push_missing();
            return Ok(());
        }
        let pushed = if self.time == Some(i) {
            push_time(readings, cell, self.dates, self.form.decimal_comma)
        } else {
            number(cell, self.form.decimal_comma).map(|value| readings.push(value))
        };
        pushed.ok_or_else(|| self.not_a_number(i, cell))
    }

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
            place: Place::Line(self.lines.line()),
            column: self.names[i].clone(),
            cell: shortened(&text),
            hint,
        }
    }
}

/// Decodes text as UTF-8, or as Latin-1 if it is not valid UTF-8.
fn decoded(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
    }
}

fn csv_error(lines: &Lines, error: csv::Error) -> LogError {
    let file = &lines.file;
    match error.into_kind() {
        csv::ErrorKind::Io(source) => LogError::read(file, &lines.what, source),
        csv::ErrorKind::UnequalLengths {
            pos,
            expected_len,
            len,
        } => LogError::Width {
            file: file.clone(),
            place: Place::Line(pos.map_or(0, |pos| pos.line()) + lines.skipped),
            above: lines.above,
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
