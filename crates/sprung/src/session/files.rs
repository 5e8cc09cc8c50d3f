//! Access to the files of an experiment.

use std::fs::{File, FileType};
use std::io::{Error as IoError, ErrorKind, Read, Result as IoResult};
use std::path::Path;

use super::bag::of_bag;
use super::error::SessionError;
use super::switch::finish;
use sprung_base::limits::{check_json, read_text_bytes};
use sprung_log::{Input, LogFile};
use sprung_robot::NamedFiles;

/// Opens the files that an experiment names.
///
/// The paths are those of the experiment file; if the session has a folder, they are relative to
/// it. Every closure from a path to an input implements this trait.
pub trait Files: Send + Sync {
    /// Opens a log at its beginning. It is called once per reading of the log.
    ///
    /// # Errors
    ///
    /// The error of opening the file.
    fn open(&self, path: &Path) -> IoResult<Box<dyn Input>>;

    /// Returns a text file.
    ///
    /// # Errors
    ///
    /// The error of reading the file.
    fn text(&self, path: &Path) -> IoResult<String> {
        text_of(read_text_bytes(self.open(path)?)?)
    }

    /// Prepares a folder before its results are read: completes the renames of a run that was
    /// killed. The default has no effect, which suffices if no run can be killed.
    ///
    /// # Errors
    ///
    /// [`SessionError`] if this fails.
    fn settle(&self, _folder: &Path) -> Result<(), SessionError> {
        Ok(())
    }
}

impl<F: Fn(&Path) -> IoResult<Box<dyn Input>> + Send + Sync> Files for F {
    fn open(&self, path: &Path) -> IoResult<Box<dyn Input>> {
        self(path)
    }
}

/// Files of the file system. A folder given as a log is a bag of ROS 2.
#[derive(Clone, Copy, Debug, Default)]
pub struct Disk;

impl Files for Disk {
    fn open(&self, path: &Path) -> IoResult<Box<dyn Input>> {
        if path.is_dir() {
            let path = of_bag(path)?;
            return Ok(Box::new(LogFile::new(open_file(&path)?, &path)));
        }
        Ok(Box::new(LogFile::new(open_file(path)?, path)))
    }

    fn text(&self, path: &Path) -> IoResult<String> {
        text_of(read_text_bytes(open_file(path)?)?)
    }

    fn settle(&self, folder: &Path) -> Result<(), SessionError> {
        finish(folder)
    }
}

/// Opens a file. A pipe would wait for its writer, and a device or a pipe cannot be read a second time.
///
/// # Errors
///
/// The error of opening the file, or its kind if it is a pipe, a socket or a device.
pub(super) fn open_file(path: &Path) -> IoResult<File> {
    let kind = std::fs::metadata(path)?.file_type();
    if kind.is_file() || kind.is_dir() {
        return File::open(path);
    }
    let kind = special(kind);
    Err(IoError::new(
        ErrorKind::InvalidInput,
        format!(
            "it is {kind}, and sprung reads files only; write its contents to a file and give that"
        ),
    ))
}

#[cfg(unix)]
fn special(kind: FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    if kind.is_fifo() {
        "a pipe"
    } else if kind.is_socket() {
        "a socket"
    } else {
        "a device"
    }
}

#[cfg(not(unix))]
fn special(_: FileType) -> &'static str {
    "a device"
}

/// The files that an experiment names, by their paths relative to a folder.
pub(super) struct InFolder<'a>(pub(super) &'a dyn Files, pub(super) &'a Path);

impl NamedFiles for InFolder<'_> {
    fn text(&mut self, path: &Path) -> IoResult<String> {
        self.0.text(&self.1.join(path))
    }

    fn bytes(&mut self, path: &Path, limit: u64) -> IoResult<Vec<u8>> {
        let mut bytes = Vec::new();
        let file = self.0.open(&self.1.join(path))?;
        file.take(limit).read_to_end(&mut bytes)?;
        Ok(bytes)
    }
}

/// Returns a text file.
///
/// # Errors
///
/// [`SessionError::Unreadable`] with the name of the file.
pub(super) fn read_text(files: &dyn Files, path: &Path) -> Result<String, SessionError> {
    let text = files.text(path).and_then(|text| {
        if path.extension().is_some_and(|end| end == "json") {
            check_json(&text).map_err(|why| IoError::new(ErrorKind::FileTooLarge, why))?;
        }
        Ok(text)
    });
    text.map_err(|source| SessionError::Unreadable {
        file: path.display().to_string(),
        source,
    })
}

/// First bytes of files that are sometimes given in place of a text.
const KINDS: [(&[u8], &str); 9] = [
    (b"\x89PNG", "a PNG image"),
    (b"\xff\xd8\xff", "a JPEG image"),
    (b"%PDF", "a PDF document"),
    (b"PK\x03\x04", "a ZIP archive"),
    (b"\x1f\x8b", "a gzip archive"),
    (b"PAR1", "a Parquet table"),
    (b"\x89HDF", "an HDF5 file"),
    (b"SQLite format 3", "an SQLite database"),
    (b"\x89MCAP", "an MCAP bag"),
];

/// Returns the text of a file.
///
/// # Errors
///
/// The kind of file by its first bytes, if it is no text.
fn text_of(bytes: Vec<u8>) -> IoResult<String> {
    String::from_utf8(bytes).map_err(|error| {
        let mut known = KINDS.iter();
        let found = known.find(|(begin, _)| error.as_bytes().starts_with(begin));
        let kind = found.map_or("a binary file, or text that is not UTF-8", |(_, kind)| kind);
        let message = format!("it is {kind}, and a text file is needed");
        IoError::new(ErrorKind::InvalidData, message)
    })
}
