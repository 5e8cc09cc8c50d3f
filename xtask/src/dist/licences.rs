//! Licences of the libraries that are compiled into the program.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use super::{Done, output};
use crate::root;

/// Beginnings of the names of files with a licence or a notice, in capitals.
const NAMES: [&str; 5] = ["LICENSE", "LICENCE", "COPYING", "NOTICE", "UNLICENSE"];

/// Returns the names, versions and licences of the libraries, and the texts of the licences.
pub(super) fn text() -> Done<String> {
    let metadata = output(Command::new(env!("CARGO")).current_dir(root()).args([
        "metadata",
        "--format-version=1",
        "--locked",
    ]))?;
    let metadata: Value = serde_json::from_str(&metadata).map_err(|error| error.to_string())?;
    let tree = output(Command::new(env!("CARGO")).current_dir(root()).args([
        "tree",
        "--locked",
        "--package=sprung-cli",
        "--edges=normal",
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
        let (name, version) = (of("name"), of("version"));
        write!(all, "\n=== {name} {version}: {}\n", of("license"))
            .map_err(|error| error.to_string())?;
        let folder = Path::new(of("manifest_path")).parent();
        for text in folder.map(texts).unwrap_or_default() {
            all.push_str(&text);
        }
    }
    Ok(all)
}

/// Returns the name and the version on a line of `cargo tree`.
fn name_and_version(line: &str) -> Option<(&str, &str)> {
    let mut words = line.split_whitespace();
    Some((words.next()?, words.next()?.strip_prefix('v')?))
}

/// Returns the texts of the licences in the folder of a library, in the order of their names.
fn texts(folder: &Path) -> Vec<String> {
    let mut files: Vec<_> = (std::fs::read_dir(folder).into_iter().flatten())
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| {
            let name = path
                .file_name()
                .unwrap_or_default()
                .to_string_lossy()
                .to_uppercase();
            path.is_file() && NAMES.iter().any(|start| name.starts_with(start))
        })
        .collect();
    files.sort();
    (files.iter())
        .filter_map(|path| std::fs::read(path).ok())
        .map(|bytes| format!("\n{}\n", String::from_utf8_lossy(&bytes).trim_end()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::name_and_version;

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
