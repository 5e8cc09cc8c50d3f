//! Writes logs of a digital twin to files.

use std::io::Write;
use std::path::{Path, PathBuf};

use sprung::progress::Listener;
use sprung::session::SessionError;
use sprung::simulate::RecordError;

use crate::exit_code::Failure;
use crate::output::Output;
use crate::terminal::Terminal;

/// Writes the log of a twin and returns its future path.
///
/// - `simulate`: simulates and writes; returns the number of samples.
pub(crate) fn write_log(
    name: impl AsRef<Path>,
    output: &mut Output<'_>,
    terminal: Terminal,
    simulate: impl FnOnce(&mut dyn Write, &mut dyn Listener) -> Result<u64, SessionError>,
) -> Result<PathBuf, Failure> {
    let mut failure = None;
    let written = terminal.follow("simulating", |progress| {
        output.write(name, |write| match simulate(write, progress) {
            Ok(_) => Ok(()),
            Err(SessionError::Record(RecordError::Write(error))) => Err(error),
            Err(error) => {
                failure = Some(error);
                Err(std::io::Error::other("the twin did not run"))
            }
        })
    });
    match failure {
        Some(error) => Err(error.into()),
        None => written,
    }
}

/// Returns the folder for logs: that of `--out`, or else the folder in which the experiment names the first log. There, no
/// file is overwritten, because it may be a measured log.
///
/// - `files`: paths in the experiment, with the names of the new files; `otherwise`: another remedy than `--out`.
pub(crate) fn folder_of_logs<'a>(
    files: impl Iterator<Item = (&'a Path, &'a Path)>,
    out: Option<&Path>,
    otherwise: &str,
) -> Result<PathBuf, Failure> {
    if let Some(out) = out {
        return Ok(out.to_owned());
    }
    let mut first = None;
    for (path, name) in files {
        let file = path.with_file_name(name);
        if file.symlink_metadata().is_ok() {
            return Err(Failure::usage(format!(
                "{} exists and is not overwritten; give another folder with --out{otherwise}",
                file.display()
            )));
        }
        first = first.or(path.parent());
    }
    Ok(first.map_or_else(PathBuf::new, Path::to_owned))
}
