//! Compares files of results.

use std::path::{Path, PathBuf};

use super::error::SessionError;
use super::results::{ReadIdentification, read_identification};
use crate::compare::{Compared, Comparison, compare};
use crate::progress::{Listener, Phase};

/// A comparison and the files read for it.
#[derive(Clone, Debug)]
pub struct ComparedFiles {
    /// The comparison.
    pub comparison: Comparison,
    /// Paths of the identifications.
    pub files: Vec<PathBuf>,
}

/// Compares the results in each file with those in the first.
///
/// - `paths`: each is an `identification.json`, a folder of results, or the folder of an
///   experiment.
///
/// # Errors
///
/// [`SessionError`] if a file is not an identification, if a file is given twice, or if the files
/// share no parameters.
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

/// Returns an error if a file is given twice, because a file always agrees with itself.
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
