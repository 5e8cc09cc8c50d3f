//! Files that take their places together, although a process may be killed between any two renames.
//!
//! A list of the renames goes ahead of them. From when it is in the folder the new files count: whoever
//! comes upon the list of a process that is gone does what is left of it.

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::{Component, Path};

use serde::{Deserialize, Serialize};
use tempfile::NamedTempFile;

use crate::exit_code::{ExitCode, Failure};

/// The list, in the folder of the files.
const LIST: &str = ".sprung-switch";

/// What is to be done in a folder.
#[derive(Debug, Deserialize, Serialize)]
pub(crate) struct Switch {
    /// Files that go.
    pub(crate) outdated: Vec<String>,
    /// Names of files as they were written, and as they will be called.
    pub(crate) renames: Vec<(String, String)>,
}

impl Switch {
    /// Puts the list into a folder, and returns it open; it is locked until it is dropped.
    ///
    /// - `list`: an empty file in the folder, locked.
    pub(crate) fn decide(&self, folder: &Path, mut list: NamedTempFile) -> Result<File, Failure> {
        serde_json::to_writer(&mut list, self)
            .map_err(std::io::Error::from)
            .and_then(|()| list.as_file().sync_all())
            .map_err(|error| failed(folder, "write a list of files", &error))?;
        loop {
            match list.persist_noclobber(folder.join(LIST)) {
                Ok(file) => return Ok(file),
                // Another run is at it, or was.
                Err(error) if error.error.kind() == ErrorKind::AlreadyExists => {
                    list = error.file;
                    finish(folder)?;
                }
                Err(error) => return Err(failed(folder, "put a list of files", &error.error)),
            }
        }
    }

    /// Does what is on the list, or what is left of it, and takes the list away.
    ///
    /// - `list`: as it is in the folder.
    pub(crate) fn carry_out(&self, folder: &Path, list: &File) -> Result<(), Failure> {
        for name in &self.outdated {
            gone(std::fs::remove_file(folder.join(name)))
                .map_err(|error| failed(folder, &format!("remove {name}"), &error))?;
        }
        for (from, to) in &self.renames {
            gone(std::fs::rename(folder.join(from), folder.join(to)))
                .map_err(|error| failed(folder, &format!("put {to} in its place"), &error))?;
        }
        // Those who wait for the lock see that nothing is left to do.
        list.set_len(0)
            .and_then(|()| gone(std::fs::remove_file(folder.join(LIST))))
            .map_err(|error| failed(folder, &format!("remove {LIST}"), &error))
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
pub(crate) fn finish(folder: &Path) -> Result<(), Failure> {
    let mut list = match (File::options().read(true).write(true)).open(folder.join(LIST)) {
        Ok(list) => list,
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
            return Ok(());
        }
        Err(error) => return Err(failed(folder, &format!("open {LIST}"), &error)),
    };
    // A run that is at it holds the lock. A folder on a network may know no locks; what both do
    // is done once.
    let _ = list.lock();
    let mut text = String::new();
    list.read_to_string(&mut text)
        .map_err(|error| failed(folder, &format!("read {LIST}"), &error))?;
    if text.is_empty() {
        // Killed between its last two steps, or done: then another list may be there.
        let path = folder.join(LIST);
        if path.metadata().is_ok_and(|found| found.len() == 0) {
            let _ = std::fs::remove_file(path);
        }
        return Ok(());
    }
    match serde_json::from_str::<Switch>(&text) {
        Ok(switch) if switch.stays_inside() => switch.carry_out(folder, &list),
        _ => Err(Failure::new(
            ExitCode::File,
            format!(
                "{} is no list of files; remove it, and run again what made the results there",
                folder.join(LIST).display()
            ),
        )),
    }
}

/// Finishes what was begun in the folder of a file.
pub(crate) fn finish_beside(file: &Path) -> Result<(), Failure> {
    file.parent().map_or(Ok(()), finish)
}

/// What is not there was dealt with before.
fn gone(result: std::io::Result<()>) -> std::io::Result<()> {
    match result {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        other => other,
    }
}

fn failed(folder: &Path, what: &str, error: &std::io::Error) -> Failure {
    Failure::new(
        ExitCode::File,
        format!(
            "cannot {what} in {}: {error}; files there may be of two runs until the next command \
             that can finish this",
            folder.display()
        ),
    )
}

#[cfg(test)]
mod tests {
    use tempfile::TempDir;

    use super::*;

    const NAMES: [&str; 3] = ["c", "b", "a"];

    /// A folder where a run has written all and is to put it in place.
    fn written() -> (TempDir, Switch) {
        let folder = TempDir::new().unwrap();
        let write = |name: &str, text: &str| {
            std::fs::write(folder.path().join(name), text).unwrap();
        };
        write("outdated", "old");
        let one = |name: &str| {
            let temporary = format!(".sprung-{name}.part");
            write(name, "old");
            write(&temporary, "new");
            (temporary, name.to_owned())
        };
        let switch = Switch {
            renames: NAMES.into_iter().map(one).collect(),
            outdated: vec!["outdated".to_owned()],
        };
        (folder, switch)
    }

    fn list(folder: &Path) -> NamedTempFile {
        let list = NamedTempFile::new_in(folder).unwrap();
        list.as_file().try_lock().unwrap();
        list
    }

    fn is_whole(folder: &Path, text: &str) {
        for name in NAMES {
            assert_eq!(
                std::fs::read_to_string(folder.join(name)).unwrap(),
                text,
                "{name}"
            );
        }
        assert_eq!(folder.join("outdated").exists(), text == "old");
        let count = std::fs::read_dir(folder).unwrap().count();
        assert_eq!(count, NAMES.len(), "something was left");
    }

    #[test]
    fn what_was_begun_is_finished_wherever_it_stopped() {
        // The list alone; without what is outdated; with one to three files in place.
        for done in 0..=4 {
            let (folder, switch) = written();
            let path = folder.path();
            // The lock ends with the process.
            drop(switch.decide(path, list(path)).unwrap());
            if done > 0 {
                std::fs::remove_file(path.join("outdated")).unwrap();
            }
            for (from, to) in switch.renames.iter().take(done.max(1) - 1) {
                std::fs::rename(path.join(from), path.join(to)).unwrap();
            }
            finish(path).unwrap();
            is_whole(path, "new");
            finish(path).unwrap();
            is_whole(path, "new");
        }
    }

    #[test]
    fn a_run_that_is_at_it_is_waited_for() {
        let (folder, switch) = written();
        let path = folder.path();
        let list = switch.decide(path, list(path)).unwrap();
        std::thread::scope(|scope| {
            let other = scope.spawn(|| finish(path));
            std::thread::sleep(std::time::Duration::from_millis(20));
            assert!(!other.is_finished() && path.join("outdated").exists());
            switch.carry_out(path, &list).unwrap();
            drop(list);
            other.join().unwrap().unwrap();
        });
        is_whole(path, "new");
    }

    #[test]
    fn a_list_of_another_run_is_done_first() {
        let (folder, switch) = written();
        let path = folder.path();
        drop(switch.decide(path, list(path)).unwrap());
        std::fs::write(path.join("later"), "newer").unwrap();
        let later = Switch {
            renames: vec![("later".to_owned(), "a".to_owned())],
            outdated: Vec::new(),
        };
        let list = later.decide(path, list(path)).unwrap();
        later.carry_out(path, &list).unwrap();
        assert_eq!(std::fs::read_to_string(path.join("a")).unwrap(), "newer");
        assert_eq!(std::fs::read_to_string(path.join("b")).unwrap(), "new");
    }

    #[test]
    fn a_list_that_is_none_or_leaves_the_folder_is_refused() {
        for text in [
            "{",
            r#"{"outdated": ["../a"], "renames": []}"#,
            r#"{"outdated": [], "renames": [[".sprung-a.part", "/tmp/a"]]}"#,
        ] {
            let folder = TempDir::new().unwrap();
            std::fs::write(folder.path().join(LIST), text).unwrap();
            let failure = finish(folder.path()).unwrap_err();
            assert!(failure.message.contains("is no list of files; remove it"));
        }
        // What a run left that was killed at its very last step.
        let folder = TempDir::new().unwrap();
        std::fs::write(folder.path().join(LIST), "").unwrap();
        finish(folder.path()).unwrap();
        assert!(!folder.path().join(LIST).exists());
    }
}
