//! Opens folders given as logs: bags of ROS 2.

use std::io::{Error, ErrorKind};
use std::path::{Path, PathBuf};

/// Returns the single file of messages in a folder.
pub(super) fn of_bag(folder: &Path) -> std::io::Result<PathBuf> {
    let entries = std::fs::read_dir(folder)?;
    let mut files: Vec<PathBuf> = (entries.filter_map(Result::ok))
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|e| e == "mcap" || e == "db3"))
        .collect();
    files.sort();
    let what = match &files[..] {
        [one] => return Ok(one.clone()),
        [] => "it is a folder without .mcap or .db3 file".to_owned(),
        [first, ..] => format!(
            "it is a folder with {} bags; name them one by one, as file = [\"{}\", …]",
            files.len(),
            first.display()
        ),
    };
    Err(Error::new(ErrorKind::IsADirectory, what))
}
