//! The files of the project by their endings.

use std::fs;
use std::path::{Path, PathBuf};

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
