//! Licences, sources and advisories of the dependencies.

use std::process::Command;

use crate::install::tool;
use crate::root;
use crate::steps::succeeds;

/// The version of cargo-deny that is installed where none is.
const CARGO_DENY: &str = "0.20.2";

/// Workspaces; the fuzz targets have one of their own.
const WORKSPACES: [&str; 2] = ["Cargo.toml", "fuzz/Cargo.toml"];

/// Checks the dependencies of all workspaces by `deny.toml`, with all features.
///
/// The database of advisories comes from the network; where it cannot be reached, its check is named as skipped.
pub(crate) fn check() -> Option<()> {
    tool("cargo-deny", CARGO_DENY).then_some(())?;
    let has_advisories = succeeds(&mut deny(WORKSPACES[0], &["fetch", "db"])).is_some();
    let mut fine = Some(());
    for workspace in WORKSPACES {
        println!("── {workspace}");
        let mut words = vec![
            "check",
            "--hide-inclusion-graph",
            "licenses",
            "bans",
            "sources",
        ];
        if has_advisories {
            words.push("advisories");
        }
        if succeeds(&mut deny(workspace, &words)).is_none() {
            fine = None;
        }
    }
    if !has_advisories {
        println!("SKIPPED advisories: their database cannot be reached");
    }
    fine
}

fn deny(workspace: &str, words: &[&str]) -> Command {
    let mut command = Command::new("cargo-deny");
    command
        .args(["--all-features", "--config", "deny.toml"])
        .args(["--manifest-path", workspace])
        .args(words)
        .current_dir(root());
    command
}
