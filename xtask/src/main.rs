//! `cargo xtask test`: everything that must pass, on a fresh machine.
//!
//! Installs what the tests need where it can: Chromium from the distribution.

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
fn test() -> ExitCode {
    browser();
    let steps: [(&str, &[&str]); 5] = [
        ("format", &["fmt", "--all", "--check"]),
        (
            "lints",
            &[
                "clippy",
                "--workspace",
                "--all-targets",
                "--",
                "--deny",
                "warnings",
            ],
        ),
        ("tests", &["test", "--workspace", "--all-targets"]),
        (
            "examples in the documentation",
            &["test", "--workspace", "--doc"],
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
    let install = "apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq \
                   --no-install-recommends chromium >/dev/null";
    let done = Command::new("sh").args(["-c", install]).status();
    if !done.is_ok_and(|status| status.success()) {
        eprintln!("── Chromium could not be installed: the browser test will be skipped");
    }
}
