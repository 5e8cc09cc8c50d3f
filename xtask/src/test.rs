//! `cargo xtask test`: what must pass, on a fresh machine.

use std::process::ExitCode;

use crate::binaries::build;
use crate::install::{CMAKE, browser, builds_hdf5, hdf5};
use crate::run::Outcome;
use crate::steps::Steps;
use crate::summary;

/// Features of the whole workspace where libhdf5 is, so that nothing is compiled twice.
const WITH_HDF5: &str = "--features=sprung/mat73,sprung-cli/mat73";
const WITHOUT_HDF5: &str = "--features=";

/// Test folders of the inner loop: those of `sprung-core` and `sprung` without the digital twin.
const QUICK: [&str; 7] = [
    "golden",
    "no_alloc",
    "physics",
    "architecture",
    "check",
    "formats",
    "session",
];

/// Runs every check, the quick ones first; stops at the first step that fails.
pub(crate) fn everything() -> ExitCode {
    browser();
    let has_hdf5 = hdf5();
    let features = features(has_hdf5);
    let mut steps = Steps::default();
    steps.cargo("format", &["fmt", "--all", "--check"]);
    let lints = ["clippy", "--workspace", "--all-targets", features];
    steps.cargo("lints", &[&lints[..], &["--", "--deny=warnings"]].concat());
    let outcome = tests(&mut steps, &["--workspace", "--all-targets", features]);
    steps.cargo(
        "examples in the documentation",
        &["test", "--workspace", "--doc", features],
    );
    steps.cargo("documentation", &["doc", "--workspace", "--no-deps"]);
    features_compile(&mut steps, has_hdf5);
    finish(&steps, &outcome)
}

/// Runs the unit tests and the test folders of [`QUICK`].
pub(crate) fn quick() -> ExitCode {
    let mut arguments = vec!["--workspace", "--lib", features(hdf5())];
    arguments.extend(QUICK.iter().flat_map(|name| ["--test", name]));
    let mut steps = Steps::default();
    let outcome = tests(&mut steps, &arguments);
    finish(&steps, &outcome)
}

/// Returns the features that everything is built with.
pub(crate) fn features(has_hdf5: bool) -> &'static str {
    if has_hdf5 { WITH_HDF5 } else { WITHOUT_HDF5 }
}

/// Builds the test programs that cargo's arguments name, and runs them.
fn tests(steps: &mut Steps, arguments: &[&str]) -> Outcome {
    let what = format!("cargo test {} --no-run", arguments.join(" "));
    let Some(binaries) = steps.step("build", &what, || build(arguments)) else {
        return Outcome::default();
    };
    let mut outcome = Outcome::default();
    let what = format!("{} programs", binaries.len());
    steps.step("tests", &what, || {
        outcome = Outcome::of(&binaries);
        outcome.failed.is_empty().then_some(())
    });
    outcome
}

/// Checks that the library compiles without features, with each alone and with all that build here.
fn features_compile(steps: &mut Steps, has_hdf5: bool) {
    let mut sets = vec!["", "arrow", "mcap", "db3"];
    if has_hdf5 {
        sets.extend(["mat73", "arrow,db3,mcap,mat73"]);
    }
    if builds_hdf5() {
        sets.push("mat73-static");
    } else {
        let (major, minor) = CMAKE;
        eprintln!("── mat73-static is not checked: it needs CMake {major}.{minor} or newer");
    }
    for set in sets {
        let name = match set {
            "" => "no features",
            set => set,
        };
        let library = ["clippy", "--package=sprung", "--no-default-features"];
        let flags = ["--features", set, "--", "--deny=warnings"];
        steps.cargo(name, &[&library[..], &flags].concat());
    }
}

fn finish(steps: &Steps, outcome: &Outcome) -> ExitCode {
    if summary::print(steps, outcome) {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}
