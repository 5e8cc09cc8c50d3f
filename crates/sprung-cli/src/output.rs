//! Results that are complete or not there.

use std::io::Write;
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::exit_code::{ExitCode, Failure};

/// How the names of files begin and end that are not yet results.
const TEMPORARY: (&str, &str) = (".sprung-", ".part");

/// Files of one run: written beside their place, then renamed together, so
/// that earlier results stay whole if anything fails. Each file is always whole; a kill in
/// the microseconds between the renames leaves some of this run beside some of the last.
pub(crate) struct Output {
    folder: PathBuf,
    // Files that were read and must stay.
    inputs: Vec<PathBuf>,
    files: Vec<(PathBuf, NamedTempFile)>,
}

impl Output {
    /// Creates the folder if it is not there.
    pub(crate) fn new(folder: &Path) -> Result<Self, Failure> {
        std::fs::create_dir_all(folder).map_err(|error| {
            let folder = folder.display();
            Failure::new(
                ExitCode::File,
                format!("cannot create the folder {folder}: {error}; choose another with --out"),
            )
        })?;
        clear(folder);
        Ok(Self {
            folder: folder.to_owned(),
            inputs: Vec::new(),
            files: Vec::new(),
        })
    }

    /// Says which files must not be written over.
    pub(crate) fn keeping(mut self, inputs: impl IntoIterator<Item = PathBuf>) -> Self {
        let found = inputs
            .into_iter()
            .filter_map(|path| path.canonicalize().ok());
        self.inputs.extend(found);
        self
    }

    /// Writes a file through `fill`.
    pub(crate) fn write<E: From<std::io::Error> + std::fmt::Display>(
        &mut self,
        name: impl AsRef<Path>,
        fill: impl FnOnce(&mut dyn Write) -> Result<(), E>,
    ) -> Result<PathBuf, Failure> {
        let path = self.folder.join(name);
        if (path.canonicalize()).is_ok_and(|path| self.inputs.contains(&path)) {
            let path = path.display();
            return Err(Failure::new(
                ExitCode::Usage,
                format!("{path} is an input and would be overwritten; choose a folder with --out"),
            ));
        }
        let failed = |error: &dyn std::fmt::Display| {
            Failure::new(
                ExitCode::File,
                format!(
                    "cannot write {}: {error}; results of earlier runs are as they were",
                    path.display()
                ),
            )
        };
        let mut file = temporary(&self.folder).map_err(|error| failed(&error))?;
        let mut writer = std::io::BufWriter::with_capacity(1 << 16, file.as_file_mut());
        fill(&mut writer).map_err(|error| failed(&error))?;
        writer.flush().map_err(|error| failed(&error))?;
        drop(writer);
        self.files.push((path.clone(), file));
        Ok(path)
    }

    /// Writes a text file.
    pub(crate) fn text(&mut self, name: impl AsRef<Path>, text: &str) -> Result<PathBuf, Failure> {
        self.write(name, |write| write.write_all(text.as_bytes()))
    }

    /// Puts all files in their places.
    pub(crate) fn commit(self) -> Result<(), Failure> {
        for (path, file) in &self.files {
            file.as_file().sync_all().map_err(|error| {
                Failure::new(
                    ExitCode::File,
                    format!("cannot write {}: {error}", path.display()),
                )
            })?;
        }
        for (path, file) in self.files {
            file.persist(&path).map_err(|error| {
                Failure::new(
                    ExitCode::File,
                    format!("cannot write {}: {}", path.display(), error.error),
                )
            })?;
        }
        Ok(())
    }
}

/// Removes what killed runs left behind. Others may be writing: their files are locked.
fn clear(folder: &Path) {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    for entry in entries.filter_map(Result::ok) {
        let name = entry.file_name();
        let is_temporary = (name.to_str())
            .is_some_and(|name| name.starts_with(TEMPORARY.0) && name.ends_with(TEMPORARY.1));
        if !is_temporary {
            continue;
        }
        let is_left = std::fs::File::open(entry.path()).is_ok_and(|file| file.try_lock().is_ok());
        if is_left {
            // One that cannot be removed is in nobody's way.
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

fn temporary(folder: &Path) -> std::io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(TEMPORARY.0).suffix(TEMPORARY.1);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // A temporary file is private; a result has the user's usual mode.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let file = builder.tempfile_in(folder)?;
    // A folder on a network may know no locks; results are whole without them.
    let _ = file.as_file().try_lock();
    Ok(file)
}
