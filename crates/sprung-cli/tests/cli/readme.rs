//! The commands of the README run as they are written there, and its table of times agrees with the
//! figures that the comparison with other programs expects.

use std::process::Command;

use tempfile::TempDir;

use crate::common::{demo, stderr};

/// Commands of the README's shell blocks that run the program.
fn commands() -> Vec<String> {
    let text = of_repository("README.md");
    let mut inside = false;
    let mut commands = Vec::new();
    for line in text.lines() {
        if line.starts_with("```") {
            inside = line == "```sh";
        } else if inside && line.starts_with("sprung ") {
            let command = line.split_once(" #").map_or(line, |(command, _)| command);
            commands.push(command.trim().to_owned());
        }
    }
    commands
}

#[test]
fn commands_of_the_readme_run() {
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
    let commands = commands();
    assert!(commands.len() >= 5, "{commands:?}");
    for command in commands {
        println!("{command}");
        let output = Command::new(env!("CARGO_BIN_EXE_sprung"))
            .args(command.split_whitespace().skip(1))
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert!(output.status.success(), "{command}: {}", stderr(&output));
    }
    assert!(folder.path().join("second-run/identification.csv").exists());
}

/// Returns a file of the repository.
fn of_repository(file: &str) -> String {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../../");
    std::fs::read_to_string(format!("{root}{file}")).unwrap()
}

#[test]
fn time_and_memory_are_those_that_the_comparison_expects() {
    let readme = of_repository("README.md");
    let table = readme.split("### Time and memory").nth(1).unwrap();
    let expected = of_repository("benches/peers/expected.toml");
    let expected: toml::Table = expected.parse().unwrap();
    let ratios = expected["ratio"].as_array().unwrap();
    assert!(ratios.len() >= 10, "{ratios:?}");
    for ratio in ratios {
        let of = |key: &str| ratio[key].as_str().unwrap();
        let line = table
            .lines()
            .find(|line| line.starts_with(&format!("| {} |", of("case"))));
        let line = line.unwrap_or_else(|| panic!("README.md has no case {}", of("case")));
        for figure in ["ours", "theirs"] {
            // A figure must not be the end of a longer number.
            let words = format!(" {}", of(figure));
            assert!(line.contains(&words), "{}: no{words} in {line}", of("key"));
        }
    }
}
