//! A Python with the packages of a step, in a virtual environment.

use std::ffi::OsStr;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::steps::{said, succeeds};
use crate::{root, target};

/// Versions of the packages that pip installs. BAM requires Python 3.12; its models run on 3.11 with an option of pip. An
/// older pip does not run in the newest Python, into which it installs.
const VERSIONS: &str = "numpy==2.4.6 scipy==1.17.1 pandas==3.1.1 pandas-stubs==3.1.0.261029 polars==2.1.0 pyarrow==26.0.1 \
    pyarrow-stubs==20.0.0.20260819 matplotlib==3.11.2 tqdm==4.70.1 types-tqdm==4.70.0.20261106 nbclient==0.11.0 \
    nbconvert==7.17.2 ipykernel==7.4.0 numba==0.68.1 pin==4.1.0 drake==1.51.1 cmeel-eigen==3.4.1 h5py==3.16.0 \
    zstandard==0.25.0 mcap==1.6.0 mcap-ros2-support==0.6.0 rosbags==0.11.9 example-robot-data==6.0.0 mujoco==4.0.0 \
    mujoco[sysid]==4.0.0 figaroh==1.0.2 better-actuator-models==1.0.2 optuna==5.0.0 cmaes==0.13.1 cmake==3.31.6 \
    mypy==2.4.1 pytest==9.2.0 pytest-xdist==3.8.0 fsspec==2026.9.0 s3fs==2026.9.0 dask[distributed]==2026.8.0 \
    ray[data]==2.60.0 moto[server]==5.2.5 duckdb==2.0.0 maturin==1.16.0 ziglang==0.17.1 pip==26.3 vermin==1.9.2 \
    abi3audit==0.0.26";

/// Returns a package with its version.
pub(crate) fn with_version(package: &str) -> &str {
    let mut all = VERSIONS.split_whitespace();
    let known = all.find(|one| one.split("==").next() == Some(package));
    known.unwrap_or(package)
}

pub(crate) struct Python {
    program: PathBuf,
    /// Folder for the files of a step.
    pub(crate) folder: PathBuf,
}

impl Python {
    /// Makes the environment if it is absent, and installs packages; without packages, it does neither.
    ///
    /// - `packages`: names with blanks between them.
    pub(crate) fn with(packages: &str) -> Option<Self> {
        let folder = target().join("outside");
        let venv = folder.join("venv");
        let program = venv.join("bin/python");
        if packages.is_empty() {
            return Some(Self { program, folder });
        }
        if !program.exists() {
            said(folder.display(), std::fs::create_dir_all(&folder))?;
            succeeds(Command::new("python3").args(["-m", "venv"]).arg(&venv))?;
        }
        let pip = [
            "-m",
            "pip",
            "install",
            "--quiet",
            "--disable-pip-version-check",
        ];
        let packages = packages.split_whitespace().map(with_version);
        let installed = succeeds(Command::new(&program).args(pip).args(packages.clone()));
        if installed.is_none() {
            let packages: Vec<&str> = packages.collect();
            eprintln!(
                "── this step needs pip, a network and {}",
                packages.join(" ")
            );
        }
        installed.map(|()| Self { program, folder })
    }

    /// Runs a script.
    ///
    /// - `script`: its path in the repository.
    pub(crate) fn run(&self, script: &str, arguments: &[impl AsRef<OsStr>]) -> Option<()> {
        succeeds(self.command(script).args(arguments))
    }

    /// Runs a script from a file to a file.
    pub(crate) fn filter(&self, script: &str, from: Option<&Path>, to: &Path) -> Option<()> {
        let input = match from {
            Some(from) => Stdio::from(said(from.display(), File::open(from))?),
            None => Stdio::null(),
        };
        let output = said(to.display(), File::create(to))?;
        succeeds(self.command(script).stdin(input).stdout(output))
    }

    /// Returns the interpreter of the environment.
    pub(crate) fn program(&self) -> &Path {
        &self.program
    }

    /// Returns a command that runs a module.
    pub(super) fn module(&self, name: &str, arguments: &[&str]) -> Command {
        let mut command = Command::new(self.program());
        command.args(["-m", name]).args(arguments);
        command
    }

    /// Returns the path of a command that pip installed.
    pub(super) fn script(&self, name: &str) -> PathBuf {
        self.program().parent().unwrap_or(Path::new("")).join(name)
    }

    fn command(&self, script: &str) -> Command {
        let mut command = Command::new(&self.program);
        command.arg(root().join(script));
        command
    }
}
