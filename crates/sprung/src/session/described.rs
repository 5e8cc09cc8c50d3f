//! Errors in parts: code, place, text and remedy.

use super::error::{ErrorKind, SessionError};
use sprung_log::LogError;
use sprung_method::estimate::IdentifyError;
use sprung_method::prepare::PrepareError;
use sprung_method::regression::PassError;
use sprung_method::validate::ValidateError;
use sprung_robot::DescriptionError;

/// An error in parts, for programs that show or handle them separately.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Described {
    /// Code of the first finding, or the kind of the error: `usage`, `log`, `file` or `stopped`.
    pub code: String,
    /// File, and line, sample or column, if the error has one place.
    pub place: Option<String>,
    /// The fault.
    pub text: String,
    /// Remedy, if the text does not contain it.
    pub remedy: Option<String>,
}

impl ErrorKind {
    /// Returns its name, for scripts.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Usage => "usage",
            Self::Log => "log",
            Self::File => "file",
            Self::Stopped => "stopped",
        }
    }
}

impl SessionError {
    /// Returns the error in parts.
    #[must_use]
    pub fn described(&self) -> Described {
        if let Some(first) = self.findings().first() {
            return Described {
                code: first.code.clone(),
                place: first.evidence.as_ref().map(|evidence| {
                    let column = evidence
                        .column
                        .iter()
                        .map(|name| format!(", column \"{name}\""));
                    format!("{}{}", evidence.file, column.collect::<String>())
                }),
                text: first.text.clone(),
                remedy: Some(first.remedy.clone()),
            };
        }
        let message = self.to_string();
        let (text, remedy) = split_remedy(&message);
        Described {
            code: self.refusal().unwrap_or(self.kind().word()).to_owned(),
            place: self.place(),
            text: text.to_owned(),
            remedy: remedy.map(str::to_owned),
        }
    }

    /// Returns the code of a combination that does not work.
    fn refusal(&self) -> Option<&'static str> {
        match self {
            Self::NotSupported(refusal) => Some(refusal.code()),
            Self::Description(error) => error.code(),
            _ => None,
        }
    }

    /// Returns the error of reading a log, if it is one.
    fn log_error(&self) -> Option<&LogError> {
        match self {
            Self::Log(error)
            | Self::Check(PrepareError::Log(error))
            | Self::Identify(
                IdentifyError::Pass(PassError::Log(error))
                | IdentifyError::Prepare(PrepareError::Log(error)),
            )
            | Self::Validate(ValidateError::Pass(PassError::Log(error))) => Some(error),
            _ => None,
        }
    }

    fn place(&self) -> Option<String> {
        let log = match self {
            Self::Description(DescriptionError::Line { file, line, .. }) => {
                return Some(format!("line {line} of {file}"));
            }
            Self::Description(DescriptionError::File { file, .. })
            | Self::Robot { file, .. }
            | Self::Unreadable { file, .. } => return Some(file.clone()),
            _ => self.log_error()?,
        };
        match log {
            LogError::NotANumber {
                file,
                place,
                column,
                ..
            }
            | LogError::NotFinite {
                file,
                place,
                column,
                ..
            } => Some(format!("{place} of {file}, column \"{column}\"")),
            LogError::Width { file, place, .. } => Some(format!("{place} of {file}")),
            LogError::Io { file, .. } | LogError::TooShort { file, .. } => Some(file.clone()),
            _ => None,
        }
    }
}

/// Splits a message into the fault and the remedy. Messages give the cause first and the remedy after the first
/// semicolon.
#[must_use]
pub fn split_remedy(message: &str) -> (&str, Option<&str>) {
    match message.split_once("; ") {
        Some((text, remedy)) => (text, Some(remedy)),
        None => (message, None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::Session;
    use sprung_base::demo;
    use sprung_log::Input;
    use std::path::Path;

    #[test]
    fn errors_have_parts() {
        let files = |_: &Path| -> std::io::Result<Box<dyn Input>> {
            Err(std::io::ErrorKind::NotFound.into())
        };
        let text = demo::EXPERIMENT.replace("format = 1", "format = 1\nnonsense = 2");
        let error = Session::read("own.toml", &text, &[], files).unwrap_err();
        let described = error.described();
        assert_eq!(described.code, "usage");
        assert!(described.place.unwrap().ends_with(" of own.toml"));
        assert!(described.text.contains("nonsense"));
        assert_eq!(split_remedy("a; b; c"), ("a", Some("b; c")));
        assert_eq!(split_remedy("a"), ("a", None));
    }
}
