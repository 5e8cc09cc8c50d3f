//! Starts a new experiment from a URDF file.

use std::path::{Path, PathBuf};

use super::error::SessionError;
use super::files::{Disk, read_text};
use sprung_robot::{Start, Urdf};

/// Returns the data of a robot in its URDF file, for an experiment in `folder`.
///
/// - `folder`: future folder of the experiment; it need not exist.
///
/// # Errors
///
/// [`SessionError`] if the file cannot be read or is wrong.
pub fn start_from_urdf(file: &Path, folder: &Path) -> Result<Start, SessionError> {
    let text = read_text(&Disk, file)?;
    let urdf = Urdf::parse(&file.display().to_string(), &text)?;
    let path = reference(file, folder).map_err(|source| SessionError::NoFolder {
        file: file.to_owned(),
        source,
    })?;
    let Some(path) = path.to_str() else {
        return Err(SessionError::NotUnicode { path });
    };
    Ok(Start::urdf(&urdf, path)?)
}

/// Returns the path of a file for an experiment in `folder`: relative if the file lies below the
/// folder or its parent, otherwise absolute.
pub(super) fn reference(file: &Path, folder: &Path) -> std::io::Result<PathBuf> {
    // A symbolic link keeps its own name.
    let file = std::path::absolute(file)?;
    let (Some(parent), Some(name)) = (file.parent(), file.file_name()) else {
        return Ok(file);
    };
    let file = parent.canonicalize()?.join(name);
    let relative = resolved(folder).and_then(|folder| {
        let below = |root: &Path| file.strip_prefix(root).ok().map(Path::to_owned);
        below(&folder).or_else(|| Some(Path::new("..").join(below(folder.parent()?)?)))
    });
    Ok(relative.unwrap_or(file))
}

/// Returns the absolute path of a folder, which need not exist.
pub(super) fn resolved(folder: &Path) -> Option<PathBuf> {
    let folder = std::path::absolute(folder).ok()?;
    folder.ancestors().find_map(|known| {
        let rest = folder.strip_prefix(known).ok()?;
        Some(known.canonicalize().ok()?.join(rest))
    })
}
