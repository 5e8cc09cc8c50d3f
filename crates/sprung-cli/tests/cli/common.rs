//! A small experiment on disk, and the program run on it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use tempfile::TempDir;

/// Runs the program.
pub(crate) fn sprung(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sprung"))
        .args(args)
        .output()
        .unwrap()
}

/// What the program printed on stderr.
pub(crate) fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// What the program printed on stdout.
pub(crate) fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// The folder that `sprung demo` writes, made once for all tests of a file.
pub(crate) fn demo() -> &'static Path {
    static DEMO: OnceLock<TempDir> = OnceLock::new();
    DEMO.get_or_init(|| {
        let folder = TempDir::new().unwrap();
        let out = folder.path().to_str().unwrap();
        let output = sprung(&["demo", "--quiet", "--out", out]);
        assert!(output.status.success(), "{}", stderr(&output));
        folder
    })
    .path()
}

/// A copy of the demo's experiment, to be damaged.
pub(crate) struct Case {
    folder: TempDir,
}

impl Case {
    pub(crate) fn new() -> Self {
        let folder = TempDir::new().unwrap();
        for file in ["experiment.toml", "identification.csv", "truth.toml"] {
            std::fs::copy(demo().join(file), folder.path().join(file)).unwrap();
        }
        Self { folder }
    }

    pub(crate) fn path(&self, file: &str) -> PathBuf {
        self.folder.path().join(file)
    }

    /// Replaces text in the experiment file.
    pub(crate) fn replace(self, from: &str, to: &str) -> Self {
        let file = self.path("experiment.toml");
        let text = std::fs::read_to_string(&file).unwrap();
        assert!(text.contains(from), "the experiment does not hold {from:?}");
        std::fs::write(file, text.replace(from, to)).unwrap();
        self
    }

    /// Changes the cells of the log; row 0 is the header.
    pub(crate) fn log(self, mut change: impl FnMut(usize, &mut Vec<String>)) -> Self {
        let file = self.path("identification.csv");
        let text = std::fs::read_to_string(&file).unwrap();
        let mut changed = String::new();
        for (row, line) in text.lines().enumerate() {
            let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
            change(row, &mut cells);
            if !cells.is_empty() {
                changed.push_str(&cells.join(","));
                changed.push('\n');
            }
        }
        std::fs::write(file, changed).unwrap();
        self
    }

    /// Applies a function to the numbers of one column of the log.
    pub(crate) fn column(self, column: usize, change: impl Fn(f64) -> f64) -> Self {
        self.log(|row, cells| {
            if row > 0 {
                cells[column] = change(cells[column].parse().unwrap()).to_string();
            }
        })
    }

    /// Runs `sprung identify` with more arguments.
    pub(crate) fn identify(&self, more: &[&str]) -> Output {
        let experiment = self.path("experiment.toml");
        let mut args = vec!["identify", experiment.to_str().unwrap()];
        args.extend(more);
        sprung(&args)
    }

    /// Checks that identification fails with a code and a message.
    pub(crate) fn fails(&self, code: i32, fragments: &[&str]) {
        let output = self.identify(&[]);
        let message = stderr(&output);
        println!("{message}");
        assert_eq!(output.status.code(), Some(code), "{message}");
        for fragment in fragments {
            assert!(message.contains(fragment), "no {fragment:?} in: {message}");
        }
        assert!(message.starts_with("error: "), "{message}");
        assert_eq!(message.trim().lines().count(), 1, "{message}");
        let out = self.path("sprung-out");
        assert!(!out.exists(), "a failed run left results");
    }

    /// Checks that identification ends with a code and warns.
    pub(crate) fn warns(&self, code: i32, fragments: &[&str]) {
        let output = self.identify(&["-v"]);
        let message = stderr(&output);
        println!("{message}");
        assert_eq!(output.status.code(), Some(code), "{message}");
        for fragment in fragments {
            assert!(message.contains(fragment), "no {fragment:?} in: {message}");
        }
        assert!(self.path("sprung-out/report.html").exists());
    }
}
