//! The bytes of a text as its recorder left them: lines of bounded length, up to the place where it was cut off.

use std::io::{Error, ErrorKind, Read, Result};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};

use crate::input_limits::LINE_BYTES;

/// What a reader of lines and the reader of its bytes tell each other.
#[derive(Debug, Default)]
pub(super) struct Watch {
    // Bytes that may be read before the next row must be complete.
    left: AtomicUsize,
    // Whether the bytes end in the middle of a compressed stream, or with NUL bytes.
    is_cut: AtomicBool,
    // Whether the end was reached.
    is_done: AtomicBool,
    // Whether the last byte ends a line.
    ends_line: AtomicBool,
}

impl Watch {
    /// Allows a row of the largest length.
    ///
    /// - `ahead`: bytes that the reader of lines takes at once.
    pub(super) fn begin_row(&self, ahead: usize) {
        self.left.store(LINE_BYTES + ahead, Relaxed);
    }

    /// Returns whether the last row was longer than allowed.
    pub(super) fn is_too_long(&self) -> bool {
        self.left.load(Relaxed) == 0
    }

    /// Returns whether the bytes that were read end in the middle of a compressed stream, or with NUL bytes.
    pub(super) fn is_cut(&self) -> bool {
        self.is_cut.load(Relaxed)
    }

    /// Returns whether the last row that was read is the last of the text, and its line has no end.
    ///
    /// A reader of lines asks for more bytes only after all others, so the end is reached before this row is complete.
    pub(super) fn ends_in_row(&self) -> bool {
        self.is_done.load(Relaxed) && !self.ends_line.load(Relaxed)
    }
}

/// A compressed stream that ends where it was cut off.
pub(super) struct UpToCut<R> {
    inner: R,
    watch: Arc<Watch>,
}

impl<R: Read> UpToCut<R> {
    pub(super) fn new(inner: R, watch: Arc<Watch>) -> Self {
        Self { inner, watch }
    }
}

impl<R: Read> Read for UpToCut<R> {
    fn read(&mut self, out: &mut [u8]) -> Result<usize> {
        if self.watch.is_cut() {
            return Ok(0);
        }
        match self.inner.read(out) {
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => {
                self.watch.is_cut.store(true, Relaxed);
                Ok(0)
            }
            read => read,
        }
    }
}

/// Reads a text up to its first NUL byte.
pub(super) struct Recording<R> {
    inner: R,
    watch: Arc<Watch>,
    ended: bool,
}

impl<R: Read> Recording<R> {
    pub(super) fn new(inner: R, watch: Arc<Watch>) -> Self {
        Self {
            inner,
            watch,
            ended: false,
        }
    }
}

impl<R: Read> Read for Recording<R> {
    fn read(&mut self, out: &mut [u8]) -> Result<usize> {
        let left = self.watch.left.load(Relaxed);
        let room = out.len().min(left);
        if room == 0 && !out.is_empty() {
            return Err(Error::from(ErrorKind::FileTooLarge));
        }
        let mut count = if self.ended {
            0
        } else {
            self.inner.read(&mut out[..room])?
        };
        self.watch.left.store(left - count, Relaxed);
        if let Some(end) = out[..count].iter().position(|&byte| byte == 0) {
            // A file system that lost power fills what it did not write with NUL bytes.
            self.watch.is_cut.store(true, Relaxed);
            self.ended = true;
            count = end;
        }
        if count > 0 {
            let ends_line = matches!(out[count - 1], b'\n' | b'\r');
            self.watch.ends_line.store(ends_line, Relaxed);
        } else {
            self.watch.is_done.store(true, Relaxed);
        }
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: &[u8], most: usize) -> (Result<usize>, Arc<Watch>) {
        let watch = Arc::new(Watch::default());
        watch.left.store(most, Relaxed);
        let mut recording = Recording::new(bytes, Arc::clone(&watch));
        let count = std::io::copy(&mut recording, &mut std::io::sink());
        (count.map(|count| count as usize), watch)
    }

    #[test]
    fn a_text_ends_at_its_first_nul_and_a_row_at_its_largest_length() {
        for (bytes, count, is_cut, ends_in_row) in [
            (&b"1,2\n"[..], 4, false, false),
            (b"1,2", 3, false, true),
            (b"1,2\n\0\0", 4, true, false),
            (b"1,\0\0\n3,4\n", 2, true, true),
        ] {
            let (found, watch) = read(bytes, 100);
            assert_eq!(found.unwrap(), count);
            assert_eq!((watch.is_cut(), watch.ends_in_row()), (is_cut, ends_in_row));
            assert!(!watch.is_too_long());
        }
        let (found, watch) = read(b"123456", 5);
        assert_eq!(found.unwrap_err().kind(), ErrorKind::FileTooLarge);
        assert!(watch.is_too_long());
    }
}
