//! `cargo xtask test`: what must pass, on a fresh machine.

use std::process::ExitCode;

use crate::binaries::{Binary, build};
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

/// Runs every check, the quick ones first. After a step that fails, no later step starts.
///
/// Documentation and features compile at the same time as the tests run.
pub(crate) fn everything() -> ExitCode {
    browser();
    let has_hdf5 = hdf5();
    let features = features(has_hdf5);
    let mut steps = Steps::default();
    steps.cargo("format", &["fmt", "--all", "--check"]);
    let lints = ["clippy", "--workspace", "--all-targets", features];
    steps.cargo("lints", &[&lints[..], &["--", "--deny=warnings"]].concat());
    let tests_of = ["--workspace", "--all-targets", features];
    let binaries = binaries(&mut steps, &tests_of);
    // Tests leave a processor idle at times, and compiling a library leaves one idle at its end.
    let (outcome, compiled) = std::thread::scope(|scope| {
        let beside = scope.spawn(|| {
            let mut steps = Steps::beside(&steps);
            let examples = ["test", "--workspace", "--doc", features];
            steps.cargo("examples in the documentation", &examples);
            steps.cargo("documentation", &["doc", "--workspace", "--no-deps"]);
            features_compile(&mut steps, has_hdf5);
            steps
        });
        let mut own = Steps::beside(&steps);
        let outcome = tests(&mut own, binaries.as_deref());
        (outcome, [Some(own), beside.join().ok()])
    });
    for other in compiled {
        steps.join(other);
    }
    finish(&steps, &outcome)
}

/// Runs the unit tests and the test folders of [`QUICK`].
pub(crate) fn quick() -> ExitCode {
    let mut arguments = vec!["--workspace", "--lib", features(hdf5())];
    arguments.extend(QUICK.iter().flat_map(|name| ["--test", name]));
    let mut steps = Steps::default();
    let binaries = binaries(&mut steps, &arguments);
    let outcome = tests(&mut steps, binaries.as_deref());
    finish(&steps, &outcome)
}

/// Returns the features that everything is built with.
pub(crate) fn features(has_hdf5: bool) -> &'static str {
    if has_hdf5 { WITH_HDF5 } else { WITHOUT_HDF5 }
}

/// Builds the test programs that cargo's arguments name.
fn binaries(steps: &mut Steps, arguments: &[&str]) -> Option<Vec<Binary>> {
    let what = format!("cargo test {} --no-run", arguments.join(" "));
    steps.step("build", &what, || build(arguments))
}

/// Runs test programs; does nothing if they were not built.
fn tests(steps: &mut Steps, binaries: Option<&[Binary]>) -> Outcome {
    let mut outcome = Outcome::default();
    let Some(binaries) = binaries else {
        return outcome;
    };
    let what = format!("{} programs", binaries.len());
    steps.step("tests", &what, || {
        outcome = Outcome::of(binaries);
        outcome.failed.is_empty().then_some(())
    });
    outcome
}

/// Checks that the library compiles without features and with each alone.
///
/// The lints check all features together.
fn features_compile(steps: &mut Steps, has_hdf5: bool) {
    let mut sets = vec!["", "arrow", "mcap", "db3"];
    if has_hdf5 {
        sets.push("mat73");
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
