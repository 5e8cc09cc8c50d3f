//! The reader for MATLAB, in GNU Octave.

use std::process::Command;

use tempfile::TempDir;

use super::path_in_repository;

#[test]
fn octave_runs_the_demo_and_reads_its_parameters() {
    let octave = |script: &std::path::Path, folder: &std::path::Path| {
        let program = std::path::Path::new(env!("CARGO_BIN_EXE_sprung"));
        let path = std::env::var("PATH").unwrap();
        let path = format!("{}:{path}", program.parent().unwrap().display());
        Command::new("octave-cli")
            .args(["--quiet", "--no-gui"])
            .arg(script)
            .current_dir(folder)
            .env("PATH", path)
            .output()
    };
    let folder = TempDir::new().unwrap();
    let script = path_in_repository("examples/matlab/run_demo.m");
    let Ok(output) = octave(&script, folder.path()) else {
        sprung_testing::skipped("octave", "there is no octave-cli");
        return;
    };
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.starts_with("verdict: good\n"), "{text}");
    let words = |line: &str| line.split_whitespace().nth(1)?.parse::<f64>().ok();
    let line = text
        .lines()
        .find(|line| line.starts_with("joint1.stiffness "));
    let stiffness = line.and_then(words).unwrap();
    assert!((stiffness / 9.3587 - 1.0).abs() < 0.01, "{text}");
    assert_eq!(text.lines().count(), 16);
}
