//! Compares files of results.

use std::path::{Path, PathBuf};

use super::error::SessionError;
use super::results::read_results;
use sprung_base::progress::{Listener, Phase};
use sprung_method::compare::{Compared, ComparedValidation, Comparison, compare};

/// A comparison and the files read for it.
#[derive(Clone, Debug)]
pub struct ComparedFiles {
    /// The comparison.
    pub comparison: Comparison,
    /// Paths of the identifications, then of the validations.
    pub files: Vec<PathBuf>,
}

/// Compares the results in each file with those in the first, and the promises of all validations.
///
/// - `paths`: each is an `identification.json`, a `validation.json`, a folder of results, or the
///   folder of an experiment.
///
/// # Errors
///
/// [`SessionError`] if a file is neither an identification nor a validation, if a file is given twice, or if the files
/// are of different robots or share no parameters.
pub fn compare_files(
    paths: &[impl AsRef<Path>],
    progress: &mut dyn Listener,
) -> Result<ComparedFiles, SessionError> {
    let (mut identified, mut validated) = (Vec::new(), Vec::new());
    let total = paths.len() as u64;
    for (path, number) in paths.iter().zip(1..) {
        progress.tell(Phase::Comparing, number, Some(total))?;
        let (identification, validation) = read_results(path.as_ref())?;
        identified.extend(identification);
        validated.extend(validation);
    }
    let files: Vec<PathBuf> = (identified.iter().map(|one| &one.path))
        .chain(validated.iter().map(|one| &one.path))
        .cloned()
        .collect();
    check_twice(&files)?;
    let names: Vec<String> = files
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    let (of_identified, of_validated) = names.split_at(identified.len());
    let identifications: Vec<Compared<'_>> = (of_identified.iter().zip(&identified))
        .map(|(file, one)| Compared {
            file,
            identification: &one.identification,
        })
        .collect();
    let validations: Vec<ComparedValidation<'_>> = (of_validated.iter().zip(&validated))
        .map(|(file, one)| ComparedValidation {
            file,
            validation: &one.validation,
        })
        .collect();
    Ok(ComparedFiles {
        comparison: compare(&identifications, &validations)?,
        files,
    })
}

/// Returns an error if a file is given twice, because a file always agrees with itself.
fn check_twice(files: &[PathBuf]) -> Result<(), SessionError> {
    for (i, one) in files.iter().enumerate() {
        let same = |other: &&PathBuf| {
            let (a, b) = (one.canonicalize(), other.canonicalize());
            matches!((a, b), (Ok(a), Ok(b)) if a == b)
        };
        if files[..i].iter().any(|other| same(&other)) {
            return Err(SessionError::GivenTwice { file: one.clone() });
        }
    }
    Ok(())
}
