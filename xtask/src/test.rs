//! `cargo xtask test`: all checks that must pass, on a fresh machine.

use std::process::{Command, ExitCode};

use crate::binaries::{Binary, build};
use crate::install::{browser, hdf5};
use crate::run::Outcome;
use crate::steps::{Steps, cargo, exit_code, task};
use crate::summary;

/// Features of the whole workspace where libhdf5 is, so that no crate is compiled twice.
const WITH_HDF5: &str = "--features=sprung/mat73,sprung-cli/mat73";
const WITHOUT_HDF5: &str = "--features=";

/// The package whose code depends on features: the formats of logs.
pub(crate) const FORMATS: &str = "sprung-log";
/// The library that users name, which compiles without features.
const LIBRARY: &str = "sprung";

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

/// Runs every check.
///
/// Two programs run at a time; the checks of [`compiled`] come first in one row. Only programs that a test runs are
/// built: the lints compile the benchmarks and the module for Python.
pub(crate) fn everything() -> ExitCode {
    browser();
    let features = features(hdf5());
    let mut steps = Steps::default();
    steps.cargo("format", &["fmt", "--all", "--check"]);
    let all = ["--workspace", "--tests", features];
    let binaries = binaries(&mut steps, cargo(), &all);
    let outcome = tests(&mut steps, binaries.as_deref(), || {
        let done = task(&["test", "compiled"]);
        done.is_none()
            .then(|| "cargo xtask test compiled".to_owned())
    });
    finish(&steps, &outcome)
}

/// Runs the checks that only compile: lints, examples in the documentation, the documentation, feature sets.
pub(crate) fn compiled() -> ExitCode {
    let has_hdf5 = hdf5();
    let features = features(has_hdf5);
    let mut steps = Steps::default();
    let lints = ["clippy", "--workspace", "--all-targets", features];
    steps.cargo("lints", &[&lints[..], &["--", "--deny=warnings"]].concat());
    // The metadata of the dependencies from the lints serves the documentation and the feature
    // sets.
    let documentation = ["doc", "--workspace", "--no-deps", features];
    steps.cargo("documentation", &documentation);
    let examples = ["test", "--workspace", "--doc", features];
    steps.cargo("examples in the documentation", &examples);
    features_compile(&mut steps, has_hdf5);
    finish(&steps, &Outcome::default())
}

/// Runs the unit tests and the test folders of [`QUICK`].
pub(crate) fn quick() -> ExitCode {
    let mut arguments = vec!["--workspace", "--lib", features(hdf5())];
    arguments.extend(QUICK.iter().flat_map(|name| ["--test", name]));
    let mut steps = Steps::default();
    // Cargo keeps parts of crates, so that the build after a change is short.
    let binaries = binaries(&mut steps, Command::new(env!("CARGO")), &arguments);
    let outcome = tests(&mut steps, binaries.as_deref(), || None);
    finish(&steps, &outcome)
}

/// Returns the features that everything is built with.
pub(crate) fn features(has_hdf5: bool) -> &'static str {
    if has_hdf5 { WITH_HDF5 } else { WITHOUT_HDF5 }
}

/// Builds the test programs that cargo's arguments name.
fn binaries(steps: &mut Steps, cargo: Command, arguments: &[&str]) -> Option<Vec<Binary>> {
    let what = format!("cargo test {} --no-run", arguments.join(" "));
    steps.step("build", &what, || build(cargo, arguments))
}

/// Runs test programs and, beside them, a check that returns its name if it fails; without programs the check alone.
fn tests(
    steps: &mut Steps,
    binaries: Option<&[Binary]>,
    beside: impl FnOnce() -> Option<String> + Send,
) -> Outcome {
    let mut outcome = Outcome::default();
    let binaries = binaries.unwrap_or_default();
    let what = format!("{} programs", binaries.len());
    steps.step("tests", &what, || {
        let (of_programs, failed) = Outcome::beside(binaries, beside);
        outcome = of_programs;
        outcome.failed.extend(failed);
        outcome.failed.is_empty().then_some(())
    });
    outcome
}

/// Checks that the library compiles without features, and the formats without any and with each alone.
///
/// The lints check all features together; `cargo xtask test outside` compiles libhdf5 (`mat73-static`).
fn features_compile(steps: &mut Steps, has_hdf5: bool) {
    let mut sets = vec![(LIBRARY, ""), (FORMATS, "")];
    sets.extend(["arrow", "mcap", "db3"].map(|set| (FORMATS, set)));
    if has_hdf5 {
        sets.push((FORMATS, "mat73"));
    }
    for (package, set) in sets {
        let name = match set {
            "" => format!("{package} without features"),
            set => format!("{package} with {set}"),
        };
        steps.cargo(&name, &check_of(package, set));
    }
}

/// Returns cargo's arguments that check a library with a set of features; a warning fails.
pub(crate) fn check_of<'a>(package: &'a str, set: &'a str) -> [&'a str; 11] {
    [
        "rustc",
        "--package",
        package,
        "--lib",
        "--profile=check",
        "--no-default-features",
        "--features",
        set,
        "--",
        "--deny",
        "warnings",
    ]
}

fn finish(steps: &Steps, outcome: &Outcome) -> ExitCode {
    exit_code(summary::print(steps, outcome))
}
