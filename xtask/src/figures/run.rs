//! A run of a part: programs that note their figures.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::install::hdf5;
use crate::outside::python::Python;
use crate::steps::succeeds;
use crate::{root, target};

/// A run of a part.
pub(super) struct Run {
    pub(super) python: Python,
    /// Where benchmarks note their figures.
    pub(super) notes: PathBuf,
}

impl Run {
    /// Runs a script of the repository, with the packages of the part if it has any.
    pub(super) fn python(&self, script: &str, arguments: &[&Path]) -> Option<()> {
        let environment = self.python.program();
        let program = if environment.exists() {
            environment
        } else {
            Path::new("python3")
        };
        let mut command = self.command(program);
        succeeds(command.arg(root().join(script)).args(arguments))
    }

    /// Runs a benchmark of cargo.
    pub(super) fn bench(&self, package: &str, name: &str, arguments: &[&str]) -> Option<()> {
        let mut command = self.command(env!("CARGO"));
        let bench = ["bench", "--quiet", "-p", package, "--bench", name, "--"];
        succeeds(command.args(bench).args(arguments).current_dir(root()))
    }

    /// Runs tests of cargo, as a release.
    pub(super) fn test(&self, package: &str, folder: &str, names: &[&str]) -> Option<()> {
        let mut command = self.command(env!("CARGO"));
        let test = [
            "test",
            "--quiet",
            "--release",
            "-p",
            package,
            "--test",
            folder,
            "--",
        ];
        // One at a time, so that the figures have one order.
        command.env("RUST_TEST_THREADS", "1");
        succeeds(command.args(test).args(names).current_dir(root()))
    }

    /// Builds the program as a release, and returns its path.
    pub(super) fn sprung(&self) -> Option<PathBuf> {
        let build = ["build", "--quiet", "--release", "-p", "sprung-cli"];
        let mut command = self.command(env!("CARGO"));
        if hdf5() {
            command.args(build).arg("--features=mat73")
        } else {
            command.args(build)
        };
        succeeds(command.current_dir(root()))?;
        target().join("release/sprung").canonicalize().ok()
    }

    pub(super) fn command(&self, program: impl AsRef<std::ffi::OsStr>) -> Command {
        let mut command = Command::new(program);
        command.env("SPRUNG_FIGURES", &self.notes);
        command
    }
}

pub(super) fn foreign_logs() -> PathBuf {
    target().join("figures/foreign")
}

/// Returns the folder with the logs of real machines; `None`, and prints why, if it is absent.
pub(super) fn data() -> Option<PathBuf> {
    let folder = std::env::var_os("SPRUNG_TEST_DATA")
        .map_or_else(|| root().join("../shared"), PathBuf::from);
    let data = folder.join("data");
    if !data.is_dir() {
        eprintln!(
            "── {} is absent: SPRUNG_TEST_DATA must name the folder that holds `data` with the logs of the machines",
            data.display()
        );
        return None;
    }
    Some(data)
}
