//! Programs that cargo builds to be tested.

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Command, Stdio};

use serde_json::Value;

/// Sources of a program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    /// Unit tests or a test folder: libtest runs it.
    Tests,
    /// A benchmark with a separate `main`, which must run without arguments.
    Bench,
}

/// A program that `cargo test` would run.
#[derive(Debug, PartialEq)]
pub(crate) struct Binary {
    /// Package and target.
    pub(crate) name: String,
    pub(crate) kind: Kind,
    pub(crate) path: PathBuf,
    /// Folder of the package, where tests run.
    pub(crate) package: PathBuf,
}

/// Builds the programs that `cargo test` with these arguments would run.
///
/// Returns `None`, and prints why, if one does not compile.
pub(crate) fn build(mut cargo: Command, arguments: &[&str]) -> Option<Vec<Binary>> {
    cargo
        .arg("test")
        .args(arguments)
        .args(["--no-run", "--message-format=json-render-diagnostics"])
        .stdout(Stdio::piped());
    let mut child = match cargo.spawn() {
        Ok(child) => child,
        Err(error) => {
            eprintln!("── cannot run cargo: {error}");
            return None;
        }
    };
    let mut all = Vec::new();
    if let Some(stdout) = child.stdout.take() {
        for line in BufReader::new(stdout).lines().map_while(Result::ok) {
            all.extend(binary(&line));
        }
    }
    all.sort_by(|a, b| a.name.cmp(&b.name));
    let built = child.wait().is_ok_and(|status| status.success());
    if built && all.is_empty() {
        eprintln!("── cargo names no test programs");
    }
    (built && !all.is_empty()).then_some(all)
}

/// Returns the program that a message of cargo is about, if it is to be run.
fn binary(message: &str) -> Option<Binary> {
    let message: Value = serde_json::from_str(message).ok()?;
    let is_test = message["reason"] == "compiler-artifact" && message["profile"]["test"] == true;
    let path = message["executable"].as_str().filter(|_| is_test)?;
    let package = PathBuf::from(message["manifest_path"].as_str()?);
    let package = package.parent()?.to_owned();
    let target = &message["target"];
    let kind = target["kind"][0].as_str()?;
    Some(Binary {
        name: format!(
            "{} {kind} {}",
            package.file_name()?.to_string_lossy(),
            target["name"].as_str()?
        ),
        kind: if kind == "bench" {
            Kind::Bench
        } else {
            Kind::Tests
        },
        path: path.into(),
        package,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const MESSAGE: &str = r#"{"reason":"compiler-artifact","manifest_path":"/w/crates/sprung/Cargo.toml",
        "target":{"kind":["test"],"name":"twin"},"profile":{"test":true},"executable":"/t/twin-1"}"#;

    #[test]
    fn test_programs_are_found_among_messages() {
        let found = binary(MESSAGE);
        let expected = Binary {
            name: "sprung test twin".to_owned(),
            kind: Kind::Tests,
            path: "/t/twin-1".into(),
            package: "/w/crates/sprung".into(),
        };
        assert_eq!(found, Some(expected));
        let bench = binary(&MESSAGE.replace("[\"test\"]", "[\"bench\"]"));
        assert_eq!(bench.map(|bench| bench.kind), Some(Kind::Bench));
    }

    #[test]
    fn libraries_programs_and_other_messages_are_not_run() {
        for other in [
            MESSAGE.replace("\"test\":true", "\"test\":false"),
            MESSAGE.replace("\"/t/twin-1\"", "null"),
            MESSAGE.replace("compiler-artifact", "build-finished"),
            "warning: no JSON".to_owned(),
        ] {
            assert_eq!(binary(&other), None, "{other}");
        }
    }
}
