//! A file that several readers of Parquet share.

use std::io::{BufReader, Read, Seek, SeekFrom};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bytes::Bytes;
use parquet::errors::ParquetError;
use parquet::file::reader::{ChunkReader, Length};

use crate::input::Input;

/// A file that several readers share, each with its own position.
pub(super) struct Shared {
    input: Arc<Mutex<Box<dyn Input>>>,
    length: u64,
}

impl Shared {
    pub(super) fn new(mut input: Box<dyn Input>) -> std::io::Result<Self> {
        let length = input.seek(SeekFrom::End(0))?;
        Ok(Self {
            input: Arc::new(Mutex::new(input)),
            length,
        })
    }
}

fn locked(input: &Mutex<Box<dyn Input>>) -> MutexGuard<'_, Box<dyn Input>> {
    input.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A reader with its own position in a shared file.
pub(super) struct Part {
    input: Arc<Mutex<Box<dyn Input>>>,
    at: u64,
}

impl Read for Part {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        let mut input = locked(&self.input);
        input.seek(SeekFrom::Start(self.at))?;
        let count = input.read(out)?;
        self.at += count as u64;
        Ok(count)
    }
}

impl Length for Shared {
    fn len(&self) -> u64 {
        self.length
    }
}

impl ChunkReader for Shared {
    type T = BufReader<Part>;

    fn get_read(&self, start: u64) -> Result<Self::T, ParquetError> {
        Ok(BufReader::new(Part {
            input: self.input.clone(),
            at: start,
        }))
    }

    fn get_bytes(&self, start: u64, length: usize) -> Result<Bytes, ParquetError> {
        let end = start.checked_add(length as u64);
        if end.is_none_or(|end| end > self.length) {
            return Err(ParquetError::EOF(format!(
                "{length} bytes at {start} are missing"
            )));
        }
        let mut bytes = vec![0; length];
        let mut input = locked(&self.input);
        input.seek(SeekFrom::Start(start))?;
        input.read_exact(&mut bytes)?;
        Ok(bytes.into())
    }
}
