//! Results that are complete or not there.

use std::io::Write;
use std::path::{Path, PathBuf};

use sprung::session::{Session, Switch, finish};
use tempfile::NamedTempFile;

use crate::args::Common;
use crate::exit_code::{ExitCode, Failure};
use crate::switch::decide;

/// How the names of files begin and end that are not yet results.
const TEMPORARY: (&str, &str) = (".sprung-", ".part");

/// Returns the folder for results of a command.
pub(crate) fn results_folder(session: &Session, common: &Common) -> PathBuf {
    (common.out.clone()).unwrap_or_else(|| session.results_folder())
}

/// Files of one run: written beside their place, then renamed together, so
/// that earlier results stay whole if anything fails. A kill between the renames leaves a list of
/// them, with which the next command goes on.
pub(crate) struct Output {
    folder: PathBuf,
    // Files that were read and must stay.
    inputs: Vec<PathBuf>,
    files: Vec<(PathBuf, NamedTempFile)>,
    // Files of earlier runs that go when these come.
    outdated: Vec<PathBuf>,
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
        finish(folder)?;
        clear(folder);
        Ok(Self {
            folder: folder.to_owned(),
            inputs: Vec::new(),
            files: Vec::new(),
            outdated: Vec::new(),
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

    /// Says that a file of an earlier run goes when these come, if it is there and no input;
    /// returns whether it does.
    pub(crate) fn outdates(&mut self, name: &str) -> bool {
        let path = self.folder.join(name);
        let goes = (path.canonicalize()).is_ok_and(|path| !self.inputs.contains(&path));
        if goes {
            self.outdated.push(path);
        }
        goes
    }

    /// Puts all files in their places.
    pub(crate) fn commit(self) -> Result<(), Failure> {
        for (path, file) in &self.files {
            let synced = file.as_file().sync_all();
            synced.map_err(|error| cannot_write(path, &error))?;
            if path.is_dir() {
                let error = std::io::Error::from(std::io::ErrorKind::IsADirectory);
                return Err(cannot_write(path, &error));
            }
        }
        if self.files.len() > 1 || !self.outdated.is_empty() {
            return self.switch();
        }
        for (path, file) in self.files {
            (file.persist(&path)).map_err(|error| cannot_write(&path, &error.error))?;
        }
        Ok(())
    }

    /// Puts several files in their places.
    fn switch(self) -> Result<(), Failure> {
        let name = |path: &Path| -> Result<String, Failure> {
            (path.file_name().and_then(|name| name.to_str()))
                .map(str::to_owned)
                .ok_or_else(|| cannot_write(path, &"its name is not Unicode"))
        };
        // Who waits for the file that was written first finds the others.
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
        // Locked until they are in their places.
        let mut files = Vec::new();
        for (path, file) in self.files {
            files.push((file.keep()).map_err(|error| cannot_write(&path, &error.error))?);
        }
        Ok(switch.carry_out(&self.folder, &list)?)
    }
}

fn cannot_write(path: &Path, error: &dyn std::fmt::Display) -> Failure {
    Failure::new(
        ExitCode::File,
        format!("cannot write {}: {error}", path.display()),
    )
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
