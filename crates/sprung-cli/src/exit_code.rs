//! Exit codes of the program.

use serde::Serialize;
use sprung::finding::Finding;
use sprung::session::{ErrorKind, SessionError, Usability, split_remedy};

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

impl ExitCode {
    /// Returns the name of an error with this code, for scripts.
    fn name(self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::Unusable => "unusable",
            Self::Usage => "usage",
            Self::Log => "log",
            Self::File => "file",
        }
    }
}

/// Error that ends a command.
#[derive(Debug)]
pub(crate) struct Failure {
    pub(crate) code: ExitCode,
    pub(crate) message: String,
    // Findings for which a log was refused.
    findings: Vec<Finding>,
}

/// An error for scripts.
#[derive(Debug, Serialize)]
pub(crate) struct Described<'a> {
    /// Code of the first finding, or the kind of the error: `usage`, `log` or `file`.
    code: &'a str,
    exit_code: u8,
    text: &'a str,
    /// Remedy; absent if the text does not contain it.
    remedy: Option<&'a str>,
    #[serde(skip_serializing_if = "<[Finding]>::is_empty")]
    findings: &'a [Finding],
}

impl Failure {
    /// Returns the error of a wrong command line or experiment file.
    pub(crate) fn usage(message: impl std::fmt::Display) -> Self {
        Self::new(ExitCode::Usage, message)
    }

    /// Returns the error of a wrong log.
    pub(crate) fn log(message: impl std::fmt::Display) -> Self {
        Self::new(ExitCode::Log, message)
    }

    /// Returns the error of a file that cannot be read or written.
    pub(crate) fn file(message: impl std::fmt::Display) -> Self {
        Self::new(ExitCode::File, message)
    }

    fn new(code: ExitCode, message: impl std::fmt::Display) -> Self {
        Self {
            code,
            message: format!("{message}"),
            findings: Vec::new(),
        }
    }

    /// Returns this error with the findings for which a log was refused.
    pub(crate) fn with_findings(self, findings: Vec<Finding>) -> Self {
        Self { findings, ..self }
    }

    /// Returns the error in parts.
    pub(crate) fn described(&self) -> Described<'_> {
        let exit_code = self.code as u8;
        if let Some(first) = self.findings.first() {
            return Described {
                code: &first.code,
                exit_code,
                text: &first.text,
                remedy: Some(&first.remedy),
                findings: &self.findings,
            };
        }
        let (text, remedy) = split_remedy(&self.message);
        Described {
            code: self.code.name(),
            exit_code,
            text,
            remedy,
            findings: &[],
        }
    }
}

impl From<SessionError> for Failure {
    fn from(error: SessionError) -> Self {
        Self {
            findings: error.findings().to_vec(),
            ..Self::new(error.kind().into(), error)
        }
    }
}
