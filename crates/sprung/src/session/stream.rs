//! Logs that are read while they are written: standard input, and files that grow.

use std::fs::File;
use std::io::{Error as IoError, ErrorKind, Read, Result as IoResult, Seek, SeekFrom};

use sprung_log::{Input, awaited};

/// Bytes that come once, in order.
pub(super) struct Stream<R> {
    read: R,
    at: u64,
}

impl<R: Read> Stream<R> {
    pub(super) fn new(read: R) -> Self {
        Self { read, at: 0 }
    }
}

impl<R: Read + Send> Input for Stream<R> {}

impl<R: Read> Read for Stream<R> {
    fn read(&mut self, bytes: &mut [u8]) -> IoResult<usize> {
        let count = self.read.read(bytes)?;
        self.at += count as u64;
        Ok(count)
    }
}

impl<R> Seek for Stream<R> {
    /// Its length is not known, so its end counts as zero.
    fn seek(&mut self, to: SeekFrom) -> IoResult<u64> {
        match to {
            SeekFrom::Start(at) if at == self.at => Ok(at),
            SeekFrom::Current(0) => Ok(self.at),
            SeekFrom::End(0) if self.at == 0 => Ok(0),
            SeekFrom::Start(_) | SeekFrom::Current(_) | SeekFrom::End(_) => Err(IoError::new(
                ErrorKind::Unsupported,
                "a stream has no way back, which this format needs; write CSV or MCAP, or give a complete file",
            )),
        }
    }
}

/// A file that grows. It ends if it has not grown for some time.
pub(super) struct Growing {
    file: File,
    patience_s: f64,
}

impl Growing {
    /// - `patience_s`: time without growth after which it ends, s.
    pub(super) fn new(file: File, patience_s: f64) -> Self {
        Self { file, patience_s }
    }
}

impl Read for Growing {
    fn read(&mut self, bytes: &mut [u8]) -> IoResult<usize> {
        let count = awaited(self.patience_s, || -> IoResult<Option<usize>> {
            let count = self.file.read(bytes)?;
            Ok((count > 0 || bytes.is_empty()).then_some(count))
        })?;
        Ok(count.unwrap_or_default())
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;
    use std::time::Duration;

    use super::*;

    const PAUSE: Duration = Duration::from_millis(50);

    #[test]
    fn a_stream_comes_once_in_order() {
        let mut stream = Stream::new(&b"abc"[..]);
        assert_eq!(stream.seek(SeekFrom::End(0)).unwrap(), 0);
        stream.rewind().unwrap();
        stream.read_exact(&mut [0; 2]).unwrap();
        assert_eq!(stream.stream_position().unwrap(), 2);
        assert!(
            stream
                .rewind()
                .unwrap_err()
                .to_string()
                .contains("no way back")
        );
    }

    #[test]
    fn a_growing_file_is_read_to_its_last_line() {
        let path = std::env::temp_dir().join(format!("sprung-growing-{}", std::process::id()));
        let mut file = File::create(&path).unwrap();
        let reader = File::open(&path).unwrap();
        let writer = std::thread::spawn(move || {
            for _ in 0..3 {
                file.write_all(b"1,2\n").unwrap();
                std::thread::sleep(2 * PAUSE);
            }
        });
        let mut text = String::new();
        Growing::new(reader, 10.0 * PAUSE.as_secs_f64())
            .read_to_string(&mut text)
            .unwrap();
        writer.join().unwrap();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(text, "1,2\n".repeat(3));
    }
}
