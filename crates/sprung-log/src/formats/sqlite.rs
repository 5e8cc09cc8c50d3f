//! `SQLite` databases, opened for reading.
//!
//! `SQLite` opens the file by its path. An input without a path is copied into memory.

use std::ffi::OsString;
use std::fmt::Write;
use std::io::{Cursor, Error as IoError, ErrorKind, Read, Result as IoResult, SeekFrom};
use std::path::{Path, PathBuf};
use std::time::Duration;

use rusqlite::config::DbConfig;
use rusqlite::{Connection, Error, ErrorCode, MAIN_DB, OpenFlags};

use crate::error::LogError;
use crate::input::Input;

/// Name of the damaged part of the file in errors.
const DATABASE: &str = "its database";

/// Instructions of `SQLite`'s virtual machine between two looks at their count.
const COUNTED_INSTRUCTIONS: u16 = 10_000;

/// Instructions for each byte of a file, at most. A row of a bag takes about 20 of them and has more than 20
/// bytes; a damaged file may lead to the same page again and again.
const MAX_INSTRUCTIONS_PER_BYTE: u64 = 8;

/// Instructions for a file of any length, such as those that read its tables' names.
const MAX_OTHER_INSTRUCTIONS: u64 = 1_000_000;

/// Longest time for which a recorder may lock its database.
const LONGEST_LOCK: Duration = Duration::from_secs(5);

/// Opens a database for reading.
pub(super) fn open(file: &str, input: Box<dyn Input>) -> Result<Connection, LogError> {
    let path = input.path().map(Path::to_owned);
    let beside = path.as_deref().and_then(file_beside);
    let (base, length) = match (&path, &beside) {
        (Some(path), _) if input.patience_s().is_some() => shared(path),
        (Some(path), Some(_)) => beside_another(path, input),
        (Some(path), None) => alone(path, input),
        (None, _) => in_memory(input),
    }
    .map_err(|error| LogError::read(file, DATABASE, error))?;
    base.and_then(|mut base| {
        limit(&mut base, length)?;
        Ok(base)
    })
    .map_err(|error| match (&error, &beside) {
        (Error::SqliteFailure(failure, _), Some(beside)) if cannot_finish(failure.code) => {
            not_closed(file, beside)
        }
        _ => failed(file, &error),
    })
}

/// A database or the reason why `SQLite` does not open it, and its length in bytes.
type Opened = IoResult<(Result<Connection, Error>, u64)>;

/// Flags of a database that is opened by its path.
const BY_PATH: OpenFlags = OpenFlags::SQLITE_OPEN_READ_ONLY.union(OpenFlags::SQLITE_OPEN_NO_MUTEX);

/// Opens a file that its recorder is writing, with locks.
fn shared(path: &Path) -> Opened {
    let base = Connection::open_with_flags(path, BY_PATH).and_then(|base| {
        base.busy_timeout(LONGEST_LOCK)?;
        Ok(base)
    });
    Ok((base, path.metadata()?.len()))
}

/// Opens a file whose latest changes are in another file: its recorder was killed or still runs.
fn beside_another(path: &Path, mut input: Box<dyn Input>) -> Opened {
    // A recorder that runs shares its memory in this file, and SQLite then has to lock.
    if named_beside(path, "-shm").exists() || !cfg!(unix) {
        return shared(path);
    }
    let length = input.seek(SeekFrom::End(0))?;
    // Nobody else has the database open. With exclusive access SQLite keeps its index of the changes in memory, so
    // it writes no file beside the bag.
    let alone =
        Connection::open_with_flags_and_vfs(path, BY_PATH, WITHOUT_LOCKS).and_then(|base| {
            base.set_db_config(DbConfig::SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, true)?;
            base.pragma_update(None, "locking_mode", "EXCLUSIVE")?;
            Ok(base)
        });
    Ok((alone, length))
}

/// Access of `SQLite` to files without locks, which an exclusive lock of a file for reading needs.
const WITHOUT_LOCKS: &str = "unix-none";

/// Opens a file that is complete; `SQLite` then takes no lock and writes no file beside it.
fn alone(path: &Path, mut input: Box<dyn Input>) -> Opened {
    let (_, length) = header(&mut *input)?;
    // The characters ?, # and % have a meaning in an address.
    let mut address = String::from(if cfg!(windows) { "file:///" } else { "file:" });
    for &byte in std::path::absolute(path)?.as_os_str().as_encoded_bytes() {
        let plain = byte.is_ascii_alphanumeric() || b"/\\:.-_".contains(&byte);
        let _ = match byte {
            b'\\' if cfg!(windows) => address.write_char('/'),
            _ if plain => address.write_char(char::from(byte)),
            _ => write!(address, "%{byte:02X}"),
        };
    }
    address.push_str("?immutable=1");
    let flags = BY_PATH | OpenFlags::SQLITE_OPEN_URI;
    Ok((Connection::open_with_flags(address, flags), length))
}

fn in_memory(mut input: Box<dyn Input>) -> Opened {
    let (mut header, length) = header(&mut *input)?;
    // SQLite opens no copy of a database whose header declares a write-ahead log.
    for version in &mut header[18..20] {
        *version = 1.min(*version);
    }
    let size = usize::try_from(length).map_err(IoError::other)?;
    let copied = Connection::open_in_memory().and_then(|mut base| {
        base.deserialize_read_exact(MAIN_DB, Cursor::new(header).chain(input), size, true)?;
        Ok(base)
    });
    Ok((copied, length))
}

/// Returns the header of a database, and its length in bytes; the input is then after the header.
fn header(input: &mut dyn Input) -> IoResult<([u8; 100], u64)> {
    let length = input.seek(SeekFrom::End(0))?;
    input.rewind()?;
    let mut header = [0; 100];
    input.read_exact(&mut header)?;
    let word = |at: usize| u64::from(u32::from_be_bytes([0, 1, 2, 3].map(|k| header[at + k])));
    let page_bytes = match u64::from(u16::from_be_bytes([header[16], header[17]])) {
        1 => 65_536,
        bytes => bytes,
    };
    // Old versions of SQLite did not keep the number of pages; both counters of changes then differ.
    if word(24) == word(92) && word(28) * page_bytes > length {
        return Err(ErrorKind::UnexpectedEof.into());
    }
    Ok((header, length))
}

/// Makes a database refuse functions with side effects, and endless searches.
///
/// - `length`: bytes that may be read from now on.
pub(super) fn limit(base: &mut Connection, length: u64) -> Result<(), Error> {
    base.set_db_config(DbConfig::SQLITE_DBCONFIG_TRUSTED_SCHEMA, false)?;
    let instructions = MAX_OTHER_INSTRUCTIONS + length.saturating_mul(MAX_INSTRUCTIONS_PER_BYTE);
    let mut left = instructions / u64::from(COUNTED_INSTRUCTIONS);
    let count = move || {
        left = left.saturating_sub(1);
        left == 0
    };
    base.progress_handler(COUNTED_INSTRUCTIONS.into(), Some(count))?;
    // SQLite does not read before the first query.
    base.query_row("PRAGMA schema_version", [], |_| Ok(()))
}

/// Returns the write-ahead log or rollback journal of a database, if it is not empty.
fn file_beside(path: &Path) -> Option<PathBuf> {
    ["-wal", "-journal"].into_iter().find_map(|end| {
        let beside = named_beside(path, end);
        let holds_changes = beside.metadata().is_ok_and(|data| data.len() > 0);
        holds_changes.then_some(beside)
    })
}

/// Returns the path of a file whose name continues that of another.
fn named_beside(path: &Path, end: &str) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(end);
    PathBuf::from(name)
}

/// Returns whether an error means that `SQLite` would have to write.
fn cannot_finish(code: ErrorCode) -> bool {
    matches!(
        code,
        ErrorCode::CannotOpen | ErrorCode::ReadOnly | ErrorCode::PermissionDenied
    )
}

fn not_closed(file: &str, beside: &Path) -> LogError {
    let name = beside.file_name().unwrap_or_default().display();
    LogError::format(
        file,
        format!(
            " was not closed by its recorder: its latest messages stand in {name}; copy both files to a folder \
             where you may write, and complete the bag there with: sqlite3 FILE .tables"
        ),
    )
}

/// Returns an error of `SQLite` as one of the file.
pub(super) fn failed(file: &str, error: &Error) -> LogError {
    let damaged =
        |text: String| LogError::read(file, DATABASE, IoError::new(ErrorKind::InvalidData, text));
    match error {
        Error::SqliteFailure(failure, text) => match failure.code {
            ErrorCode::OperationInterrupted => {
                damaged("its pages lead to each other without end".to_owned())
            }
            ErrorCode::DatabaseCorrupt | ErrorCode::NotADatabase | ErrorCode::TooBig => {
                damaged(text.clone().unwrap_or_else(|| failure.to_string()))
            }
            _ => LogError::Io {
                file: file.to_owned(),
                source: IoError::other(error.to_string()),
            },
        },
        Error::SqlInputError { .. } | Error::InvalidColumnType(..) => {
            LogError::format(file, " has tables of another shape than a bag of ROS 2")
        }
        other => damaged(other.to_string()),
    }
}
