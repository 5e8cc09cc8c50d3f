//! Numbers of fixed size in a row: the inside of arrays.

use std::io::Read;

use super::number::Number;
use super::table::{Readings, Table};
use crate::log::error::{LogError, Place};

/// A number within a record.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    /// Bytes before it.
    pub(super) at: usize,
    pub(super) number: Number,
    /// The column that it belongs to.
    pub(super) out: usize,
}

/// Records of equal size, one after the other.
pub(super) struct Strip {
    /// What it is called in messages.
    pub(super) name: String,
    /// Stands at the first record.
    pub(super) read: Box<dyn Read + Send>,
    /// Bytes of a record.
    pub(super) record: usize,
    /// Wanted numbers of a record.
    pub(super) cells: Vec<Cell>,
    pub(super) big_endian: bool,
}

/// Strips beside one another; each gives some of the columns.
pub(super) struct StripTable {
    pub(super) file: String,
    pub(super) strips: Vec<Strip>,
    pub(super) rows: u64,
    pub(super) done: u64,
    pub(super) before: u64,
    pub(super) buffer: Vec<u8>,
}

impl StripTable {
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

/// Bytes that are read at once, at most.
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

/// Reads past some bytes.
pub(super) fn skip(read: &mut dyn Read, bytes: u64) -> std::io::Result<()> {
    let skipped = std::io::copy(&mut read.take(bytes), &mut std::io::sink())?;
    if skipped == bytes {
        Ok(())
    } else {
        Err(std::io::ErrorKind::UnexpectedEof.into())
    }
}
