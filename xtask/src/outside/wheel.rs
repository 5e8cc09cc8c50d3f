//! The wheel for Python: built, installed, and tested with the packages that its users have.

use std::path::PathBuf;
use std::process::{Command, ExitCode};

use super::python::Python;
use super::pythons;
use crate::dist::licences;
use crate::files;
use crate::install::hdf5;
use crate::root;
use crate::steps::{said, succeeds};
use crate::target;
use crate::test::features;

/// What pip installs to build the wheel, and to link it for older systems.
const BUILDERS: &str = "maturin ziglang";

/// The oldest C library that the wheel runs with: that of Rust's standard library.
const OLDEST: &str = "manylinux_2_17";

/// Folder of the crate.
pub(super) const CRATE: &str = "crates/sprung-python";

/// Purpose of a wheel.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum For {
    /// Tests on this machine: with the compiled crates of `cargo xtask test`.
    Tests,
    /// Figures on this machine: optimised as for users.
    Figures,
    /// Users, also those with an old C library: Zig links the wheel on Linux.
    Users,
}

/// Builds the wheel for all systems and prints its path.
pub(crate) fn build() -> ExitCode {
    let built = Python::with(BUILDERS).and_then(|python| wheel(&python, For::Users));
    match built {
        Some(path) => {
            println!("{}", path.display());
            ExitCode::SUCCESS
        }
        None => ExitCode::FAILURE,
    }
}

/// Builds the wheel; returns its path.
fn wheel(python: &Python, purpose: For) -> Option<PathBuf> {
    let text = said("licences", licences::text("sprung-python"))?;
    files::write(&root().join(CRATE).join(licences::FILE), &text)?;
    let folder = target().join("wheels");
    // An older wheel would be found beside the new one.
    let _ = std::fs::remove_dir_all(&folder);
    let profile = match purpose {
        For::Tests => "dev",
        For::Figures | For::Users => "release",
    };
    let build = ["build", "--profile", profile, "--locked", "--quiet"];
    let mut command = python.module("maturin", &build);
    if purpose == For::Tests {
        // As `cargo xtask test`, whose crates serve again. Arguments replace the features of `pyproject.toml`.
        command
            .env("CARGO_INCREMENTAL", "0")
            .args(["--features=pyo3/extension-module", features(hdf5())])
            .arg("--auditwheel=skip");
    }
    command
        .arg("--manifest-path")
        .arg(root().join(CRATE).join("Cargo.toml"));
    if cfg!(target_os = "linux") && purpose == For::Users {
        command.args(["--zig", "--compatibility", OLDEST]);
        // Else maturin looks for zig in the first Python of PATH.
        command.env("CARGO_ZIGBUILD_PYTHON_PATH", python.program());
    }
    succeeds(command.arg("--out").arg(&folder))?;
    let found = std::fs::read_dir(&folder).ok()?.filter_map(Result::ok);
    let mut wheels = found
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "whl"));
    wheels.next()
}

/// Builds and installs the wheel; returns its path.
pub(crate) fn install(python: &Python, purpose: For) -> Option<PathBuf> {
    let wheel = wheel(python, purpose)?;
    let options = ["install", "--quiet", "--force-reinstall", "--no-deps"];
    succeeds(python.module("pip", &options).arg(&wheel))?;
    let size = std::fs::metadata(&wheel).ok()?.len();
    println!("{}: {:.1} MB", wheel.display(), size as f64 / 1e6);
    Some(wheel)
}

/// Builds the wheel for all systems and tests it in every supported Python that is found.
pub(crate) fn in_all_pythons() -> Option<()> {
    let python = Python::with(&format!("{BUILDERS} pip vermin abi3audit"))?;
    pythons::check(&python, &wheel(&python, For::Users)?)
}

/// Runs the tests of the package: types, examples, tests.
pub(super) fn check(python: &Python) -> Option<()> {
    install(python, For::Tests)?;
    let package = root().join(CRATE);
    let run = |command: &mut Command| succeeds(command.current_dir(&package));
    // The command that pip installs, in a folder without the sources.
    let folder = python.folder.join("wheel");
    std::fs::create_dir_all(&folder).ok()?;
    let sprung = python.script("sprung");
    succeeds(Command::new(&sprung).arg("--version").current_dir(&folder))?;
    let demo = ["demo", "--quiet", "--out", "demo"];
    succeeds(Command::new(&sprung).args(demo).current_dir(&folder))?;
    run(python
        .module("mypy", &["--strict", "python/sprung", "tests"])
        .env("MYPYPATH", "python"))?;
    let quiet = ["-q", "-p", "no:cacheprovider"];
    let doctests = ["--doctest-modules", "--pyargs", "sprung"];
    succeeds(
        python
            .module("pytest", &quiet)
            .args(doctests)
            .current_dir(&folder),
    )?;
    let two_at_a_time = ["-n", "2", "tests"];
    run(&mut python.module("pytest", &[&quiet[..], &two_at_a_time].concat()))?;
    python.run("benches/notebooks/run.py", &[""; 0])?;
    // It prints figures; the tests above have the limit on memory.
    python.run("benches/python/overhead.py", &[""; 0])
}
