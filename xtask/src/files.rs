//! The files of the project: by their endings, read and written.

use std::fs;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;

use crate::steps::said;

/// Folders without files of the project.
const FOREIGN: [&str; 4] = ["target", ".git", "fuzz", "node_modules"];

/// Returns all files below a folder that end in `.extension`, sorted; folders that cannot be read have none.
pub(crate) fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut all = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let (path, name) = (entry.path(), entry.file_name());
        if path.is_dir() {
            if !FOREIGN.iter().any(|foreign| name == *foreign) {
                all.extend(files(&path, extension));
            }
        } else if path.extension().is_some_and(|end| end == extension) {
            all.push(path);
        }
    }
    all.sort();
    all
}

/// Returns the contents of a JSON file; `None`, and prints why, if it cannot be read.
pub(crate) fn json<T: DeserializeOwned>(path: &Path) -> Option<T> {
    let text = said(path.display(), fs::read_to_string(path))?;
    said(path.display(), serde_json::from_str(&text))
}

/// Writes a file; returns `None`, and prints why, if this fails.
pub(crate) fn write(path: &Path, text: &str) -> Option<()> {
    let folder = path.parent().map_or(Ok(()), fs::create_dir_all);
    said(path.display(), folder.and_then(|()| fs::write(path, text)))
}
