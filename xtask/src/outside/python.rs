//! A Python with the packages of a step, in a virtual environment.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::root;
use crate::steps::succeeds;

pub(crate) struct Python {
    program: PathBuf,
    /// Folder for the files of a step.
    pub(crate) folder: PathBuf,
}

impl Python {
    /// Makes the environment if it is absent, and installs packages; without packages, it does neither.
    pub(crate) fn with(folder: &Path, packages: &[&str]) -> Option<Self> {
        let venv = folder.join("venv");
        let program = venv.join("bin/python");
        if packages.is_empty() {
            return Some(Self {
                program,
                folder: folder.to_owned(),
            });
        }
        if !program.exists() {
            std::fs::create_dir_all(folder)
                .inspect_err(|error| eprintln!("── cannot create {}: {error}", folder.display()))
                .ok()?;
            succeeds(Command::new("python3").args(["-m", "venv"]).arg(&venv))?;
        }
        let pip = [
            "-m",
            "pip",
            "install",
            "--quiet",
            "--disable-pip-version-check",
        ];
        let installed = succeeds(Command::new(&program).args(pip).args(packages));
        if installed.is_none() {
            eprintln!(
                "── this step needs pip, a network and {}",
                packages.join(" ")
            );
        }
        installed.map(|()| Self {
            program,
            folder: folder.to_owned(),
        })
    }

    /// Runs a script.
    ///
    /// - `script`: its path in the repository.
    pub(crate) fn run(&self, script: &str, arguments: &[&Path]) -> Option<()> {
        succeeds(self.command(script).args(arguments))
    }

    /// Runs a script from a file to a file.
    pub(crate) fn filter(&self, script: &str, from: Option<&Path>, to: &Path) -> Option<()> {
        let opened = |path: &Path, file: std::io::Result<File>| {
            file.inspect_err(|error| eprintln!("── cannot open {}: {error}", path.display()))
                .ok()
        };
        let input = match from {
            Some(from) => Stdio::from(opened(from, File::open(from))?),
            None => Stdio::null(),
        };
        let output = opened(to, File::create(to))?;
        succeeds(self.command(script).stdin(input).stdout(output))
    }

    /// Returns the interpreter of the environment.
    pub(crate) fn program(&self) -> &Path {
        &self.program
    }

    fn command(&self, script: &str) -> Command {
        let mut command = Command::new(&self.program);
        command.arg(root().join(script));
        command
    }
}
