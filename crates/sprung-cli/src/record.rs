//! Writes logs of a digital twin to files.

use std::path::PathBuf;

use sprung::session::{Recording, SessionError};
use sprung::simulate::RecordError;

use crate::exit_code::Failure;
use crate::output::Output;
use crate::terminal::Terminal;

/// Writes the log of a twin and returns its future path.
pub(crate) fn write_log(
    twin: &Recording<'_>,
    output: &mut Output<'_>,
    terminal: Terminal,
) -> Result<PathBuf, Failure> {
    let mut failure = None;
    let written = terminal.follow("simulating", |progress| {
        output.write(twin.name(), |write| match twin.write(write, progress) {
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
