//! Writes the results of a run completely or not at all.

use std::cell::Cell;
use std::fs::TryLockError;
use std::io::Write;
use std::path::{Path, PathBuf};

use sprung::session::{Session, Switch, TEMPORARY_NAME, finish};
use tempfile::NamedTempFile;

use crate::args::Common;
use crate::exit_code::Failure;
use crate::halt;
use crate::switch::decide;

/// Returns the folder for results of a command.
pub(crate) fn results_folder(session: &Session, common: &Common) -> PathBuf {
    (common.out.clone()).unwrap_or_else(|| session.results_folder())
}

/// A folder for results. It exists and can be written, so no result is computed in vain.
pub(crate) struct Folder {
    path: PathBuf,
    // Input files, which must not be overwritten.
    inputs: Vec<PathBuf>,
    // Folders that did not exist, the innermost first. They are removed if they remain empty.
    created: Vec<PathBuf>,
    // Whether this run has replaced files already.
    replaced: Cell<bool>,
}

impl Folder {
    /// Creates the folder if it does not exist, completes the renames of a killed run, and tests that the results can
    /// be written.
    ///
    /// - `inputs`: files that are not overwritten.
    /// - `names`: names of the files that the command will write.
    pub(crate) fn new(
        path: &Path,
        inputs: impl IntoIterator<Item = PathBuf>,
        names: &[impl AsRef<Path>],
    ) -> Result<Self, Failure> {
        let missing = path
            .ancestors()
            .take_while(|folder| !folder.as_os_str().is_empty() && !folder.exists());
        let created = missing.map(Path::to_owned).collect();
        let folder = Self {
            path: path.to_owned(),
            inputs: (inputs.into_iter())
                .filter_map(|path| path.canonicalize().ok())
                .collect(),
            created,
            replaced: Cell::new(false),
        };
        folder.create()?;
        for name in names {
            folder.destination(name.as_ref())?;
        }
        temporary(path).map_err(|error| {
            let path = path.display();
            Failure::file(format!(
                "cannot write into the folder {path}: {error}; choose another folder"
            ))
        })?;
        Ok(folder)
    }

    /// Begins a set of files.
    pub(crate) fn output(&self) -> Result<Output<'_>, Failure> {
        // Another run may have been killed, or the folder removed, since `new`.
        self.create()?;
        halt::at("nothing written");
        Ok(Output {
            folder: self,
            files: Vec::new(),
            outdated: Vec::new(),
        })
    }

    fn create(&self) -> Result<(), Failure> {
        std::fs::create_dir_all(&self.path).map_err(|error| {
            let folder = self.path.display();
            Failure::file(format!(
                "cannot create the folder {folder}: {error}; choose another folder"
            ))
        })?;
        finish(&self.path)?;
        Ok(())
    }

    /// Returns the path of a file to be written.
    fn destination(&self, name: &Path) -> Result<PathBuf, Failure> {
        let path = self.path.join(name);
        if (path.canonicalize()).is_ok_and(|path| self.inputs.contains(&path)) {
            let path = path.display();
            return Err(Failure::usage(format!(
                "{path} is an input and would be overwritten; choose a folder with --out"
            )));
        }
        if path.is_dir() {
            let error = std::io::Error::from(std::io::ErrorKind::IsADirectory);
            return Err(cannot_write(&path, &error));
        }
        Ok(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        for folder in &self.created {
            // A folder with files stays.
            if std::fs::remove_dir(folder).is_err() {
                break;
            }
        }
    }
}

/// Files of one run. They are written under temporary names in the same folder and then renamed
/// together, so earlier results stay complete if a step fails. If the program is killed between the
/// renames, the list of renames remains, and the next command completes it.
pub(crate) struct Output<'a> {
    folder: &'a Folder,
    files: Vec<(PathBuf, NamedTempFile)>,
    // Files of earlier runs that are removed when the new files take their places.
    outdated: Vec<PathBuf>,
}

impl Output<'_> {
    /// Returns the path of the folder.
    pub(crate) fn folder(&self) -> &Path {
        &self.folder.path
    }

    /// Writes a file with the function `fill`.
    pub(crate) fn write<E: From<std::io::Error> + std::fmt::Display>(
        &mut self,
        name: impl AsRef<Path>,
        fill: impl FnOnce(&mut dyn Write) -> Result<(), E>,
    ) -> Result<PathBuf, Failure> {
        let path = self.folder.destination(name.as_ref())?;
        let kept = if self.folder.replaced.get() {
            "the files that this run wrote before are complete"
        } else {
            "results of earlier runs are unchanged"
        };
        let failed = |error: &dyn std::fmt::Display| {
            Failure::file(format!("cannot write {}: {error}; {kept}", path.display()))
        };
        let mut file = temporary(&self.folder.path).map_err(|error| failed(&error))?;
        let mut writer = std::io::BufWriter::with_capacity(1 << 16, file.as_file_mut());
        fill(&mut writer).map_err(|error| failed(&error))?;
        writer.flush().map_err(|error| failed(&error))?;
        drop(writer);
        halt::at("a file written");
        self.files.push((path.clone(), file));
        Ok(path)
    }

    /// Writes a text file.
    pub(crate) fn text(&mut self, name: impl AsRef<Path>, text: &str) -> Result<PathBuf, Failure> {
        self.write(name, |write| write.write_all(text.as_bytes()))
    }

    /// Marks a file of an earlier run for removal if it exists and is not an input. Returns whether
    /// it is marked.
    pub(crate) fn outdates(&mut self, name: &str) -> bool {
        let path = self.folder.path.join(name);
        let goes = (path.canonicalize()).is_ok_and(|path| !self.folder.inputs.contains(&path));
        if goes {
            self.outdated.push(path);
        }
        goes
    }

    /// Renames all files to their final names.
    pub(crate) fn commit(self) -> Result<(), Failure> {
        let replaced = &self.folder.replaced;
        for (path, file) in &self.files {
            let synced = file.as_file().sync_all();
            synced.map_err(|error| cannot_write(path, &error))?;
        }
        halt::at("all written");
        replaced.set(true);
        if self.files.len() > 1 || !self.outdated.is_empty() {
            return self.switch();
        }
        for (path, file) in self.files {
            (file.persist(&path)).map_err(|error| cannot_write(&path, &error.error))?;
        }
        Ok(())
    }

    /// Renames several files to their final names, with a list that survives a kill.
    fn switch(self) -> Result<(), Failure> {
        let name = |path: &Path| -> Result<String, Failure> {
            (path.file_name().and_then(|name| name.to_str()))
                .map(str::to_owned)
                .ok_or_else(|| cannot_write(path, &"its name is not Unicode"))
        };
        // A program may wait for the file that was written first. That file is renamed last, so the
        // others exist by then.
        let renames = self.files.iter().rev().map(|(path, file)| {
            let from = name(file.path())?;
            Ok((from, name(path)?))
        });
        let switch = Switch {
            renames: renames.collect::<Result<_, Failure>>()?,
            outdated: (self.outdated.iter().map(|path| name(path))).collect::<Result<_, _>>()?,
        };
        let folder = &self.folder.path;
        let list = temporary(folder).map_err(|error| cannot_write(folder, &error))?;
        let list = decide(&switch, folder, list)?;
        halt::at("list in place");
        // The temporary files stay open and locked until they are renamed.
        let mut files = Vec::new();
        for (path, file) in self.files {
            files.push((file.keep()).map_err(|error| cannot_write(&path, &error.error))?);
        }
        switch.carry_out(folder, &list, halt::at)?;
        halt::at("list removed");
        Ok(())
    }
}

fn cannot_write(path: &Path, error: &dyn std::fmt::Display) -> Failure {
    Failure::file(format!("cannot write {}: {error}", path.display()))
}

/// Creates a locked temporary file.
fn temporary(folder: &Path) -> std::io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    let (prefix, suffix) = TEMPORARY_NAME;
    builder.prefix(prefix).suffix(suffix);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // A temporary file is private by default; a result gets the user's usual permissions.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    loop {
        let file = builder.tempfile_in(folder)?;
        // Network file systems may not support locks. The results are complete without them.
        let locked = file.as_file().try_lock();
        // Before the lock, another run may take the file for that of a killed run and remove it.
        let is_taken = matches!(locked, Err(TryLockError::WouldBlock)) || !file.path().exists();
        if !is_taken {
            return Ok(file);
        }
    }
}
