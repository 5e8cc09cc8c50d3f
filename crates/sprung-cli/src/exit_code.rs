//! How the program ends.

use sprung::session::{ErrorKind, SessionError, Usability};

/// Exit codes; documented in the README and in `--help`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ExitCode {
    /// Done.
    Done = 0,
    /// Done, but the result is unusable, and says so.
    Unusable = 1,
    /// The command line or the experiment file is wrong.
    Usage = 2,
    /// A log is wrong.
    Log = 3,
    /// A file cannot be read or written.
    File = 4,
}

impl From<ExitCode> for std::process::ExitCode {
    fn from(code: ExitCode) -> Self {
        Self::from(code as u8)
    }
}

impl From<Usability> for ExitCode {
    fn from(usability: Usability) -> Self {
        match usability {
            Usability::Usable => Self::Done,
            Usability::Unusable => Self::Unusable,
            Usability::WrongLog => Self::Log,
        }
    }
}

impl From<ErrorKind> for ExitCode {
    fn from(kind: ErrorKind) -> Self {
        match kind {
            // The terminal stops no run: Ctrl-C ends the program.
            ErrorKind::Usage | ErrorKind::Stopped => Self::Usage,
            ErrorKind::Log => Self::Log,
            ErrorKind::File => Self::File,
        }
    }
}

/// Why a command did not finish.
#[derive(Debug)]
pub(crate) struct Failure {
    pub(crate) code: ExitCode,
    pub(crate) message: String,
}

impl Failure {
    pub(crate) fn new(code: ExitCode, message: impl std::fmt::Display) -> Self {
        Self {
            code,
            message: format!("{message}"),
        }
    }
}

impl From<SessionError> for Failure {
    fn from(error: SessionError) -> Self {
        Self::new(error.kind().into(), error)
    }
}
