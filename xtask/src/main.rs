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
  browser  install the browser that the report is tested in
  fuzz [SECONDS [TARGET…]]  feed damaged files to every reader, or to some, each for so long [120]";

/// How long each fuzz target runs, s.
const FUZZING: &str = "120";

fn main() -> ExitCode {
    match std::env::args().nth(1).as_deref() {
        Some("test") => test(),
        Some("browser") => {
            browser();
            ExitCode::SUCCESS
        }
        Some("fuzz") => {
            let mut arguments = std::env::args().skip(2);
            let seconds = arguments.next().unwrap_or_else(|| FUZZING.to_owned());
            fuzz(&seconds, arguments.collect())
        }
        _ => {
            eprintln!("{USAGE}");
            ExitCode::from(2)
        }
    }
}

/// Runs fuzz targets one after another, with seeds; stops at the first that finds something.
fn fuzz(seconds: &str, chosen: Vec<String>) -> ExitCode {
    let nightly = || {
        let mut command = Command::new("rustup");
        command.args(["run", "nightly", "cargo", "fuzz"]);
        command
    };
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let seeds = Command::new(env!("CARGO"))
        .args(["test", "-p", "sprung-cli", "--test", "cli"])
        .arg("the_corpus_is_large_and_always_the_same")
        .env("SPRUNG_CORPUS", root.join("fuzz/corpus"))
        .current_dir(&root)
        .status();
    if !seeds.is_ok_and(|status| status.success()) {
        eprintln!("── no seeds could be written");
        return ExitCode::FAILURE;
    }
    let targets = if chosen.is_empty() {
        let list = nightly().arg("list").current_dir(&root).output();
        list.map_or_else(
            |_| Vec::new(),
            |list| {
                let names = String::from_utf8_lossy(&list.stdout);
                names.lines().map(str::to_owned).collect()
            },
        )
    } else {
        chosen
    };
    if targets.is_empty() {
        eprintln!("── there are no targets; install nightly with rustup, and cargo-fuzz");
        return ExitCode::FAILURE;
    }
    for target in targets {
        eprintln!("── {target}: {seconds} s");
        // Without the address sanitizer, which takes half of the time: none of our code is unsafe.
        let status = nightly()
            .args(["run", "--sanitizer", "none", &target, "--"])
            .arg(format!("-max_total_time={seconds}"))
            .args(["-timeout=10", "-rss_limit_mb=2048", "-print_final_stats=1"])
            .current_dir(&root)
            .status();
        if !status.is_ok_and(|status| status.success()) {
            eprintln!("── {target}: found something; the file is in fuzz/artifacts/{target}");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

/// Runs every check, the quick ones first; stops at the first that fails.
///
/// Where libhdf5 is, all but the documentation has MATLAB 7.3 besides: nothing is compiled twice.
fn test() -> ExitCode {
    browser();
    let has_hdf5 = hdf5();
    let features = if has_hdf5 {
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
    let passed =
        (steps.iter()).all(|(name, arguments)| step(name, arguments)) && features_compile(has_hdf5);
    if !passed {
        return ExitCode::FAILURE;
    }
    eprintln!("── all passed");
    ExitCode::SUCCESS
}

/// Runs cargo; returns whether that went well.
fn step(name: &str, arguments: &[&str]) -> bool {
    eprintln!("── {name}: cargo {}", arguments.join(" "));
    let status = Command::new(env!("CARGO"))
        .args(arguments)
        .env("RUSTDOCFLAGS", "--deny warnings")
        .status();
    match status {
        Ok(status) if status.success() => return true,
        Ok(_) => eprintln!("── {name}: failed"),
        Err(error) => eprintln!("── {name}: cannot run cargo: {error}"),
    }
    false
}

/// Checks that the library compiles without features, with each alone and with all that build here.
fn features_compile(has_hdf5: bool) -> bool {
    let mut sets = vec!["", "arrow", "mcap"];
    if has_hdf5 {
        sets.extend(["mat73", "arrow,mcap,mat73"]);
    }
    if builds_hdf5() {
        sets.push("mat73-static");
    } else {
        eprintln!(
            "── mat73-static is not checked: it takes CMake {}.{} or newer",
            CMAKE.0, CMAKE.1
        );
    }
    sets.iter().all(|set| {
        let name = match *set {
            "" => "no features",
            set => set,
        };
        step(
            name,
            &[
                "clippy",
                "--package=sprung",
                "--no-default-features",
                "--features",
                set,
                "--",
                "--deny=warnings",
            ],
        )
    })
}

/// The oldest CMake that configures the sources of libhdf5: major and minor version.
const CMAKE: (u32, u32) = (3, 26);

/// Returns whether libhdf5 can be compiled from its sources.
fn builds_hdf5() -> bool {
    let Ok(output) = Command::new("cmake").arg("--version").output() else {
        return false;
    };
    let text = String::from_utf8_lossy(&output.stdout);
    let version = text.split_whitespace().nth(2).unwrap_or_default();
    let mut parts = version.split('.').map_while(|part| part.parse().ok());
    (parts.next(), parts.next()) >= (Some(CMAKE.0), Some(CMAKE.1))
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
