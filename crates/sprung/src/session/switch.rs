//! Files that take their places together, although a process may be killed between any two renames.
//!
//! A list of the renames goes ahead of them. From when it is in the folder the new files count: whoever
//! comes upon the list of a process that is gone does what is left of it.

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::{Component, Path};

use serde::{Deserialize, Serialize};

use super::error::SessionError;

/// The list, in the folder of the files.
pub const SWITCH_FILE: &str = ".sprung-switch";

/// What is to be done in a folder.
#[derive(Debug, Deserialize, Serialize)]
pub struct Switch {
    /// Files that go.
    pub outdated: Vec<String>,
    /// Names of files as they were written, and as they will be called.
    pub renames: Vec<(String, String)>,
}

impl Switch {
    /// Does what is on the list, or what is left of it, and takes the list away.
    ///
    /// - `list`: as it is in the folder, locked.
    ///
    /// # Errors
    ///
    /// [`SessionError::Unfinished`] if a file cannot be moved; the list stays.
    pub fn carry_out(&self, folder: &Path, list: &File) -> Result<(), SessionError> {
        for name in &self.outdated {
            gone(std::fs::remove_file(folder.join(name)))
                .map_err(|error| failed(folder, &format!("remove {name}"), error))?;
        }
        for (from, to) in &self.renames {
            gone(std::fs::rename(folder.join(from), folder.join(to)))
                .map_err(|error| failed(folder, &format!("put {to} in its place"), error))?;
        }
        // Those who wait for the lock see that nothing is left to do.
        list.set_len(0)
            .and_then(|()| gone(std::fs::remove_file(folder.join(SWITCH_FILE))))
            .map_err(|error| failed(folder, &format!("remove {SWITCH_FILE}"), error))
    }

    /// Returns whether it says nothing of other folders.
    fn stays_inside(&self) -> bool {
        let is_plain = |name: &String| {
            let mut parts = Path::new(name).components();
            matches!(parts.next(), Some(Component::Normal(_))) && parts.next().is_none()
        };
        let renamed = self.renames.iter().flat_map(|(from, to)| [from, to]);
        self.outdated.iter().chain(renamed).all(is_plain)
    }
}

/// Puts in their places what a run that was killed had written, if it had written all; whoever
/// reads or writes results of a folder does this first.
///
/// # Errors
///
/// [`SessionError`] if a file cannot be moved or the list is none.
pub fn finish(folder: &Path) -> Result<(), SessionError> {
    let mut list = match (File::options().read(true).write(true)).open(folder.join(SWITCH_FILE)) {
        Ok(list) => list,
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
            return Ok(());
        }
        Err(error) => return Err(failed(folder, &format!("open {SWITCH_FILE}"), error)),
    };
    // A run that is at it holds the lock. A folder on a network may know no locks; what both do
    // is done once.
    let _ = list.lock();
    let mut text = String::new();
    list.read_to_string(&mut text)
        .map_err(|error| failed(folder, &format!("read {SWITCH_FILE}"), error))?;
    if text.is_empty() {
        // Killed between its last two steps, or done: then another list may be there.
        let path = folder.join(SWITCH_FILE);
        if path.metadata().is_ok_and(|found| found.len() == 0) {
            let _ = std::fs::remove_file(path);
        }
        return Ok(());
    }
    match serde_json::from_str::<Switch>(&text) {
        Ok(switch) if switch.stays_inside() => switch.carry_out(folder, &list),
        _ => Err(SessionError::NoSwitch {
            list: folder.join(SWITCH_FILE),
        }),
    }
}

/// What is not there was dealt with before.
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
