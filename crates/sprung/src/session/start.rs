//! Experiments to start from.

use std::path::{Path, PathBuf};

use super::error::SessionError;
use super::files::{Disk, read_text};
use crate::description::{Start, Urdf};

/// Returns what is known of a robot from its URDF file, for an experiment in a folder.
///
/// - `folder`: where the experiment will be; it need not be there yet.
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

/// Returns the path of a file as an experiment in `folder` names it: relative
/// if it lies below the folder or beside it, otherwise absolute.
fn reference(file: &Path, folder: &Path) -> std::io::Result<PathBuf> {
    // The file keeps its name, be it that of a link.
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

/// Returns the absolute path of a folder, which need not be there yet.
fn resolved(folder: &Path) -> Option<PathBuf> {
    let folder = std::path::absolute(folder).ok()?;
    folder.ancestors().find_map(|known| {
        let rest = folder.strip_prefix(known).ok()?;
        Some(known.canonicalize().ok()?.join(rest))
    })
}
