//! Releases: an archive and a Debian package, each installed into an empty folder and run.

mod files;
pub(crate) mod licences;
mod packages;
mod try_out;

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use crate::run::Outcome;
use crate::steps::{Steps, exit_code, said};
use crate::{deny, root, summary};

/// A failed step, in words.
type Done<T> = Result<T, String>;

/// A release.
struct Release {
    version: String,
    /// Platform, as the compiler names it.
    target: String,
    /// The stripped program.
    binary: PathBuf,
    /// Time of all files, s since 1970.
    time: u64,
    /// Folder of the packages.
    out: PathBuf,
}

/// Makes the packages in `target/dist` and tries them.
///
/// - `binary`: a program to be packaged; without it, a release is built.
pub(crate) fn run(binary: Option<&str>) -> ExitCode {
    let mut steps = Steps::default();
    let Some(out) = said("dist", canonical(&root())) else {
        return ExitCode::FAILURE;
    };
    let out = out.join("target/dist");
    steps.step("dependencies", "licences, sources, advisories", deny::check);
    let ready = steps.step("folder", "target/dist", || {
        said("folder", packages::emptied(&out))
    });
    let built = ready.and_then(|()| {
        steps.step("release", "the stripped program", || {
            said(
                "release",
                binary.map_or_else(|| build(&out), |given| stripped(Path::new(given), &out)),
            )
        })
    });
    let release = built.and_then(|binary| {
        steps.step("paths", "no path of this machine in the program", || {
            said(
                "paths",
                without_paths(&binary).and_then(|()| release(binary, &out)),
            )
        })
    });
    let packed = release.and_then(|release| {
        let archive = steps.step("archive", "the same bytes twice", || {
            said("archive", packages::twice(&release, packages::archive))
        })?;
        let debian = steps.step("package", "a Debian package, the same bytes twice", || {
            said("package", packages::twice(&release, packages::debian))
        })?;
        Some((release, archive, debian))
    });
    if let Some((release, archive, debian)) = &packed {
        for (name, package) in [("archive runs", archive), ("package runs", debian)] {
            steps.step(name, "installed into an empty folder", || {
                said(name, try_out::run(release, package))
            });
        }
    }
    exit_code(summary::print(&steps, &Outcome::default()))
}

/// Runs a command and returns its output.
fn output(command: &mut Command) -> Done<String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command
        .output()
        .map_err(|error| format!("cannot run {name}: {error}"))?;
    if !output.status.success() {
        let errors = String::from_utf8_lossy(&output.stderr);
        return Err(format!(
            "{name} failed ({}): {}",
            output.status,
            errors.trim()
        ));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Builds the program without paths of this machine and without symbols.
fn build(out: &Path) -> Done<PathBuf> {
    let root = canonical(&root())?;
    let home = cargo_home()?;
    let map = |option: &str| {
        format!(
            "{option}{}=/sprung {option}{}=/cargo",
            root.display(),
            home.display()
        )
    };
    // A separate folder, because other flags would rebuild all crates in the usual one.
    let folder = root.join("target/release-dist");
    let status = Command::new(env!("CARGO"))
        .current_dir(&root)
        .args([
            "build",
            "--profile=dist",
            "--locked",
            "--package=sprung-cli",
        ])
        .env("CARGO_TARGET_DIR", &folder)
        .env("RUSTFLAGS", map("--remap-path-prefix="))
        .env("CFLAGS", map("-ffile-prefix-map="))
        .status();
    match status {
        Ok(status) if status.success() => copied(&folder.join("dist/sprung"), out),
        _ => Err("the program does not compile".to_owned()),
    }
}

/// Copies a given program without its symbols.
fn stripped(given: &Path, out: &Path) -> Done<PathBuf> {
    let binary = copied(given, out)?;
    output(Command::new("strip").arg(&binary))?;
    Ok(binary)
}

fn copied(from: &Path, out: &Path) -> Done<PathBuf> {
    let to = out.join("sprung");
    std::fs::copy(from, &to).map_err(|error| format!("cannot copy {}: {error}", from.display()))?;
    Ok(to)
}

fn canonical(path: &Path) -> Done<PathBuf> {
    path.canonicalize()
        .map_err(|error| format!("{}: {error}", path.display()))
}

fn cargo_home() -> Done<PathBuf> {
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let usual = || Some(PathBuf::from(std::env::var_os("HOME")?).join(".cargo"));
    let home = home.or_else(usual).ok_or("HOME is not set")?;
    canonical(&home)
}

/// Checks that the program names no folder of this machine, because such a program differs from machine to machine.
fn without_paths(binary: &Path) -> Done<()> {
    let bytes =
        std::fs::read(binary).map_err(|error| format!("cannot read the program: {error}"))?;
    for folder in [canonical(&root())?, cargo_home()?] {
        let text = folder.display().to_string();
        if let Some(at) = files::find(&bytes, text.as_bytes()) {
            let end = bytes.len().min(at + 100);
            let found = String::from_utf8_lossy(&bytes[at..end]);
            return Err(format!(
                "the program contains a path of this machine: {found:?}"
            ));
        }
    }
    Ok(())
}

/// Returns the version, platform and time of a release.
fn release(binary: PathBuf, out: &Path) -> Done<Release> {
    let said = output(Command::new(&binary).arg("--version"))?;
    let version = said
        .split_whitespace()
        .nth(1)
        .ok_or("the program has no version")?;
    let rustc = output(Command::new("rustc").arg("-vV"))?;
    let target = (rustc.lines().find_map(|line| line.strip_prefix("host: ")))
        .ok_or("rustc names no platform")?;
    let time = match std::env::var("SOURCE_DATE_EPOCH") {
        Ok(time) => time,
        Err(_) => {
            output(
                Command::new("git")
                    .current_dir(root())
                    .args(["log", "-1", "--format=%ct"]),
            )?
        }
    };
    Ok(Release {
        version: version.to_owned(),
        target: target.to_owned(),
        binary,
        time: time
            .trim()
            .parse()
            .map_err(|_| format!("{time:?} is no time"))?,
        out: out.to_owned(),
    })
}
