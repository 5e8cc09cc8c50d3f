//! The commands of the README run as they are written there.

use std::process::Command;

use tempfile::TempDir;

use crate::common::{demo, stderr};

/// Commands of the README's shell blocks that run the program.
fn commands() -> Vec<String> {
    let readme = concat!(env!("CARGO_MANIFEST_DIR"), "/../../README.md");
    let text = std::fs::read_to_string(readme).unwrap();
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
