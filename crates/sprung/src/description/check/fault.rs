//! What is wrong with a description, and where.

/// A fault and the path of keys to it.
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
