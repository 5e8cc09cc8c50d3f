//! Writes the results of a run completely or not at all.

use std::io::Write;
use std::path::{Path, PathBuf};

use sprung::session::{Session, Switch, finish};
use tempfile::NamedTempFile;

use crate::args::Common;
use crate::exit_code::{ExitCode, Failure};
use crate::halt;
use crate::switch::decide;

/// Prefix and suffix of temporary files.
const TEMPORARY: (&str, &str) = (".sprung-", ".part");

/// Returns the folder for results of a command.
pub(crate) fn results_folder(session: &Session, common: &Common) -> PathBuf {
    (common.out.clone()).unwrap_or_else(|| session.results_folder())
}

/// Files of one run. They are written under temporary names in the same folder and then renamed
/// together, so earlier results stay complete if a step fails. If the program is killed between the
/// renames, the list of renames remains, and the next command completes it.
pub(crate) struct Output {
    folder: PathBuf,
    // Input files, which must not be overwritten.
    inputs: Vec<PathBuf>,
    files: Vec<(PathBuf, NamedTempFile)>,
    // Files of earlier runs that are removed when the new files take their places.
    outdated: Vec<PathBuf>,
}

impl Output {
    /// Creates the folder if it does not exist, completes the renames of a killed run, and removes
    /// its temporary files.
    pub(crate) fn new(folder: &Path) -> Result<Self, Failure> {
        std::fs::create_dir_all(folder).map_err(|error| {
            let folder = folder.display();
            Failure::new(
                ExitCode::File,
                format!("cannot create the folder {folder}: {error}; choose another with --out"),
            )
        })?;
        finish(folder)?;
        clear(folder);
        halt::at("nothing written");
        Ok(Self {
            folder: folder.to_owned(),
            inputs: Vec::new(),
            files: Vec::new(),
            outdated: Vec::new(),
        })
    }

    /// Protects input files from being overwritten.
    pub(crate) fn keeping(mut self, inputs: impl IntoIterator<Item = PathBuf>) -> Self {
        let found = inputs
            .into_iter()
            .filter_map(|path| path.canonicalize().ok());
        self.inputs.extend(found);
        self
    }

    /// Writes a file with the function `fill`.
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
                    "cannot write {}: {error}; results of earlier runs are unchanged",
                    path.display()
                ),
            )
        };
        let mut file = temporary(&self.folder).map_err(|error| failed(&error))?;
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
        let path = self.folder.join(name);
        let goes = (path.canonicalize()).is_ok_and(|path| !self.inputs.contains(&path));
        if goes {
            self.outdated.push(path);
        }
        goes
    }

    /// Renames all files to their final names.
    pub(crate) fn commit(self) -> Result<(), Failure> {
        for (path, file) in &self.files {
            let synced = file.as_file().sync_all();
            synced.map_err(|error| cannot_write(path, &error))?;
            if path.is_dir() {
                let error = std::io::Error::from(std::io::ErrorKind::IsADirectory);
                return Err(cannot_write(path, &error));
            }
        }
        halt::at("all written");
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
        let list = temporary(&self.folder).map_err(|error| cannot_write(&self.folder, &error))?;
        let list = decide(&switch, &self.folder, list)?;
        halt::at("list in place");
        // The temporary files stay open and locked until they are renamed.
        let mut files = Vec::new();
        for (path, file) in self.files {
            files.push((file.keep()).map_err(|error| cannot_write(&path, &error.error))?);
        }
        switch.carry_out(&self.folder, &list, halt::at)?;
        halt::at("list removed");
        Ok(())
    }
}

fn cannot_write(path: &Path, error: &dyn std::fmt::Display) -> Failure {
    Failure::new(
        ExitCode::File,
        format!("cannot write {}: {error}", path.display()),
    )
}

/// Removes the temporary files of killed runs. Files of running processes are locked, so they stay.
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
            // A file that cannot be removed does no harm.
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
        // A temporary file is private by default; a result gets the user's usual permissions.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let file = builder.tempfile_in(folder)?;
    // Network file systems may not support locks. The results are complete without them.
    let _ = file.as_file().try_lock();
    Ok(file)
}
