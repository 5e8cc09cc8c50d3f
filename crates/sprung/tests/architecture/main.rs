//! The structure of the code: allowed uses between modules, the length of files, and forbidden calls of the library.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod files;
mod public_names;
mod shapes;

use std::fs;
use std::path::{Path, PathBuf};

use files::{Files, LIBRARY};

/// Modules of `sprung` in order. A module uses only modules before it.
const ORDER: [&str; 32] = [
    "limits",
    "foreign",
    "finding",
    "curves",
    "ellipsoid",
    "named",
    "explanation",
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
    "unknowns",
    "frequency",
    "check",
    "estimate",
    "validate",
    "compare",
    "excite",
    "control",
    "watch",
    "export",
    "servo",
    "session",
    "report",
];

/// Modules that no other module uses.
const LEAVES: [&str; 1] = ["demo"];

/// Folders and files of `estimate` in order. Each uses only those before it.
const ESTIMATE: [&str; 16] = [
    "errors",
    "statistics",
    "result",
    "refined_unknowns",
    "nuisances",
    "laws",
    "possible",
    "estimators",
    "springs",
    "sums",
    "physical",
    "posterior",
    "payload",
    "judge",
    "steps",
    "identify",
];

/// Modules whose folders use each other in a circle.
const CIRCULAR: [&str; 1] = ["log"];

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

/// Returns the names of all crates of the library.
fn libraries() -> impl Iterator<Item = &'static str> {
    let outer = LIBRARY.into_iter().map(|(name, _)| name);
    std::iter::once("sprung-core").chain(outer)
}

/// Returns whether a module may use another.
fn may_use(module: &str, other: &str) -> bool {
    let place = |name: &str| ORDER.iter().position(|known| *known == name);
    match (place(module), place(other)) {
        _ if module == other => true,
        (Some(position), Some(other)) => other < position,
        (None, Some(_)) => LEAVES.contains(&module),
        _ => false,
    }
}

#[test]
fn every_module_uses_only_those_to_its_left() {
    let uses = Files::library().uses();
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
    let mut circles = Files::library().circles();
    for name in ["sprung-core", "sprung-cli", "sprung-testing"] {
        circles.extend(Files::read(&crates().join(name).join("src")).circles());
    }
    assert!(circles.is_empty(), "{}", circles.join("\n"));
}

#[test]
fn every_folder_of_estimate_uses_only_those_before_it() {
    let files = Files::library();
    let between = files.uses_between_children(&["estimate".to_owned()]);
    let place = |name: &str| ESTIMATE.iter().position(|known| *known == name);
    let unknown: Vec<&String> = (between.iter())
        .flat_map(|use_of| [&use_of.from, &use_of.to])
        .filter(|name| place(name).is_none())
        .collect();
    assert!(unknown.is_empty(), "{unknown:?} have no place");
    let back: Vec<String> = (between.iter())
        .filter(|use_of| place(&use_of.to) > place(&use_of.from))
        .map(|use_of| use_of.found.words())
        .collect();
    assert!(back.is_empty(), "{}", back.join("\n"));
}

#[test]
fn no_folders_use_each_other_in_a_circle() {
    let circles = Files::library().circles_of_folders();
    let wrong: Vec<&str> = (circles.iter())
        .filter(|(module, _)| !CIRCULAR.contains(&module.as_str()))
        .map(|(_, words)| words.as_str())
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    for module in CIRCULAR {
        let has = circles.iter().any(|(member, _)| member == module);
        assert!(has, "remove {module} from the list");
    }
}

#[test]
fn modules_to_the_right_are_refused() {
    assert!(may_use("validate", "log") && may_use("demo", "estimate"));
    assert!(!may_use("regression", "validate") && !may_use("log", "newcomer"));
    assert!(!may_use("newcomer", "log") && !may_use("report", "demo"));
}

#[test]
fn every_module_has_its_place() {
    let mut modules: Vec<String> = Vec::new();
    for (name, prefix) in LIBRARY {
        if let [module] = prefix {
            modules.push((*module).to_owned());
            continue;
        }
        for entry in fs::read_dir(crates().join(name).join("src")).unwrap() {
            let path = entry.unwrap().path();
            modules.push(path.file_stem().unwrap().to_str().unwrap().to_owned());
        }
    }
    modules.retain(|module| module != "lib");
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
    for name in libraries() {
        for (path, text) in sources(&crates().join(name).join("src")) {
            let asks = ["Instant::", "SystemTime"]
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
    for name in libraries() {
        let folder = crates().join(name).join("src");
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
}

/// Phrases of refusals. Only the table of what works with what may refuse a combination of sensors, logs,
/// estimators and tasks.
const REFUSALS: [&str; 7] = [
    "does not work with",
    "do not work with",
    "does not know;",
    "knows no ",
    "does not support",
    "no format of export can",
    "NotSupported(Box",
];

#[test]
fn only_the_table_of_what_works_refuses_a_combination() {
    for name in ["sprung", "sprung-cli", "sprung-python"] {
        for (path, text) in sources(&crates().join(name).join("src")) {
            if path
                .components()
                .any(|part| part.as_os_str() == "capabilities")
            {
                continue;
            }
            let code = (text.lines()).filter(|line| !line.trim_start().starts_with("//"));
            for (i, line) in code.enumerate() {
                for phrase in REFUSALS {
                    assert!(
                        !line.contains(phrase),
                        "{}: \"{phrase}\" in line {} of the code; add the combination to \
                         description/capabilities/table.rs",
                        path.display(),
                        i + 1
                    );
                }
            }
        }
    }
}

/// Returns the codes of the findings that a file makes: the first text of each.
fn codes(text: &str) -> Vec<&str> {
    let made = text.split("Finding::new(").skip(1);
    made.filter_map(|made| made.split('"').nth(1)).collect()
}

#[test]
fn a_cause_that_a_log_may_show_is_named_in_its_file_of_the_catalogue_alone() {
    let method = crates().join("sprung-method/src");
    let catalogue = method.join("unknowns/kinds");
    let kinds = sources(&catalogue);
    let of_kinds: Vec<&str> = kinds.iter().flat_map(|(_, text)| codes(text)).collect();
    for code in ["torque-saturates", "delayed-channel", "torque-ripple"] {
        assert!(of_kinds.contains(&code), "{code} {of_kinds:?}");
    }
    for (path, text) in sources(&method) {
        if path.starts_with(&catalogue) {
            continue;
        }
        for code in codes(&text) {
            assert!(!of_kinds.contains(&code), "{}: {code}", path.display());
        }
    }
}

#[test]
fn files_are_short_and_libraries_print_nothing() {
    for name in libraries().chain(["sprung-cli", "sprung-testing"]) {
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
