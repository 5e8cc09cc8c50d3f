//! Members of a zip archive, each opened as a separate reader.
//!
//! `rawzip` reads the archive's directory. A member's bytes are read here, from a second handle of the
//! file, because columns from several members are read side by side.

use std::io::{Error, ErrorKind, Read, SeekFrom};

use rawzip::{
    CompressionMethod, ErrorKind as ZipErrorKind, RECOMMENDED_BUFFER_SIZE, ZipArchive,
    ZipVerification,
};

use crate::error::LogError;
use crate::input::Input;

/// A member of an archive.
#[derive(Clone, Debug)]
pub(super) struct Member {
    pub(super) name: String,
    /// Bytes of its contents, unpacked, and their checksum.
    contents: ZipVerification,
    method: CompressionMethod,
    encrypted: bool,
    /// Where its packed bytes begin in the archive, in bytes.
    start: u64,
    /// Number of its packed bytes.
    packed_bytes: u64,
}

/// Most members of an archive; it bounds the memory that a damaged directory can request.
const MAX_MEMBERS: usize = 1 << 16;

/// Lists the members of an archive.
///
/// # Errors
///
/// [`LogError`] if the directory at the end of the archive is missing or damaged.
pub(super) fn members(file: &str, read: &mut dyn Input) -> Result<Vec<Member>, LogError> {
    let failed = |error: rawzip::Error| unreadable(file, error);
    let mut buffer = vec![0; RECOMMENDED_BUFFER_SIZE];
    let archive = ZipArchive::from_seekable(read, &mut buffer).map_err(failed)?;
    let mut members = Vec::new();
    let mut entries = archive.entries(&mut buffer);
    while let Some(entry) = entries.next_entry().map_err(failed)? {
        let place = archive.get_entry(entry.wayfinder()).map_err(failed)?;
        let (start, end) = place.compressed_data_range();
        members.push(Member {
            name: String::from_utf8_lossy(entry.file_path().as_bytes()).into_owned(),
            contents: place.reader().claim_verifier(),
            method: entry.compression_method(),
            encrypted: entry.flags().is_encrypted(),
            start,
            packed_bytes: end - start,
        });
        if members.len() > MAX_MEMBERS {
            return Err(LogError::format(
                file,
                format!(" has more than {MAX_MEMBERS} members; save the arrays of the log alone"),
            ));
        }
    }
    // A directory that is cut between two entries shows only in their number.
    if members.len() as u64 != archive.entries_hint() {
        let what = format!("{} of {} members", members.len(), archive.entries_hint());
        let error = Error::new(ErrorKind::InvalidData, format!("it lists {what}"));
        return Err(LogError::read(file, DIRECTORY, error));
    }
    Ok(members)
}

/// Name of the directory in messages.
const DIRECTORY: &str = "the list of its members";

/// Returns the error of `rawzip` as an error of the file.
fn unreadable(file: &str, error: rawzip::Error) -> LogError {
    let source = match error.into_kind() {
        ZipErrorKind::MissingEndOfCentralDirectory => {
            return LogError::format(
                file,
                " has no list of its members at its end: it was cut off; copy or write it again",
            );
        }
        ZipErrorKind::IO(error) => error,
        ZipErrorKind::Eof => ErrorKind::UnexpectedEof.into(),
        other => Error::new(ErrorKind::InvalidData, other.to_string()),
    };
    LogError::read(file, DIRECTORY, source)
}

impl Member {
    /// Returns the number of bytes of its contents, unpacked.
    pub(super) fn bytes(&self) -> u64 {
        self.contents.uncompressed_size
    }

    /// Returns a reader of its contents, which checks their checksum when the last byte is read.
    ///
    /// - `read`: a handle of the archive for this reader alone.
    ///
    /// # Errors
    ///
    /// [`LogError`] if the member is encrypted, is packed by another method than deflate, or cannot be
    /// reached.
    pub(super) fn open(
        &self,
        file: &str,
        mut read: Box<dyn Input>,
    ) -> Result<Box<dyn Read + Send>, LogError> {
        let name = &self.name;
        let refused = |why: &str| {
            let remedy = "write it with numpy.savez or numpy.savez_compressed";
            Err(LogError::format(file, format!(": {name} {why}; {remedy}")))
        };
        if self.encrypted {
            return refused("is encrypted");
        }
        read.seek(SeekFrom::Start(self.start))
            .map_err(|error| LogError::read(file, name, error))?;
        let packed = read.take(self.packed_bytes);
        let inner: Box<dyn Read + Send> = match self.method {
            CompressionMethod::STORE => Box::new(packed),
            CompressionMethod::DEFLATE => Box::new(flate2::read::DeflateDecoder::new(packed)),
            other => return refused(&format!("is compressed with method {other}")),
        };
        Ok(Box::new(Checked {
            inner,
            sum: flate2::Crc::new(),
            left: self.contents.uncompressed_size,
            expected: self.contents.crc,
        }))
    }
}

/// A reader that ends after `left` bytes, and there compares their checksum.
struct Checked<R> {
    inner: R,
    sum: flate2::Crc,
    left: u64,
    expected: u32,
}

impl<R: Read> Read for Checked<R> {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        let room = out
            .len()
            .min(usize::try_from(self.left).unwrap_or(usize::MAX));
        if room == 0 {
            return Ok(0);
        }
        let count = self.inner.read(&mut out[..room])?;
        self.sum.update(&out[..count]);
        self.left -= count as u64;
        if self.left == 0 && self.sum.sum() != self.expected {
            return Err(Error::new(ErrorKind::InvalidData, "its checksum is wrong"));
        }
        Ok(count)
    }
}
