//! The pages of the documentation agree with the program: their commands run as they are written, and
//! their tables have the figures that the program prints.

mod claims;
mod commands;
mod experiment;
mod figures;
mod findings;
mod matlab;
mod tutorial;
mod what_works;

use std::path::{Path, PathBuf};

use serde_json::Value;
use tempfile::TempDir;

use crate::common::{Ran, demo, program};

/// Returns the path of a file of the repository.
fn path_in_repository(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .join(file)
}

/// Returns the text of a file of the repository.
fn of_repository(file: &str) -> String {
    std::fs::read_to_string(path_in_repository(file)).unwrap()
}

/// Returns the fenced blocks of a page in one language.
fn blocks(page: &str, language: &str) -> Vec<String> {
    let opening = format!("```{language}\n");
    let parts = page.split(&opening).skip(1);
    parts
        .map(|rest| rest.split("```").next().unwrap().to_owned())
        .collect()
}

/// Returns the words of each command `sprung …` in a shell block. Single quotes may span lines; a `#` after a blank
/// begins a comment.
fn commands_of(block: &str) -> Vec<Vec<String>> {
    let mut commands = Vec::new();
    let (mut words, mut word) = (Vec::<String>::new(), String::new());
    let (mut is_quoted, mut is_comment) = (false, false);
    for c in block.chars() {
        match c {
            '\n' if !is_quoted => {
                words.extend(Some(std::mem::take(&mut word)).filter(|word| !word.is_empty()));
                commands.push(std::mem::take(&mut words));
                is_comment = false;
            }
            _ if is_comment => {}
            '\'' => is_quoted = !is_quoted,
            '#' if !is_quoted && word.is_empty() => is_comment = true,
            ' ' if !is_quoted => {
                words.extend(Some(std::mem::take(&mut word)).filter(|word| !word.is_empty()));
            }
            c => word.push(c),
        }
    }
    assert!(!is_quoted, "{block}");
    commands.retain(|words| words.first().is_some_and(|word| word == "sprung"));
    commands
}

/// Runs the commands of a page's shell blocks in a folder; returns the output of each on stdout.
fn run_commands(page: &str, folder: &Path) -> Vec<String> {
    let commands: Vec<_> = (blocks(page, "sh").iter())
        .flat_map(|block| commands_of(block))
        .collect();
    let printed = commands.iter().map(|words| {
        println!("{}", words.join(" "));
        let output = Ran::of(program().args(&words[1..]).current_dir(folder));
        let code = output.code;
        assert!(code == Some(0), "{words:?}: {code:?} {}", output.err);
        output.out
    });
    printed.collect()
}

/// Returns a folder with the experiment of `sprung demo` in `sprung-demo`.
fn beside_the_demo() -> TempDir {
    let folder = TempDir::new().unwrap();
    let experiment = folder.path().join("sprung-demo");
    std::fs::create_dir(&experiment).unwrap();
    for file in [
        "experiment.toml",
        "truth.toml",
        "identification.csv",
        "validation.csv",
    ] {
        std::fs::copy(demo().join(file), experiment.join(file)).unwrap();
    }
    folder
}

/// Returns the first result of the `identification.json` in a folder.
fn first_result(folder: &Path) -> Value {
    let text = std::fs::read_to_string(folder.join("identification.json")).unwrap();
    let all: Value = serde_json::from_str(&text).unwrap();
    all["results"][0].clone()
}
