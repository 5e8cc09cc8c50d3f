//! Replaces a set of files as a whole, although the process may be killed between two renames.
//!
//! A list of the renames is written first. Once the list is in the folder, the new files are valid.
//! If the process that wrote the list was killed, the next process completes the renames.

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::{Component, Path};

use serde::{Deserialize, Serialize};

use super::error::SessionError;

/// File name of the list, in the folder of the results.
pub const SWITCH_FILE: &str = ".sprung-switch";

/// Beginning and end of the names of temporary files.
pub const TEMPORARY_NAME: (&str, &str) = (".sprung-", ".part");

/// Pending changes in a folder.
#[derive(Debug, Deserialize, Serialize)]
pub struct Switch {
    /// Files to remove.
    pub outdated: Vec<String>,
    /// Temporary and final names of files.
    pub renames: Vec<(String, String)>,
}

impl Switch {
    /// Makes the remaining changes of the list and then removes the list.
    ///
    /// - `list`: the opened and locked file of the list.
    /// - `after_change`: is called with the name of a file after the file is removed or put in its place.
    ///   The last name is that of the list, which is emptied and then removed.
    ///
    /// # Errors
    ///
    /// [`SessionError::Unfinished`] if a file cannot be moved; the list then stays.
    pub fn carry_out(
        &self,
        folder: &Path,
        list: &File,
        mut after_change: impl FnMut(&str),
    ) -> Result<(), SessionError> {
        for name in &self.outdated {
            gone(std::fs::remove_file(folder.join(name)))
                .map_err(|error| failed(folder, &format!("remove {name}"), error))?;
            after_change(name);
        }
        for (from, to) in &self.renames {
            gone(std::fs::rename(folder.join(from), folder.join(to)))
                .map_err(|error| failed(folder, &format!("put {to} in its place"), error))?;
            after_change(to);
        }
        // An empty list informs processes that wait for the lock that the work is complete.
        let removed = list.set_len(0).and_then(|()| {
            after_change(SWITCH_FILE);
            gone(std::fs::remove_file(folder.join(SWITCH_FILE)))
        });
        removed.map_err(|error| failed(folder, &format!("remove {SWITCH_FILE}"), error))
    }

    /// Returns whether all names are plain file names in the same folder.
    fn stays_inside(&self) -> bool {
        let is_plain = |name: &String| {
            let mut parts = Path::new(name).components();
            matches!(parts.next(), Some(Component::Normal(_))) && parts.next().is_none()
        };
        let renamed = self.renames.iter().flat_map(|(from, to)| [from, to]);
        self.outdated.iter().chain(renamed).all(is_plain)
    }
}

/// Completes the renames of a killed run if its list exists, and removes the temporary files of killed runs. Every
/// command calls this before it reads or writes results in a folder.
///
/// # Errors
///
/// [`SessionError`] if a file cannot be moved or the list is damaged.
pub fn finish(folder: &Path) -> Result<(), SessionError> {
    complete(folder)?;
    clear(folder);
    Ok(())
}

/// Removes the temporary files of killed runs. Files of running processes are locked, so they stay.
fn clear(folder: &Path) {
    let folder = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    for entry in entries.filter_map(Result::ok) {
        let name = entry.file_name();
        let is_temporary = (name.to_str()).is_some_and(|name| {
            name.starts_with(TEMPORARY_NAME.0) && name.ends_with(TEMPORARY_NAME.1)
        });
        let is_left = || File::open(entry.path()).is_ok_and(|file| file.try_lock().is_ok());
        if is_temporary && is_left() {
            // A file that cannot be removed does no harm.
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// Completes the renames of a killed run if its list exists.
fn complete(folder: &Path) -> Result<(), SessionError> {
    let mut list = match (File::options().read(true).write(true)).open(folder.join(SWITCH_FILE)) {
        Ok(list) => list,
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
            return Ok(());
        }
        Err(error) => return Err(failed(folder, &format!("open {SWITCH_FILE}"), error)),
    };
    // A running process holds the lock. Network file systems may not support locks; then two
    // processes may make the same changes, which is harmless.
    let _ = list.lock();
    let mut text = String::new();
    list.read_to_string(&mut text)
        .map_err(|error| failed(folder, &format!("read {SWITCH_FILE}"), error))?;
    if text.is_empty() {
        // Either the list was emptied but not removed, or another process finished. In the second
        // case there may be a new list, which must stay.
        let path = folder.join(SWITCH_FILE);
        if path.metadata().is_ok_and(|found| found.len() == 0) {
            let _ = std::fs::remove_file(path);
        }
        return Ok(());
    }
    match serde_json::from_str::<Switch>(&text) {
        Ok(switch) if switch.stays_inside() => switch.carry_out(folder, &list, |_| ()),
        _ => Err(SessionError::NoSwitch {
            list: folder.join(SWITCH_FILE),
        }),
    }
}

/// Treats a missing file as success, because an earlier attempt already moved or removed it.
fn gone(result: std::io::Result<()>) -> std::io::Result<()> {
    match result {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        other => other,
    }
}

fn failed(folder: &Path, what: &str, source: std::io::Error) -> SessionError {
    SessionError::Unfinished {
        what: what.to_owned(),
        folder: folder.to_owned(),
        source,
    }
}
