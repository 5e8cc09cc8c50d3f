//! How the program ends.

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
