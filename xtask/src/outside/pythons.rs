//! The wheel in every supported Python of this machine.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::python::{Python, with_version};
use crate::root;
use crate::steps::succeeds;

/// Minor versions of Python 3 that the wheel supports; the first one is that of `requires-python`.
const SUPPORTED: std::ops::RangeInclusive<u32> = 10..=15;

/// The oldest NumPy that the wheel admits, and the last Python that it supports.
const OLDEST_NUMPY: (&str, u32) = ("numpy==1.26.4", 12);

/// Tests that need neither data frames nor plots.
const TESTS: [&str; 4] = [
    "tests/test_bad_input.py",
    "tests/test_model.py",
    "tests/test_objects.py",
    "tests/test_score.py",
];

/// Variable with a folder of further interpreters, such as `python3.15`.
const FOLDER: &str = "SPRUNG_PYTHONS";

/// Checks that the wheel needs nothing newer than the oldest supported Python, and tests it in each one that is found.
///
/// An interpreter that is absent is named as skipped.
pub(super) fn check(python: &Python, wheel: &Path) -> Option<()> {
    let oldest = format!("--target=3.{}-", SUPPORTED.start());
    let sources = root().join(super::wheel::CRATE).join("python/sprung");
    let words = ["--violations", "--no-tips", &oldest];
    succeeds(
        Command::new(python.script("vermin"))
            .args(words)
            .arg(sources),
    )?;
    succeeds(
        Command::new(python.script("abi3audit"))
            .args(["--strict", "--summary"])
            .arg(wheel),
    )?;
    let mut fine = Some(());
    for minor in SUPPORTED {
        let name = format!("python3.{minor}");
        let Some(program) = found(&name) else {
            println!("SKIPPED {name}: it is neither in PATH nor in the folder {FOLDER}");
            continue;
        };
        println!("── {name}: {}", program.display());
        if tested(python, wheel, minor, &program).is_none() {
            eprintln!("── the wheel fails in {name}");
            fine = None;
        }
    }
    fine
}

/// Returns the path of an interpreter.
fn found(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let more = std::env::var_os(FOLDER).map(PathBuf::from);
    let mut folders = more.into_iter().chain(std::env::split_paths(&path));
    folders.find_map(|folder| Some(folder.join(name)).filter(|program| program.is_file()))
}

/// Installs the wheel into an empty environment, and runs the command and the tests there.
fn tested(python: &Python, wheel: &Path, minor: u32, program: &Path) -> Option<()> {
    let folder = python.folder.join(format!("python3.{minor}"));
    let _ = std::fs::remove_dir_all(&folder);
    let venv = folder.join("venv");
    // Not every interpreter has a pip; that of the step installs into all.
    let make = ["-m", "venv", "--without-pip"];
    succeeds(Command::new(program).args(make).arg(&venv))?;
    let inside = venv.join("bin/python");
    let numpy = if minor <= OLDEST_NUMPY.1 {
        OLDEST_NUMPY.0
    } else {
        "numpy"
    };
    let mut pip = python.module("pip", &["--python"]);
    pip.arg(&inside)
        .args([
            "install",
            "--quiet",
            "--disable-pip-version-check",
            "--only-binary=:all:",
        ])
        .args([numpy, with_version("pytest")])
        .arg(wheel);
    succeeds(&mut pip)?;
    let demo = ["demo", "--quiet", "--out", "demo"];
    succeeds(
        Command::new(venv.join("bin/sprung"))
            .args(demo)
            .current_dir(&folder),
    )?;
    let pytest = ["-m", "pytest", "-q", "-p", "no:cacheprovider"];
    let package = root().join(super::wheel::CRATE);
    succeeds(
        Command::new(&inside)
            .args(pytest)
            .args(TESTS)
            .current_dir(package),
    )
}
