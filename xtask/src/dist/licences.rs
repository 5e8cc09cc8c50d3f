//! Licences of the libraries that are compiled into the program or into the wheel.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use super::{Done, output};
use crate::root;

/// File of the licences in an archive and in the wheel.
pub(crate) const FILE: &str = "LICENSES-OF-LIBRARIES.txt";

/// Beginnings of the names of files with a licence or a notice, in capitals.
const NAMES: [&str; 5] = ["LICENSE", "LICENCE", "COPYING", "NOTICE", "UNLICENSE"];

/// The plotting library in reports.
const UPLOT: &str = "crates/sprung-report/src/assets/uplot";

/// A toolchain need not have the texts of its licences.
const RUST: &str = "\nCopyright (c) The Rust Project Contributors. The texts are those of the licences of sprung.\n";

/// Returns the names, versions and licences of the libraries in a package, and the texts of the licences.
///
/// Reports contain the plotting library, and the program contains it for them.
///
/// - `package`: of this workspace, `sprung-cli` or `sprung-python`.
pub(crate) fn text(package: &str) -> Done<String> {
    let metadata = output(Command::new(env!("CARGO")).current_dir(root()).args([
        "metadata",
        "--format-version=1",
        "--locked",
    ]))?;
    let metadata: Value = serde_json::from_str(&metadata).map_err(|error| error.to_string())?;
    let tree = output(Command::new(env!("CARGO")).current_dir(root()).args([
        "tree",
        "--locked",
        &format!("--package={package}"),
        "--edges=normal,no-proc-macro",
        "--prefix=none",
        "--format={p}",
    ]))?;
    let used: BTreeSet<(&str, &str)> = tree.lines().filter_map(name_and_version).collect();
    let mut all = String::from("Libraries in sprung, with their licences.\n");
    let packages = metadata["packages"]
        .as_array()
        .ok_or("cargo names no packages")?;
    let mut libraries: Vec<&Value> = (packages.iter())
        .filter(|package| !package["source"].is_null())
        .filter(|package| {
            let of = |key: &str| package[key].as_str().unwrap_or_default();
            used.contains(&(of("name"), of("version")))
        })
        .collect();
    libraries.sort_by_key(|package| (package["name"].as_str(), package["version"].as_str()));
    for package in libraries {
        let of = |key: &str| package[key].as_str().unwrap_or("-");
        let mut own = (Path::new(of("manifest_path")).parent()).map_or_else(Vec::new, texts);
        if own.is_empty() {
            // The package has no text: its authors are the notice.
            let authors = package["authors"].as_array().into_iter().flatten();
            let authors: Vec<&str> = authors.filter_map(Value::as_str).collect();
            own.push(format!(
                "\nby {}; {}\n",
                authors.join(", "),
                of("repository")
            ));
        }
        add(&mut all, of("name"), of("version"), of("license"), &own)?;
    }
    let uplot = root().join(UPLOT);
    let script = std::fs::read_to_string(uplot.join("uPlot.iife.min.js"))
        .map_err(|error| format!("cannot read uPlot: {error}"))?;
    let version = (script.split_once("(v"))
        .and_then(|(_, rest)| rest.split(')').next())
        .ok_or("uPlot has no version")?;
    add(&mut all, "uPlot", version, "MIT", &texts(&uplot))?;
    let rust = output(Command::new("rustc").arg("--version"))?;
    let version = rust.split_whitespace().nth(1).unwrap_or("-");
    let name = "the standard library of Rust";
    add(
        &mut all,
        name,
        version,
        "MIT OR Apache-2.0",
        &[RUST.to_owned()],
    )?;
    Ok(all)
}

/// Adds a library.
fn add(all: &mut String, name: &str, version: &str, licence: &str, texts: &[String]) -> Done<()> {
    write!(all, "\n=== {name} {version}: {licence}\n").map_err(|error| error.to_string())?;
    all.extend(texts.iter().map(String::as_str));
    Ok(())
}

/// Returns the name and the version on a line of `cargo tree`.
fn name_and_version(line: &str) -> Option<(&str, &str)> {
    let mut words = line.split_whitespace();
    Some((words.next()?, words.next()?.strip_prefix('v')?))
}

/// Returns the texts of the licences in the folder of a library and in those below, in the order of their paths.
///
/// Crates that compile a library in C have its licence in a folder of its own.
fn texts(folder: &Path) -> Vec<String> {
    let mut files = Vec::new();
    licence_files(folder, DEEPEST, &mut files);
    files.sort();
    let mut texts: Vec<String> = Vec::new();
    for bytes in files.iter().filter_map(|path| std::fs::read(path).ok()) {
        let text = format!("\n{}\n", String::from_utf8_lossy(&bytes).trim_end());
        if !texts.contains(&text) {
            texts.push(text);
        }
    }
    texts
}

/// How deep the licences of libraries in C are.
const DEEPEST: usize = 2;

/// Folders that are not compiled.
const NOT_COMPILED: [&str; 4] = ["tests", "benches", "examples", "contrib"];

fn licence_files(folder: &Path, deeper: usize, files: &mut Vec<PathBuf>) {
    for entry in (std::fs::read_dir(folder).into_iter().flatten()).filter_map(Result::ok) {
        let path = entry.path();
        let name = entry.file_name().to_string_lossy().to_uppercase();
        let is_code = (path.extension())
            .is_some_and(|end| ["rs", "py", "json"].map(Some).contains(&end.to_str()));
        if path.is_dir() {
            let is_compiled = !NOT_COMPILED
                .iter()
                .any(|other| name == other.to_uppercase());
            if deeper > 0 && is_compiled {
                licence_files(&path, deeper - 1, files);
            }
        } else if !is_code && NAMES.iter().any(|start| name.starts_with(start)) {
            files.push(path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{name_and_version, text};

    #[test]
    fn libraries_in_c_and_in_reports_have_their_licences() {
        let all = [text("sprung-cli").unwrap(), text("sprung-python").unwrap()].concat();
        for part in [
            "=== uPlot 1.6",
            "Leon Sorokin",
            "=== zstd-sys ",
            "Meta Platforms",
            "=== lz4-sys ",
            "Yann Collet",
            "=== libsqlite3-sys ",
            "=== the standard library of Rust 1.",
        ] {
            assert!(all.contains(part), "{part}");
        }
        // No macro is in the program, and the wheel has more libraries.
        assert!(!all.contains("=== serde_derive "));
        let wheel = text("sprung-python").unwrap();
        assert!(wheel.contains("=== pyo3 ") && wheel.contains("=== clap "));
    }

    #[test]
    fn lines_of_the_tree_are_read() {
        assert_eq!(name_and_version("csv v1.4.0"), Some(("csv", "1.4.0")));
        assert_eq!(
            name_and_version("sprung v0.1.0 (/w/crates/sprung) (*)"),
            Some(("sprung", "0.1.0"))
        );
        assert_eq!(name_and_version(""), None);
    }
}
