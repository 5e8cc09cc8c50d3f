//! The structure of the code: which module may use which, the length of files, and calls that a library must not
//! make.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod files;

use std::fs;
use std::path::{Path, PathBuf};

use files::Files;

/// Modules of `sprung` in order. A module uses only modules before it.
const ORDER: [&str; 24] = [
    "finding",
    "curves",
    "named",
    "numbers",
    "progress",
    "sha256",
    "stopwatch",
    "description",
    "model",
    "log",
    "simulate",
    "preprocess",
    "regression",
    "fit",
    "prepare",
    "frequency",
    "check",
    "estimate",
    "validate",
    "compare",
    "export",
    "servo",
    "session",
    "report",
];

/// Modules that no other module uses.
const LEAVES: [&str; 1] = ["demo"];

const LONGEST_FILE: usize = 800;

fn crates() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .unwrap()
        .to_owned()
}

/// Every Rust file below a folder, with its text.
fn sources(folder: &Path) -> Vec<(PathBuf, String)> {
    let mut all = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            all.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = fs::read_to_string(&path).unwrap();
            all.push((path, text));
        }
    }
    all
}

/// Returns the code without line comments and without the contents of plain strings.
fn code_of(text: &str) -> String {
    let mut code = String::with_capacity(text.len());
    let (mut in_string, mut before) = (false, ' ');
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        if in_string {
            if c == '\\' {
                rest.next();
            } else if c == '"' {
                in_string = false;
                code.push(c);
            }
        } else if c == '/' && rest.peek() == Some(&'/') {
            rest.by_ref().find(|&c| c == '\n');
            code.push('\n');
        } else {
            in_string = c == '"' && before != '\'';
            code.push(c);
        }
        before = c;
    }
    code
}

fn name_at(text: &str) -> &str {
    let text = text.trim_start();
    let end = text.find(|c: char| !(c.is_alphanumeric() || c == '_'));
    &text[..end.unwrap_or(text.len())]
}

/// Returns whether a module may use another.
fn may_use(module: &str, other: &str) -> bool {
    let place = |name: &str| ORDER.iter().position(|known| *known == name);
    match (place(module), place(other)) {
        _ if module == other => true,
        (Some(own), Some(other)) => other < own,
        (None, Some(_)) => LEAVES.contains(&module),
        _ => false,
    }
}

#[test]
fn every_module_uses_only_those_to_its_left() {
    let uses = Files::read(&crates().join("sprung/src")).uses();
    assert!(uses.len() > 200, "only {} uses were found", uses.len());
    let wrong: Vec<String> = (uses.iter())
        .filter_map(|found| Some((found, found.from.first()?, found.to.first()?)))
        .filter(|(_, from, to)| !may_use(from, to))
        .map(|(found, from, to)| {
            format!(
                "{} uses {}: {from} must not use {to}",
                found.from.join("/"),
                found.name
            )
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn no_files_use_each_other_in_a_circle() {
    let circles: Vec<String> = ["sprung-core", "sprung", "sprung-cli", "sprung-testing"]
        .iter()
        .flat_map(|name| Files::read(&crates().join(name).join("src")).circles())
        .collect();
    assert!(circles.is_empty(), "{}", circles.join("\n"));
}

#[test]
fn modules_to_the_right_are_refused() {
    assert!(may_use("validate", "log") && may_use("demo", "estimate"));
    assert!(!may_use("regression", "validate") && !may_use("log", "newcomer"));
    assert!(!may_use("newcomer", "log") && !may_use("report", "demo"));
}

#[test]
fn every_module_has_its_place() {
    let lib = fs::read_to_string(crates().join("sprung/src/lib.rs")).unwrap();
    let code = code_of(&lib);
    let mut modules: Vec<&str> = code.split("mod ").skip(1).map(name_at).collect();
    let mut known: Vec<&str> = ORDER.into_iter().chain(LEAVES).collect();
    modules.sort_unstable();
    known.sort_unstable();
    assert_eq!(modules, known);
}

#[test]
fn core_needs_no_standard_library() {
    for (path, text) in sources(&crates().join("sprung-core/src")) {
        let code = code_of(&text);
        for name in ["std::", "alloc::"] {
            let used = code
                .match_indices(name)
                .any(|(at, _)| !code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_'));
            assert!(!used, "{} uses {name}", path.display());
        }
    }
}

#[test]
fn one_place_asks_for_the_time() {
    for name in ["sprung-core", "sprung"] {
        for (path, text) in sources(&crates().join(name).join("src")) {
            let asks = ["Instant", "SystemTime"]
                .iter()
                .any(|clock| code_of(&text).contains(clock));
            assert!(
                !asks || path.ends_with("stopwatch.rs"),
                "{} asks for the time",
                path.display()
            );
        }
    }
}

#[test]
fn only_sessions_open_files() {
    let folder = crates().join("sprung/src");
    for (path, text) in sources(&folder) {
        let inside = path.strip_prefix(&folder).unwrap();
        // libhdf5 opens its files itself.
        let may = inside.starts_with("session") || inside.ends_with("mat73.rs");
        let code = code_of(&text);
        let code = code.split("#[cfg(test)]").next().unwrap();
        let opens = [
            "File::open",
            "File::create",
            "File::options",
            "std::fs::read",
            "fs::write",
        ];
        let found = opens.iter().find(|call| code.contains(**call));
        assert!(may || found.is_none(), "{} opens files", path.display());
    }
}

#[test]
fn files_are_short_and_libraries_print_nothing() {
    for name in ["sprung-core", "sprung", "sprung-cli", "sprung-testing"] {
        for (path, text) in sources(&crates().join(name).join("src")) {
            let lines = text.lines().count();
            assert!(lines <= LONGEST_FILE, "{}: {lines} lines", path.display());
            let code = code_of(&text);
            for print in ["println!", "print!", "eprintln!", "eprint!", "dbg!"] {
                let found = name != "sprung-cli" && code.contains(print);
                assert!(!found, "{} calls {print}", path.display());
            }
        }
    }
}
