//! Tasks of the project: tests, pages and figures of the documentation, fuzzing, installation of programs for
//! the tests.

#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a task runner talks to the person who runs it"
)]

mod binaries;
mod deny;
mod dist;
mod docs;
mod figures;
mod files;
mod fuzz;
mod install;
mod outside;
#[cfg(test)]
mod pages;
mod publication;
mod run;
mod steps;
mod summary;
mod test;

use std::path::PathBuf;
use std::process::ExitCode;

const USAGE: &str = "usage: cargo xtask TASK

  test          format, tests, and beside them what `test compiled` checks: CI without foreign programs
  test compiled lints, documentation and its examples, features of the library
  test quick    the tests of the library alone: unit tests, laws of physics, formats of logs, check, session,
                architecture; leaves out the digital twin, the command line, documentation, lints, features
  test outside [STEP…]
                comparisons with foreign programs, installed with pip into target/outside, or with apt; all
                or some of these steps: STEPS
  dist [BINARY] builds a release in target/dist: an archive and a Debian package, each installed into an empty
                folder and run; with BINARY, packages this program instead of building one
  deny          checks licences, sources and advisories of the dependencies; `dist` does it too
  wheel [pythons]
                builds the wheel for Python into target/wheels; with `pythons`, tests it in each supported Python that is
                found
  docs          writes the pages of the documentation that come from the program, figures and drawings of all pages, and the
                version and the values of publication.toml into all files that name them
  figures [--accept] [PART…]
                measures the figures of the documentation, all or some of these parts: PARTS;
                fails if one is worse than before by more than its scatter; --accept stores it nevertheless
  gallery [FOLDER [BINARY]]
                makes the gallery of machines from the logs in FOLDER, with BINARY or a new build; without FOLDER,
                draws it and the figures of all pages from the stored values
  browser       installs the browser that the report is tested in
  fuzz [SECONDS [TARGET…]]
                feeds damaged files to every reader, or to some, each for so long [120]";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["test"] => test::everything(),
        ["test", "compiled"] => test::compiled(),
        ["test", "quick"] => test::quick(),
        ["test", "outside", steps @ ..] => outside::run(steps),
        ["dist"] => dist::run(None),
        ["dist", binary] => dist::run(Some(binary)),
        ["deny"] if deny::check().is_some() => ExitCode::SUCCESS,
        ["wheel"] => outside::wheel::build(),
        ["wheel", "pythons"] if outside::wheel::in_all_pythons().is_some() => ExitCode::SUCCESS,
        ["docs"] => docs::write(),
        ["figures", words @ ..] => figures::run(words),
        ["gallery", words @ ..] if words.len() <= 2 => figures::gallery(words),
        ["browser"] if install::browser() => ExitCode::SUCCESS,
        ["deny" | "browser"] | ["wheel", "pythons"] => ExitCode::FAILURE,
        ["fuzz"] => fuzz::run("120", &[]),
        ["fuzz", seconds, targets @ ..] => fuzz::run(seconds, targets),
        _ => {
            let usage = (USAGE.replace("STEPS", &outside::names().join(", ")))
                .replace("PARTS", &figures::names().join(", "));
            eprintln!("{usage}");
            ExitCode::from(2)
        }
    }
}

/// Returns the folder of the workspace.
fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Returns the folder where cargo builds.
fn target() -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR");
    target.map_or_else(|| root().join("target"), PathBuf::from)
}
