//! Numbers of fixed size in a row: the inside of arrays.

use std::io::Read;

use super::super::{LogError, Place};
use super::{Readings, Table};

/// How a number is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    F64,
    F32,
    I8,
    I16,
    I32,
    I64,
    U8,
    U16,
    U32,
    U64,
}

impl Number {
    /// Returns its size in bytes.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::F32 | Self::I32 | Self::U32 => 4,
            Self::F64 | Self::I64 | Self::U64 => 8,
        }
    }

    /// Appends the number that some bytes hold.
    fn push(self, bytes: &[u8], big_endian: bool, out: &mut Readings) {
        let mut word = [0_u8; 8];
        let size = self.size();
        for (to, from) in word.iter_mut().zip(&bytes[..size]) {
            *to = *from;
        }
        if big_endian {
            word[..size].reverse();
        }
        let bits = u64::from_le_bytes(word);
        match self {
            Self::F64 => out.push(f64::from_bits(bits)),
            Self::F32 => out.push(f64::from(f32::from_bits(bits as u32))),
            Self::I8 => out.push_integer(i64::from(bits as i8)),
            Self::I16 => out.push_integer(i64::from(bits as i16)),
            Self::I32 => out.push_integer(i64::from(bits as i32)),
            Self::I64 => out.push_integer(bits as i64),
            Self::U8 | Self::U16 | Self::U32 => out.push_integer(bits as i64),
            Self::U64 => match i64::try_from(bits) {
                Ok(value) => out.push_integer(value),
                Err(_) => out.push(bits as f64),
            },
        }
    }
}

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
const AT_ONCE: usize = 1 << 20;

impl Table for StripTable {
    fn read(&mut self, limit: usize, out: &mut [Readings]) -> Result<usize, LogError> {
        let widest = self.strips.iter().map(|strip| strip.record).max();
        let fit = (AT_ONCE / widest.unwrap_or(1).max(1)).max(1);
        let left = usize::try_from(self.rows - self.done).unwrap_or(usize::MAX);
        let count = limit.min(fit).min(left);
        for strip in &mut self.strips {
            self.buffer.resize(count * strip.record, 0);
            (strip.read.read_exact(&mut self.buffer))
                .map_err(|error| LogError::read(&self.file, &strip.name, error))?;
            for record in self.buffer.chunks_exact(strip.record.max(1)) {
                for cell in &strip.cells {
                    let bytes = &record[cell.at..];
                    cell.number.push(bytes, strip.big_endian, &mut out[cell.out]);
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
