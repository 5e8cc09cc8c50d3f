//! Exit codes of the program.

use sprung::session::{ErrorKind, SessionError, Usability};

/// Exit codes, which `docs/reference/commands.md` and `--help` document.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ExitCode {
    /// The command succeeded.
    Done = 0,
    /// The command succeeded, but the result is unusable.
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
            // The terminal never stops a run, because Ctrl-C ends the program.
            ErrorKind::Usage | ErrorKind::Stopped => Self::Usage,
            ErrorKind::Log => Self::Log,
            ErrorKind::File => Self::File,
        }
    }
}

/// Error that ends a command.
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
