//! Records of numbers of fixed size, as arrays store them.

use std::io::Read;

use super::number::Number;
use super::table::{Readings, Table};
use crate::error::{LogError, Place};

/// A number within a record.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    /// Bytes before it in the record.
    pub(super) at: usize,
    pub(super) number: Number,
    /// Index of its column among the wanted ones.
    pub(super) out: usize,
}

/// A reader of records of equal size that follow one another.
pub(super) struct Strip {
    /// Name of the column or array, for messages.
    pub(super) name: String,
    /// A reader at the first record.
    pub(super) read: Box<dyn Read + Send>,
    /// Bytes of a record.
    pub(super) record: usize,
    /// Numbers of a record that are wanted.
    pub(super) cells: Vec<Cell>,
    pub(super) big_endian: bool,
}

/// Strips that are read side by side, a block of rows at a time; each gives some of the columns.
pub(super) struct StripTable {
    file: String,
    strips: Vec<Strip>,
    rows: u64,
    /// Rows that were read.
    done: u64,
    /// Rows before the last block.
    before: u64,
    buffer: Vec<u8>,
}

impl StripTable {
    /// Returns a table of so many rows.
    ///
    /// - `file`: its name, for messages.
    pub(super) fn new(file: &str, strips: Vec<Strip>, rows: u64) -> Self {
        Self {
            file: file.to_owned(),
            strips,
            rows,
            done: 0,
            before: 0,
            buffer: Vec::new(),
        }
    }
}

/// Most bytes that are read from a strip at once.
const READ_BYTES: usize = 1 << 20;

impl Table for StripTable {
    fn read(&mut self, limit: usize, out: &mut [Readings]) -> Result<usize, LogError> {
        let widest = self.strips.iter().map(|strip| strip.record).max();
        let fit = (READ_BYTES / widest.unwrap_or(1).max(1)).max(1);
        let left = usize::try_from(self.rows - self.done).unwrap_or(usize::MAX);
        let count = limit.min(fit).min(left);
        for strip in &mut self.strips {
            self.buffer.resize(count * strip.record, 0);
            (strip.read.read_exact(&mut self.buffer))
                .map_err(|error| LogError::read(&self.file, &strip.name, error))?;
            for record in self.buffer.chunks_exact(strip.record.max(1)) {
                for cell in &strip.cells {
                    let bytes = &record[cell.at..cell.at + cell.number.size()];
                    out[cell.out].push_reading(cell.number.read(bytes, strip.big_endian));
                }
            }
        }
        self.before = self.done;
        self.done += count as u64;
        Ok(count)
    }

    fn place(&self, i: usize) -> Place {
        Place::Row(self.before + i as u64 + 1)
    }
}

/// Skips so many bytes.
///
/// # Errors
///
/// `UnexpectedEof` if there are fewer.
pub(super) fn skip(read: &mut dyn Read, bytes: u64) -> std::io::Result<()> {
    let skipped = std::io::copy(&mut read.take(bytes), &mut std::io::sink())?;
    if skipped == bytes {
        Ok(())
    } else {
        Err(std::io::ErrorKind::UnexpectedEof.into())
    }
}
