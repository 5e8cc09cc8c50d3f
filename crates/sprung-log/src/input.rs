//! Sources of bytes, and detection of a file's format by its first bytes.

use std::fs::File;
use std::io::{Chain, Cursor, Read, Result as IoResult, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::time::Duration;

use sprung_base::stopwatch::Stopwatch;

use super::error::LogError;

/// A source of a log's bytes: a file, or bytes in memory.
pub trait Input: Read + Seek + Send {
    /// Returns the path of the file, or `None` if it is not known.
    ///
    /// HDF5 and `SQLite` need the path, because they open files themselves. `SQLite` copies an input without a path.
    fn path(&self) -> Option<&Path> {
        None
    }

    /// Returns the time without growth after which a file that is being written ends, s; `None` for a complete file.
    ///
    /// `SQLite` needs it. Other formats wait where the bytes are read.
    fn patience_s(&self) -> Option<f64> {
        None
    }
}

impl Input for File {}

impl<T: AsRef<[u8]> + Send> Input for Cursor<T> {}

/// Time between two looks at a file that is being written.
const PAUSE: Duration = Duration::from_millis(50);

/// Looks at a file that is being written until there is something new; returns `None` if nothing comes.
///
/// - `patience_s`: time without anything new after which the file ends, s; zero for one look.
///
/// # Errors
///
/// Those of `look`.
pub fn awaited<T, E>(
    patience_s: f64,
    mut look: impl FnMut() -> Result<Option<T>, E>,
) -> Result<Option<T>, E> {
    let waits = Stopwatch::start();
    loop {
        let new = look()?;
        if new.is_some() || waits.seconds() >= patience_s {
            return Ok(new);
        }
        std::thread::sleep(PAUSE);
    }
}

/// A file together with its path.
#[derive(Debug)]
pub struct LogFile {
    file: File,
    path: PathBuf,
    patience_s: Option<f64>,
}

impl LogFile {
    /// Returns a file with its path.
    #[must_use]
    pub fn new(file: File, path: &Path) -> Self {
        Self {
            file,
            path: path.to_owned(),
            patience_s: None,
        }
    }

    /// Returns the file as one that is being written.
    ///
    /// - `patience_s`: time without growth after which it ends, s.
    #[must_use]
    pub fn growing(self, patience_s: f64) -> Self {
        Self {
            patience_s: Some(patience_s),
            ..self
        }
    }
}

impl Input for LogFile {
    fn path(&self) -> Option<&Path> {
        Some(&self.path)
    }

    fn patience_s(&self) -> Option<f64> {
        self.patience_s
    }
}

impl Read for LogFile {
    fn read(&mut self, bytes: &mut [u8]) -> IoResult<usize> {
        self.file.read(bytes)
    }
}

impl Seek for LogFile {
    fn seek(&mut self, to: SeekFrom) -> IoResult<u64> {
        self.file.seek(to)
    }
}

/// Number of bytes that are read to recognise a file.
const PEEKED_BYTES: usize = 1 << 16;

/// Format or compression of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Text,
    Json,
    Gzip,
    Zstd,
    Npy,
    Zip,
    Mat5,
    Mat73,
    Parquet,
    ArrowFile,
    ArrowStream,
    Mcap,
    Sqlite,
    Empty,
    /// A recognised format that sprung does not read: its name and the remedy.
    Other(&'static str),
}

impl Kind {
    /// Returns the name of the format for messages.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Text => "text",
            Self::Json => "JSON",
            Self::Gzip => "a gzip file",
            Self::Zstd => "a zstd file",
            Self::Npy => "an .npy file",
            Self::Zip => "a zip archive",
            Self::Mat5 => "a MATLAB file",
            Self::Mat73 => "a MATLAB file of version 7.3 (HDF5)",
            Self::Parquet => "a Parquet file",
            Self::ArrowFile | Self::ArrowStream => "an Arrow file",
            Self::Mcap => "an MCAP file",
            Self::Sqlite => "an SQLite database",
            Self::Empty => "an empty file",
            Self::Other(_) => "a file of another kind",
        }
    }
}

const PICKLE: Kind = Kind::Other(
    "is a pickle of Python, which can run code and is not read; write its arrays: d = pandas.read_pickle(\"run.pkl\"); \
     numpy.savez(\"run.npz\", **d), or d.to_csv(\"run.csv\", index=False) for a data frame",
);

/// First bytes of each recognised format.
const MAGIC: [(&[u8], Kind); 25] = [
    (b"\x1f\x8b", Kind::Gzip),
    (b"\x28\xb5\x2f\xfd", Kind::Zstd),
    (b"\x93NUMPY", Kind::Npy),
    (b"PK\x03\x04", Kind::Zip),
    (b"PK\x05\x06", Kind::Zip),
    (b"MATLAB 5.0 MAT-file", Kind::Mat5),
    (b"MATLAB 7.3 MAT-file", Kind::Mat73),
    (b"PAR1", Kind::Parquet),
    (
        b"PARE",
        Kind::Other("is encrypted Parquet; write it without encryption"),
    ),
    (b"ARROW1", Kind::ArrowFile),
    (b"\xff\xff\xff\xff", Kind::ArrowStream),
    (
        b"FEA1",
        Kind::Other("is Feather of version 1; write it again with version 2, which is Arrow IPC"),
    ),
    (b"\x89MCAP0\r\n", Kind::Mcap),
    (b"SQLite format 3\0", Kind::Sqlite),
    (
        b"\x89HDF\r\n\x1a\n",
        Kind::Other(
            "is HDF5, which is not read; write the arrays as .npz, .mat version 7 or Parquet",
        ),
    ),
    (
        b"#ROSBAG V2.0",
        Kind::Other(
            "is a bag of ROS 1; convert it and give the folder run: pip install rosbags; rosbags-convert --src run.bag \
             --dst run",
        ),
    ),
    (
        b"BZh",
        Kind::Other("is compressed with bzip2; decompress it"),
    ),
    (
        b"\xfd7zXZ\0",
        Kind::Other("is compressed with xz; decompress it"),
    ),
    (b"\x80\x02", PICKLE),
    (b"\x80\x03", PICKLE),
    (b"\x80\x04", PICKLE),
    (b"\x80\x05", PICKLE),
    (
        b"\xd0\xcf\x11\xe0",
        Kind::Other("is a spreadsheet in the old format .xls; save it as CSV"),
    ),
    (b"\xff\xfe", Kind::Other("is UTF-16 text; save it as UTF-8")),
    (b"\xfe\xff", Kind::Other("is UTF-16 text; save it as UTF-8")),
];

/// Returns the format of a file with these first bytes.
pub(super) fn kind_of(start: &[u8]) -> Kind {
    if start.is_empty() {
        return Kind::Empty;
    }
    if let Some((_, kind)) = MAGIC.iter().find(|(magic, _)| start.starts_with(magic)) {
        return *kind;
    }
    // The text of a MATLAB header is free, but its last four bytes are fixed.
    match start.get(124..128) {
        Some(b"\x00\x02IM" | b"\x02\x00MI") => return Kind::Mat73,
        Some([_, _, b'I', b'M'] | [_, _, b'M', b'I']) => return Kind::Mat5,
        _ => {}
    }
    if start.contains(&0) && !is_text_before_nul(start) {
        return Kind::Other(
            "is a binary file in an unknown format; sprung reads CSV, Parquet, Arrow, .npy, .npz, \
             .mat, MCAP and ROS 2 .db3",
        );
    }
    if is_json(start) {
        return Kind::Json;
    }
    Kind::Text
}

/// Returns whether a text begins an object with keys, or a list of objects or lists.
fn is_json(start: &[u8]) -> bool {
    let inside = |open: &[u8]| {
        start
            .trim_ascii_start()
            .strip_prefix(open)
            .map(<[u8]>::trim_ascii_start)
    };
    inside(b"{").is_some_and(|rest| rest.starts_with(b"\""))
        || inside(b"[").is_some_and(|rest| rest.starts_with(b"{") || rest.starts_with(b"["))
}

/// Returns whether a text stands before NUL bytes, which a file system that lost power leaves at the end.
fn is_text_before_nul(start: &[u8]) -> bool {
    let written = start
        .iter()
        .rposition(|&byte| byte != 0)
        .map_or(0, |last| last + 1);
    let is_of_text = |byte: &u8| !byte.is_ascii_control() || matches!(byte, b'\t' | b'\n' | b'\r');
    start[..written].contains(&b'\n') && start[..written].iter().all(is_of_text)
}

/// Returns the name of the format of a file with these first bytes; `None` for text and for an empty file.
#[must_use]
pub fn format_of(start: &[u8]) -> Option<&'static str> {
    match kind_of(start) {
        Kind::Text | Kind::Json | Kind::Empty => None,
        Kind::Other(_) => Some("a binary file"),
        kind => Some(kind.name()),
    }
}

/// Returns whether a file with these first bytes can be read by its path while it is written.
#[must_use]
pub fn is_shared(start: &[u8]) -> bool {
    kind_of(start) == Kind::Sqlite
}

/// A reader whose first bytes were read and put in front again.
pub(super) type Peeked<R> = Chain<Cursor<Vec<u8>>, R>;

/// The beginning of a reader.
pub(super) struct Beginning<R> {
    /// The first bytes.
    pub(super) start: Vec<u8>,
    /// Whether the reader ended with them.
    pub(super) is_whole: bool,
    /// A reader that begins with them again.
    pub(super) again: Peeked<R>,
}

/// Reads the first bytes of a reader.
///
/// - `what`: name of this part of the file for the error message.
pub(super) fn peek<R: Read>(file: &str, what: &str, mut read: R) -> Result<Beginning<R>, LogError> {
    let mut start = Vec::new();
    read.by_ref()
        .take(PEEKED_BYTES as u64)
        .read_to_end(&mut start)
        .map_err(|error| LogError::read(file, what, error))?;
    let is_whole = start.len() < PEEKED_BYTES;
    let again = Cursor::new(start.clone()).chain(read);
    Ok(Beginning {
        start,
        is_whole,
        again,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_recognised_by_first_bytes() {
        assert_eq!(kind_of(b""), Kind::Empty);
        assert_eq!(kind_of(b"t,q\n0,1\n"), Kind::Text);
        assert_eq!(kind_of(b"\x93NUMPY\x01\x00"), Kind::Npy);
        assert_eq!(kind_of(b"PAR1\x15"), Kind::Parquet);
        for binary in [&b"\x7fELF\0\0"[..], b"\0\0", b"t,q\n\0\x01", b"text\0\0"] {
            assert!(matches!(kind_of(binary), Kind::Other(_)));
        }
        assert_eq!(kind_of(b"t,q\n0,1\n\0\0"), Kind::Text);
        let mut mat = vec![b' '; 200];
        mat[126..128].copy_from_slice(b"IM");
        assert_eq!(kind_of(&mat), Kind::Mat5);
        mat[124..126].copy_from_slice(&[0, 2]);
        assert_eq!(kind_of(&mat), Kind::Mat73);
    }
}
