//! `cargo xtask test`: everything that must pass, on a fresh machine.
//!
//! Installs what the tests need where it can: Chromium and libhdf5 from the distribution.

#![expect(
    clippy::print_stderr,
    reason = "a task runner talks to the person who runs it"
)]

use std::path::Path;
use std::process::{Command, ExitCode};

const USAGE: &str = "usage: cargo xtask TASK

  test     format, lints, tests, documentation: what CI runs
  browser  install the browser that the report is tested in";

fn main() -> ExitCode {
    match std::env::args().nth(1).as_deref() {
        Some("test") => test(),
        Some("browser") => {
            browser();
            ExitCode::SUCCESS
        }
        _ => {
            eprintln!("{USAGE}");
            ExitCode::from(2)
        }
    }
}

/// Runs every check, the quick ones first; stops at the first that fails.
///
/// Where libhdf5 is, all but the documentation has MATLAB 7.3 besides: nothing is compiled twice.
fn test() -> ExitCode {
    browser();
    let features = if hdf5() {
        "--features=sprung/mat73,sprung-cli/mat73"
    } else {
        "--features="
    };
    let steps: [(&str, &[&str]); 5] = [
        ("format", &["fmt", "--all", "--check"]),
        (
            "lints",
            &[
                "clippy",
                "--workspace",
                "--all-targets",
                features,
                "--",
                "--deny",
                "warnings",
            ],
        ),
        ("tests", &["test", "--workspace", "--all-targets", features]),
        (
            "examples in the documentation",
            &["test", "--workspace", "--doc", features],
        ),
        ("documentation", &["doc", "--workspace", "--no-deps"]),
    ];
    for (name, arguments) in steps {
        eprintln!("── {name}: cargo {}", arguments.join(" "));
        let status = Command::new(env!("CARGO"))
            .args(arguments)
            .env("RUSTDOCFLAGS", "--deny warnings")
            .status();
        match status {
            Ok(status) if status.success() => {}
            Ok(_) => {
                eprintln!("── {name}: failed");
                return ExitCode::FAILURE;
            }
            Err(error) => {
                eprintln!("── {name}: cannot run cargo: {error}");
                return ExitCode::FAILURE;
            }
        }
    }
    eprintln!("── all passed");
    ExitCode::SUCCESS
}

/// Installs Chromium where the machine is a Debian and we may.
fn browser() {
    if [
        "/usr/bin/chromium",
        "/usr/bin/chromium-browser",
        "/usr/bin/google-chrome",
    ]
    .iter()
    .any(|path| Path::new(path).exists())
    {
        return;
    }
    eprintln!("── installing Chromium, to test the report in");
    if !installed("chromium") {
        eprintln!("── Chromium could not be installed: the browser test will be skipped");
    }
}

/// Installs libhdf5 where the machine is a Debian and we may; returns whether it is there.
fn hdf5() -> bool {
    let is_there = || {
        std::env::var_os("HDF5_DIR").is_some()
            || ["/usr/include/hdf5/serial/hdf5.h", "/usr/include/hdf5.h"]
                .iter()
                .any(|path| Path::new(path).exists())
    };
    if is_there() {
        return true;
    }
    eprintln!("── installing libhdf5, to read MATLAB 7.3 with");
    if installed("libhdf5-dev pkg-config") && is_there() {
        return true;
    }
    eprintln!("── libhdf5 could not be installed: MATLAB 7.3 will not be tested");
    false
}

/// Installs packages of a Debian; returns whether that went well.
fn installed(packages: &str) -> bool {
    let install = format!(
        "apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq \
         --no-install-recommends {packages} >/dev/null"
    );
    let done = Command::new("sh").args(["-c", &install]).status();
    done.is_ok_and(|status| status.success())
}
