//! A fault of a description, and its place.

/// A fault and the path of keys to its place.
#[derive(Debug)]
pub(in crate::description) struct Fault {
    pub(in crate::description) path: Vec<String>,
    pub(in crate::description) message: String,
}

pub(in crate::description) fn fault(path: &[&str], message: impl Into<String>) -> Fault {
    Fault {
        path: path.iter().map(|&part| part.to_owned()).collect(),
        message: message.into(),
    }
}
