//! Recognises other inputs in place of an experiment file.

use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use super::bag::of_bag;
use super::error::SessionError;
use super::files::open_file;
use sprung_log::format_of;

/// Name of the experiment file in its folder.
pub const EXPERIMENT_FILE: &str = "experiment.toml";

/// Number of bytes that are read to recognise a file.
const PEEKED_BYTES: u64 = 1 << 16;

/// File extensions of logs.
const LOG_EXTENSIONS: [&str; 14] = [
    "csv", "tsv", "gz", "zst", "parquet", "arrow", "feather", "npy", "npz", "mat", "mcap", "db3",
    "bag", "h5",
];

const NAMES_IT: &str = "give the experiment file that names it in [log], or the folder of that file; \
    sprung new FOLDER --log FILE writes an experiment file";

/// Returns the experiment file that a path means: the file, or `experiment.toml` in the folder.
///
/// # Errors
///
/// [`SessionError`] if the file does not exist, or is no experiment file.
pub(super) fn experiment_file(path: &Path) -> Result<PathBuf, SessionError> {
    let file = if path.is_dir() {
        in_folder(path)?
    } else {
        path.to_owned()
    };
    let not = |(what, remedy): (&'static str, String)| SessionError::NotAnExperiment {
        file: file.display().to_string(),
        what,
        remedy,
    };
    if let Some(found) = by_name(&file) {
        return Err(not(found));
    }
    let start = match start_of(&file) {
        Ok(start) => start,
        Err(error) if error.kind() == ErrorKind::NotFound => {
            return Err(SessionError::NoExperiment {
                file: file.display().to_string(),
                remedy: "check the path; sprung new FOLDER writes an experiment file to start from"
                    .to_owned(),
            });
        }
        Err(source) => {
            return Err(SessionError::Unreadable {
                file: file.display().to_string(),
                source,
            });
        }
    };
    match by_content(&file, &start) {
        Some(found) => Err(not(found)),
        None => Ok(file),
    }
}

/// Returns `experiment.toml` in a folder.
fn in_folder(folder: &Path) -> Result<PathBuf, SessionError> {
    let file = folder.join(EXPERIMENT_FILE);
    if file.symlink_metadata().is_ok() {
        return Ok(file);
    }
    if of_bag(folder).is_ok() {
        return Err(SessionError::NotAnExperiment {
            file: folder.display().to_string(),
            what: "a folder with a bag, which is a log",
            remedy: NAMES_IT.to_owned(),
        });
    }
    let mut others: Vec<String> = (std::fs::read_dir(folder).into_iter().flatten())
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "toml")
        })
        .map(|path| path.display().to_string())
        .collect();
    others.sort();
    Err(SessionError::NoExperiment {
        file: file.display().to_string(),
        remedy: if others.is_empty() {
            format!("sprung new {} writes one to start from", folder.display())
        } else {
            format!("give one of the other files by name: {}", others.join(", "))
        },
    })
}

fn start_of(file: &Path) -> std::io::Result<Vec<u8>> {
    let mut start = Vec::new();
    open_file(file)?
        .take(PEEKED_BYTES)
        .read_to_end(&mut start)?;
    Ok(start)
}

/// Recognises logs and robots by the extension, also where the file does not exist.
fn by_name(file: &Path) -> Option<(&'static str, String)> {
    let extension = file.extension()?.to_str()?.to_ascii_lowercase();
    let shown = file.display();
    match &*extension {
        "urdf" => Some((
            "a URDF",
            format!("sprung new FOLDER --urdf {shown} writes an experiment file for this robot"),
        )),
        "xacro" => Some((
            "a xacro file",
            format!(
                "expand it with xacro {shown} > robot.urdf; then sprung new FOLDER --urdf robot.urdf writes an \
                 experiment file"
            ),
        )),
        log if LOG_EXTENSIONS.contains(&log) => Some(("a log", NAMES_IT.to_owned())),
        _ => None,
    }
}

/// Recognises a file by its first bytes.
fn by_content(file: &Path, start: &[u8]) -> Option<(&'static str, String)> {
    let encoding = "save it as UTF-8";
    if start.starts_with(b"\xff\xfe") || start.starts_with(b"\xfe\xff") {
        return Some(("UTF-16 text", encoding.to_owned()));
    }
    if let Some(format) = format_of(start) {
        return Some((format, NAMES_IT.to_owned()));
    }
    // The last character may be cut off.
    if std::str::from_utf8(start).is_err_and(|error| error.error_len().is_some()) {
        return Some(("text in another encoding than UTF-8", encoding.to_owned()));
    }
    let text = String::from_utf8_lossy(start);
    let text = text.trim_start_matches('\u{feff}').trim_start();
    let results = || "give the experiment file that these results come from".to_owned();
    if text.starts_with('<') {
        return Some(if text.contains("<robot") {
            let shown = file.display();
            (
                "a URDF",
                format!(
                    "sprung new FOLDER --urdf {shown} writes an experiment file for this robot"
                ),
            )
        } else if text.contains("<html") {
            ("a report", results())
        } else {
            (
                "XML of another program",
                "convert the robot to URDF; sprung new FOLDER --urdf FILE writes an experiment file".to_owned(),
            )
        });
    }
    if text.starts_with('{') {
        return Some(("JSON", results()));
    }
    is_table(text).then(|| ("a table of numbers", NAMES_IT.to_owned()))
}

/// Returns whether a text contains rows of numbers and no TOML.
fn is_table(text: &str) -> bool {
    let is_row = |line: &str| {
        let cells: Vec<&str> = line
            .split(|c: char| ",;\t ".contains(c))
            .filter(|cell| !cell.is_empty())
            .collect();
        cells.len() > 1 && cells.iter().all(|cell| cell.parse::<f64>().is_ok())
    };
    !text.contains('=') && text.lines().any(is_row)
}
