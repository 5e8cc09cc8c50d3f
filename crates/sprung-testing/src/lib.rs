//! Finds what tests need from outside the repository, reports tests that are skipped, compares messages with files,
//! and gives the limits of random errors.
//!
//! A test that returns early counts as passed, and libtest hides its output. So a test that cannot
//! run calls [`skipped`], whose line reaches the terminal; `cargo xtask test` counts these lines.
//!
//! - `SPRUNG_TEST_DATA`: the folder with recorded logs (`data`) and vectors of independent code
//!   (`golden`). Without the variable, tests look for a folder `shared` beside the checkout and are
//!   skipped if it is absent. With the variable, a missing file fails the test.
//! - `SPRUNG_TEST_REQUIRE`: needs that must be met, separated by commas (`data,browser,hdf5`). A test
//!   that would be skipped for one of these needs fails instead.
//! - `SPRUNG_WRITE_MESSAGES`: [`Messages`] writes its file instead of comparing with it.

mod figure;
mod messages;
mod statistics;

use std::ffi::OsStr;
use std::fmt::Debug;
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

pub use figure::Figure;
pub use messages::Messages;
pub use statistics::{FALSE_ALARM, largest_of_normals, least_inside};

/// Returns a recorded log, or a folder of logs; reports the calling test as skipped if it is absent.
///
/// - `file`: path below `data`.
///
/// # Panics
///
/// If `SPRUNG_TEST_DATA` is set and the file is absent.
#[must_use]
#[track_caller]
pub fn data(file: &str) -> Option<PathBuf> {
    shared(&Path::new("data").join(file))
}

/// Returns a file of vectors from independent code; reports the calling test as skipped if it is absent.
///
/// - `file`: path below `golden`.
///
/// # Panics
///
/// If `SPRUNG_TEST_DATA` is set and the file is absent.
#[must_use]
#[track_caller]
pub fn golden(file: &str) -> Option<PathBuf> {
    shared(&Path::new("golden").join(file))
}

/// Most letters of a row in a message.
const ROW: usize = 200;

/// Runs a test for each row of a table. A failure names its rows, and the rows after it run too.
///
/// # Panics
///
/// If the test of a row panics.
#[track_caller]
pub fn each<R: Debug>(rows: impl IntoIterator<Item = R>, mut test: impl FnMut(R)) {
    let mut failed: Vec<String> = Vec::new();
    for row in rows {
        let name = format!("{row:?}").chars().take(ROW).collect();
        if catch_unwind(AssertUnwindSafe(|| test(row))).is_err() {
            failed.push(name);
        }
    }
    assert!(
        failed.is_empty(),
        "rows that failed:\n{}",
        failed.join("\n")
    );
}

/// Checks that a text has all parts.
///
/// # Panics
///
/// If a part is absent.
#[track_caller]
pub fn contains(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "no {part:?} in: {text}");
    }
}

/// Reports the calling test as skipped, on a line that libtest does not capture.
///
/// - `need`: the missing input, as `SPRUNG_TEST_REQUIRE` names it.
///
/// # Panics
///
/// If `SPRUNG_TEST_REQUIRE` names `need`.
#[track_caller]
pub fn skipped(need: &str, reason: &str) {
    let required = std::env::var("SPRUNG_TEST_REQUIRE").unwrap_or_default();
    assert!(
        !lists(&required, need),
        "{reason}; SPRUNG_TEST_REQUIRE={required} demands it"
    );
    let thread = std::thread::current();
    let name = thread.name().unwrap_or("a test");
    let line = format!("SKIPPED {name}: {reason}\n");
    // `eprintln!` would be captured. A closed stderr is no failure of the test.
    let _ = std::io::stderr().write_all(line.as_bytes());
}

#[track_caller]
fn shared(file: &Path) -> Option<PathBuf> {
    let folder = std::env::var_os("SPRUNG_TEST_DATA");
    let (path, exists) = locate(folder.as_deref(), file);
    if exists {
        return Some(path);
    }
    assert!(
        folder.is_none(),
        "{} is absent; SPRUNG_TEST_DATA must name the folder that holds data and golden",
        path.display()
    );
    skipped("data", &format!("{} is absent", missing(&path)));
    None
}

/// Returns the path of a shared file and whether it exists.
///
/// - `folder`: value of `SPRUNG_TEST_DATA`.
fn locate(folder: Option<&OsStr>, file: &Path) -> (PathBuf, bool) {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared");
    let path = folder.map_or_else(beside, PathBuf::from).join(file);
    path.canonicalize()
        .map_or((path, false), |path| (path, true))
}

/// Returns the first folder or file of a path that is absent, as seen from the checkout.
fn missing(path: &Path) -> String {
    let ancestors: Vec<&Path> = path.ancestors().collect();
    let first = ancestors.iter().rev().find(|part| !part.exists());
    let from_shared = first.unwrap_or(&path).iter();
    let shown: PathBuf = (from_shared.skip_while(|part| *part != "shared")).collect();
    format!("../{}", shown.display())
}

/// Returns whether a list of names separated by commas contains a name.
fn lists(list: &str, name: &str) -> bool {
    list.split(',').any(|word| word.trim() == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_found_below_the_folder_that_is_set() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
        let (found, exists) = locate(Some(folder.as_os_str()), Path::new("src/lib.rs"));
        assert!(exists && found.ends_with("sprung-testing/src/lib.rs"));
        let (absent, exists) = locate(Some(folder.as_os_str()), Path::new("data/none.csv"));
        assert!(!exists && absent.ends_with("sprung-testing/data/none.csv"));
        assert!(!locate(None, Path::new("data/none.csv")).1);
    }

    #[test]
    fn the_first_missing_folder_is_named() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
        let path = folder.join("shared/data/emps/none.csv");
        assert_eq!(missing(&path), "../shared");
    }

    #[test]
    fn needs_are_names_between_commas() {
        assert!(lists("browser,hdf5", "hdf5") && lists(" browser , hdf5", "browser"));
        assert!(!lists("", "browser") && !lists("browsers", "browser"));
    }
}
