//! Measures which part of a file has been read.

use std::io::{Read, Result as IoResult, Seek, SeekFrom};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::input::Input;

/// Number of bytes that were read from a file, and its length.
#[derive(Clone, Debug, Default)]
pub(super) struct Meter(Arc<Bytes>);

#[derive(Debug, Default)]
struct Bytes {
    read: AtomicU64,
    length: AtomicU64,
}

impl Meter {
    /// Returns an input whose reads are counted.
    pub(super) fn on(&self, mut input: Box<dyn Input>) -> IoResult<Box<dyn Input>> {
        let length = input.seek(SeekFrom::End(0))?;
        input.rewind()?;
        self.0.length.store(length, Ordering::Relaxed);
        Ok(Box::new(Metered {
            input,
            meter: self.clone(),
        }))
    }

    /// Returns the part of the file that has been read, 0 to 1; `None` if nothing was counted.
    pub(super) fn part(&self) -> Option<f64> {
        let read = self.0.read.load(Ordering::Relaxed);
        let length = self.0.length.load(Ordering::Relaxed);
        (read > 0 && length > 0).then(|| (read as f64 / length as f64).min(1.0))
    }
}

struct Metered {
    input: Box<dyn Input>,
    meter: Meter,
}

impl Input for Metered {
    fn path(&self) -> Option<&Path> {
        self.input.path()
    }

    fn patience_s(&self) -> Option<f64> {
        self.input.patience_s()
    }
}

impl Read for Metered {
    fn read(&mut self, bytes: &mut [u8]) -> IoResult<usize> {
        let count = self.input.read(bytes)?;
        self.meter.0.read.fetch_add(count as u64, Ordering::Relaxed);
        Ok(count)
    }
}

impl Seek for Metered {
    fn seek(&mut self, to: SeekFrom) -> IoResult<u64> {
        self.input.seek(to)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    #[test]
    fn reads_are_counted() {
        let meter = Meter::default();
        assert_eq!(meter.part(), None);
        let mut input = meter.on(Box::new(Cursor::new(vec![0_u8; 100]))).unwrap();
        assert_eq!(meter.part(), None);
        input.read_exact(&mut [0; 25]).unwrap();
        assert_eq!(meter.part(), Some(0.25));
        input.rewind().unwrap();
        input.read_to_end(&mut Vec::new()).unwrap();
        assert_eq!(meter.part(), Some(1.0));
    }
}
