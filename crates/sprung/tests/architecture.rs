//! The shape of the code: who may use whom, how long a file may be, and what
//! a library never does.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::fs;
use std::path::{Path, PathBuf};

/// Modules of `sprung`; each uses only those before it.
const ORDER: [&str; 16] = [
    "finding",
    "curves",
    "named",
    "description",
    "model",
    "log",
    "simulate",
    "preprocess",
    "regression",
    "fit",
    "prepare",
    "check",
    "estimate",
    "validate",
    "compare",
    "report",
];

/// Modules that no other uses.
const LEAVES: [&str; 1] = ["demo"];

const LONGEST_FILE: usize = 800;

fn crates() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
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

/// The code without line comments and without the contents of plain strings.
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

/// First names of a path's continuation: of `a::b`, or of each part of
/// `{a::b, c, d::{e, f}}`.
fn first_names(after: &str) -> Vec<&str> {
    let Some(list) = after.trim_start().strip_prefix('{') else {
        return vec![name_at(after)];
    };
    let mut names = vec![name_at(list)];
    let mut depth = 1;
    for (at, c) in list.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 1 => names.push(name_at(&list[at + 1..])),
            _ => {}
        }
        if depth == 0 {
            break;
        }
    }
    names.retain(|name| !name.is_empty());
    names
}

/// Modules of the crate that the code of a file names.
///
/// - `depth`: how many modules enclose the file's code.
fn modules_used(text: &str, depth: usize) -> Vec<String> {
    let code = code_of(text);
    let tests = code.find("#[cfg(test)]").unwrap_or(code.len());
    let mut used = Vec::new();
    let starts_word = |at: usize| !code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_');
    for (at, found) in code.match_indices("crate::") {
        if starts_word(at) {
            used.extend(first_names(&code[at + found.len()..]));
        }
    }
    for (at, _) in code.match_indices("super::") {
        if !starts_word(at) || code[..at].ends_with("super::") {
            continue;
        }
        let chain = code[at..].split("super::").take_while(|s| s.is_empty());
        let ups = chain.count();
        // A module of tests is one level deeper than its file.
        if ups >= depth + usize::from(at > tests) {
            used.extend(first_names(&code[at + ups * "super::".len()..]));
        }
    }
    used.iter().map(|name| (*name).to_owned()).collect()
}

/// What is wrong with the modules that `module` uses.
fn violations(module: &str, used: &[String]) -> Vec<String> {
    let place = |name: &str| ORDER.iter().position(|known| *known == name);
    let own = place(module);
    used.iter()
        .filter(|name| name.as_str() != module)
        .filter(|name| match (own, place(name)) {
            _ if LEAVES.contains(&module) => LEAVES.contains(&name.as_str()),
            (Some(own), Some(other)) => other > own,
            _ => true,
        })
        .map(|name| format!("{module} must not use {name}"))
        .collect()
}

#[test]
fn every_module_uses_only_those_to_its_left() {
    let folder = crates().join("sprung/src");
    let mut wrong = Vec::new();
    let mut seen = 0;
    for (path, text) in sources(&folder) {
        let inside = path.strip_prefix(&folder).unwrap().with_extension("");
        let mut parts: Vec<&str> = inside.iter().map(|part| part.to_str().unwrap()).collect();
        // A file `tests` is a test module like those at the end of other files.
        if parts == ["lib"] || parts.ends_with(&["tests"]) {
            continue;
        }
        if parts.ends_with(&["mod"]) {
            parts.pop();
        }
        let used = modules_used(&text, parts.len());
        seen += used.len();
        for violation in violations(parts[0], &used) {
            wrong.push(format!("{}: {violation}", path.display()));
        }
    }
    assert!(seen > 20, "only {seen} uses were found");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
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
fn wrong_examples_are_found() {
    let text = r#"
        //! Mentions crate::report in a comment only.
        use crate::{
            finding::Finding,
            validate::{metrics, Outcome},
        };
        use crate::log::{LogError, Summary};
        use super::super::estimate::fit;
        use super::sibling;
        fn f() -> crate::demo::X { g("crate::report", sprung_crate::report::y()) }
        #[cfg(test)]
        mod tests { use super::super::other; }
    "#;
    let used = modules_used(text, 2);
    assert_eq!(used, ["finding", "validate", "log", "demo", "estimate"]);
    assert_eq!(
        violations("regression", &used),
        [
            "regression must not use validate",
            "regression must not use demo",
            "regression must not use estimate"
        ]
    );
    assert!(violations("validate", &["log".to_owned(), "validate".to_owned()]).is_empty());
    assert_eq!(violations("log", &["newcomer".to_owned()]).len(), 1);
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
fn files_are_short_and_libraries_print_nothing() {
    for name in ["sprung-core", "sprung", "sprung-cli"] {
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
