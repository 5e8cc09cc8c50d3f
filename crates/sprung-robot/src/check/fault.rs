//! A fault of a description, and its place.

use crate::capabilities::NotSupported;

/// A fault and the path of keys to its place.
#[derive(Debug)]
pub(crate) struct Fault {
    pub(crate) path: Vec<String>,
    pub(crate) message: String,
    /// Code of a refusal of the table of what works with what.
    pub(crate) code: Option<&'static str>,
}

pub(crate) fn fault(path: &[&str], message: impl Into<String>) -> Fault {
    Fault {
        path: path.iter().map(|&part| part.to_owned()).collect(),
        message: message.into(),
        code: None,
    }
}

/// Returns the fault of a combination that does not work.
pub(super) fn refused(path: &[&str], refusal: &NotSupported) -> Fault {
    Fault {
        code: Some(refusal.code()),
        ..fault(path, refusal.to_string())
    }
}
