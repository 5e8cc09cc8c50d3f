//! CSV logs with a header line.

use std::io::Read;

use csv::{ByteRecord, Reader, ReaderBuilder, Trim};

use super::channels::Channels;
use super::{BLOCK, Clock, LogBlock, LogError};

/// A CSV log that is read block by block.
pub struct CsvLog<R> {
    file: String,
    reader: Reader<R>,
    record: ByteRecord,
    names: Vec<String>,
    columns: Vec<usize>,
    time_factor: f64,
    factors: Vec<f64>,
    clock: Clock,
    line: u64,
}

impl<R: Read> CsvLog<R> {
    /// Opens a log and finds its columns.
    ///
    /// - `file`: name for messages.
    ///
    /// # Errors
    ///
    /// [`LogError`] if the header cannot be read or a column is not there.
    pub fn new(file: &str, read: R, channels: &Channels) -> Result<Self, LogError> {
        let mut reader = ReaderBuilder::new()
            .trim(Trim::Headers)
            .buffer_capacity(1 << 18)
            .comment(Some(b'#'))
            .from_reader(read);
        let header = reader
            .byte_headers()
            .map_err(|error| csv_error(file, error))?;
        let mut header: Vec<String> = header
            .iter()
            .map(|name| String::from_utf8_lossy(name).into_owned())
            .collect();
        if let Some(first) = header.first_mut() {
            *first = first.trim_start_matches('\u{feff}').to_owned();
        }
        if header.iter().all(String::is_empty) {
            return Err(LogError::TooShort {
                file: file.to_owned(),
                found: 0,
                needed: 2,
                why: "the file is empty, not even a header line is there".to_owned(),
            });
        }
        let names: Vec<String> = std::iter::once(&channels.time)
            .chain(channels.all.iter().map(|channel| &channel.column))
            .cloned()
            .collect();
        let columns = names
            .iter()
            .map(|name| {
                let mut places = header
                    .iter()
                    .enumerate()
                    .filter(|(_, column)| *column == name);
                match (places.next(), places.next()) {
                    (None, _) => Err(no_column(file, name, &header)),
                    (Some((place, _)), None) => Ok(place),
                    (Some(_), Some(_)) => Err(LogError::TwoColumns {
                        file: file.to_owned(),
                        column: name.clone(),
                    }),
                }
            })
            .collect::<Result<_, _>>()?;
        Ok(Self {
            file: file.to_owned(),
            reader,
            record: ByteRecord::new(),
            names,
            columns,
            time_factor: channels.time_factor,
            factors: channels.all.iter().map(|channel| channel.factor).collect(),
            clock: Clock::new(file),
            line: 1,
        })
    }

    /// Reads the next block; returns false when the log has ended.
    ///
    /// # Errors
    ///
    /// [`LogError`] naming line, column and value of the first bad cell, or
    /// the line at which time goes wrong.
    pub fn read(&mut self, block: &mut LogBlock) -> Result<bool, LogError> {
        block.clear();
        let first = self.clock.samples();
        while block.len() < BLOCK {
            let more = self
                .reader
                .read_byte_record(&mut self.record)
                .map_err(|error| csv_error(&self.file, error))?;
            if !more {
                break;
            }
            self.line = self.record.position().map_or(0, csv::Position::line);
            let time = self.number(0)? * self.time_factor;
            self.clock.tick(self.line, time)?;
            block.time.push(time);
            for i in 0..self.factors.len() {
                let value = self.number(i + 1)? * self.factors[i];
                block.values[i].push(value);
            }
        }
        if block.len() < BLOCK {
            self.clock.finish()?;
        }
        // The period is known within the first block, so none is missed.
        let gaps = self.clock.new_gaps().into_iter();
        block
            .gaps
            .extend(gaps.map(|sample| (sample - first) as usize));
        Ok(!block.is_empty())
    }

    /// Returns the clock, which knows period and number of samples so far.
    #[must_use]
    pub fn clock(&self) -> &Clock {
        &self.clock
    }

    fn number(&self, i: usize) -> Result<f64, LogError> {
        let cell = self.record.get(self.columns[i]).unwrap_or_default();
        let value = std::str::from_utf8(cell)
            .ok()
            .and_then(|text| text.trim().parse::<f64>().ok())
            .ok_or_else(|| self.not_a_number(i, cell))?;
        if value.is_finite() {
            Ok(value)
        } else {
            Err(LogError::NotFinite {
                file: self.file.clone(),
                line: self.line,
                column: self.names[i].clone(),
                value,
            })
        }
    }

    #[cold]
    fn not_a_number(&self, i: usize, cell: &[u8]) -> LogError {
        let cell = String::from_utf8_lossy(cell).trim().to_owned();
        let hint = if cell.is_empty() {
            "; the cell is empty"
        } else if cell.contains(',') {
            "; write decimals with a point and no thousands separators"
        } else {
            ""
        };
        LogError::NotANumber {
            file: self.file.clone(),
            line: self.line,
            column: self.names[i].clone(),
            cell,
            hint,
        }
    }
}

fn no_column(file: &str, column: &str, header: &[String]) -> LogError {
    let nearest = header
        .iter()
        .map(|name| (strsim::damerau_levenshtein(column, name), name))
        .min_by_key(|&(distance, _)| distance)
        .filter(|&(distance, name)| distance <= 1 + name.len() / 2);
    let other = header.first().filter(|_| header.len() == 1);
    let separator = other.and_then(|line| line.chars().find(|c| ";\t|".contains(*c)));
    if let Some(separator) = separator {
        return LogError::NoColumn {
            file: file.to_owned(),
            column: column.to_owned(),
            hint: format!("; its cells are separated by {separator:?}, only commas are read"),
        };
    }
    let hint = match nearest {
        Some((_, name)) => format!("; did you mean \"{name}\"?"),
        None => format!("; its columns are {}", header.join(", ")),
    };
    LogError::NoColumn {
        file: file.to_owned(),
        column: column.to_owned(),
        hint,
    }
}

fn csv_error(file: &str, error: csv::Error) -> LogError {
    let file = file.to_owned();
    match error.into_kind() {
        csv::ErrorKind::Io(source) => LogError::Io { file, source },
        csv::ErrorKind::UnequalLengths {
            pos,
            expected_len,
            len,
        } => LogError::Width {
            file,
            line: pos.map_or(0, |pos| pos.line()),
            expected: expected_len,
            found: len,
        },
        other => LogError::Csv {
            file,
            message: format!("{other:?}"),
        },
    }
}
