//! Writes the list of pending renames before the results take their places.

use std::fs::File;
use std::io::ErrorKind;
use std::path::Path;

use sprung::session::{SWITCH_FILE, SessionError, Switch, finish};
use tempfile::NamedTempFile;

use crate::halt;

/// Puts the list into the folder and returns it opened. The list is locked until it is dropped.
///
/// - `list`: an empty, locked file in the folder.
pub(crate) fn decide(
    switch: &Switch,
    folder: &Path,
    mut list: NamedTempFile,
) -> Result<File, SessionError> {
    serde_json::to_writer(&mut list, switch)
        .map_err(std::io::Error::from)
        .and_then(|()| list.as_file().sync_all())
        .map_err(|error| failed(folder, "write a list of files", error))?;
    halt::at("list written");
    loop {
        match list.persist_noclobber(folder.join(SWITCH_FILE)) {
            Ok(file) => return Ok(file),
            // Another run is making its renames, or was killed while it made them.
            Err(error) if error.error.kind() == ErrorKind::AlreadyExists => {
                list = error.file;
                finish(folder)?;
            }
            Err(error) => return Err(failed(folder, "put a list of files", error.error)),
        }
    }
}

fn failed(folder: &Path, what: &str, source: std::io::Error) -> SessionError {
    SessionError::Unfinished {
        what: what.to_owned(),
        folder: folder.to_owned(),
        source,
    }
}

#[cfg(test)]
mod tests {
    use tempfile::TempDir;

    use super::*;

    const NAMES: [&str; 3] = ["c", "b", "a"];

    /// Returns a folder where a run has written all files but has not renamed them.
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
    fn a_killed_switch_is_completed_from_any_step() {
        // Case 0 has only the list. In case 1 the outdated file is absent. In cases 2 to 4, one to
        // three files are also renamed.
        for done in 0..=4 {
            let (folder, switch) = written();
            let path = folder.path();
            // The lock ends with the process.
            drop(decide(&switch, path, list(path)).unwrap());
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
    fn finish_waits_for_a_running_switch() {
        let (folder, switch) = written();
        let path = folder.path();
        let list = decide(&switch, path, list(path)).unwrap();
        std::thread::scope(|scope| {
            let other = scope.spawn(|| finish(path));
            std::thread::sleep(std::time::Duration::from_millis(20));
            assert!(!other.is_finished() && path.join("outdated").exists());
            switch.carry_out(path, &list, |_| ()).unwrap();
            drop(list);
            other.join().unwrap().unwrap();
        });
        is_whole(path, "new");
    }

    #[test]
    fn an_earlier_list_is_completed_first() {
        let (folder, switch) = written();
        let path = folder.path();
        drop(decide(&switch, path, list(path)).unwrap());
        std::fs::write(path.join("later"), "newer").unwrap();
        let later = Switch {
            renames: vec![("later".to_owned(), "a".to_owned())],
            outdated: Vec::new(),
        };
        let list = decide(&later, path, list(path)).unwrap();
        later.carry_out(path, &list, |_| ()).unwrap();
        assert_eq!(std::fs::read_to_string(path.join("a")).unwrap(), "newer");
        assert_eq!(std::fs::read_to_string(path.join("b")).unwrap(), "new");
    }

    #[test]
    fn damaged_lists_and_lists_for_other_folders_are_refused() {
        for text in [
            "{",
            r#"{"outdated": ["../a"], "renames": []}"#,
            r#"{"outdated": [], "renames": [[".sprung-a.part", "/tmp/a"]]}"#,
        ] {
            let folder = TempDir::new().unwrap();
            std::fs::write(folder.path().join(SWITCH_FILE), text).unwrap();
            let failure = finish(folder.path()).unwrap_err();
            assert!(
                failure
                    .to_string()
                    .contains("is not a valid list of files; remove it")
            );
        }
        // A run that was killed at its last step leaves an empty list.
        let folder = TempDir::new().unwrap();
        std::fs::write(folder.path().join(SWITCH_FILE), "").unwrap();
        finish(folder.path()).unwrap();
        assert!(!folder.path().join(SWITCH_FILE).exists());
    }
}
