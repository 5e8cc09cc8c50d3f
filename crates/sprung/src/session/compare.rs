//! Files of results beside each other.

use std::path::{Path, PathBuf};

use super::error::SessionError;
use super::results::{ReadIdentification, read_identification};
use crate::compare::{Compared, Comparison, compare};
use crate::progress::{Listener, Phase};

/// A comparison, and the files that were read for it.
#[derive(Clone, Debug)]
pub struct ComparedFiles {
    /// The comparison.
    pub comparison: Comparison,
    /// Where the identifications were found.
    pub files: Vec<PathBuf>,
}

/// Compares the results in files with those of the first.
///
/// - `paths`: each an `identification.json`, a folder of results, or that of an experiment.
///
/// # Errors
///
/// [`SessionError`] if one is no identification or given twice, or they have nothing in common.
pub fn compare_files(
    paths: &[impl AsRef<Path>],
    progress: &mut dyn Listener,
) -> Result<ComparedFiles, SessionError> {
    let mut read = Vec::new();
    let total = paths.len() as u64;
    for (path, number) in paths.iter().zip(1..) {
        progress.tell(Phase::Comparing, number, Some(total))?;
        read.push(read_identification(path.as_ref())?);
    }
    check_twice(&read)?;
    let names: Vec<String> = (read.iter())
        .map(|one| one.path.display().to_string())
        .collect();
    let files: Vec<Compared<'_>> = (names.iter().zip(&read))
        .map(|(file, one)| Compared {
            file,
            identification: &one.identification,
        })
        .collect();
    Ok(ComparedFiles {
        comparison: compare(&files)?,
        files: read.into_iter().map(|one| one.path).collect(),
    })
}

/// A file beside itself agrees with anything.
fn check_twice(read: &[ReadIdentification]) -> Result<(), SessionError> {
    for (i, one) in read.iter().enumerate() {
        let same = |other: &&ReadIdentification| {
            let (a, b) = (one.path.canonicalize(), other.path.canonicalize());
            matches!((a, b), (Ok(a), Ok(b)) if a == b)
        };
        if read[..i].iter().any(|other| same(&other)) {
            return Err(SessionError::GivenTwice {
                file: one.path.clone(),
            });
        }
    }
    Ok(())
}
