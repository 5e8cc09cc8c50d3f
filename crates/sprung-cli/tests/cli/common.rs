//! Small experiments on disk, and runs of the program.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use serde_json::Value;
use sprung_testing::{Messages, largest_of_normals};
use tempfile::TempDir;

/// Runs the program.
pub(crate) fn sprung(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sprung"))
        .args(args)
        .output()
        .unwrap()
}

/// Output of the program on stderr.
pub(crate) fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Exit code and output of a run.
#[derive(Debug, PartialEq)]
pub(crate) struct Ran {
    pub(crate) code: Option<i32>,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Ran {
    pub(crate) fn of(output: &Output) -> Self {
        Self {
            code: output.status.code(),
            out: stdout(output),
            err: stderr(output),
        }
    }
}

/// Messages of a test, whose file is in `tests/messages`.
pub(crate) fn messages(test: &str) -> Messages {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/messages");
    Messages::new(format!("{folder}/{test}.txt"))
}

/// A text with N for each number with decimals, which a computation may round otherwise on another processor.
pub(crate) fn without_decimals(text: &str) -> String {
    let is_part = |c: char| c.is_ascii_digit() || c == '.';
    let (mut out, mut rest) = (String::new(), text);
    while let Some(start) = rest.find(|c: char| c.is_ascii_digit()) {
        let length = rest[start..]
            .find(|c| !is_part(c))
            .unwrap_or(rest.len() - start);
        let number = rest[start..start + length].trim_end_matches('.');
        out.push_str(&rest[..start]);
        out.push_str(if number.contains('.') { "N" } else { number });
        rest = &rest[start + number.len()..];
    }
    out + rest
}

/// A text on one line, as the name of a case.
pub(crate) fn one_line(text: &str) -> String {
    text.trim().replace('\n', "; ")
}

/// Name of the case in which one text stands for another.
pub(crate) fn replacement(text: &str, by: &str) -> String {
    let by = match by.trim() {
        "" => "nothing".to_owned(),
        by => one_line(by),
    };
    format!("{by} for {}", one_line(text))
}

/// Output of the program on stdout.
pub(crate) fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// The folder that `sprung demo` writes; all tests share it.
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

/// A count of the demo's encoders, rad.
pub(crate) const COUNT: f64 = std::f64::consts::TAU / 16384.0;

/// Estimators of most tests.
const LINEAR: &str = "[\"least-squares\", \"lsff\"]";

/// A copy of the demo's experiment, to be changed by a test.
pub(crate) struct Case {
    folder: TempDir,
}

impl Case {
    /// With the linear estimators only, because a refinement takes seconds and most errors occur before it.
    pub(crate) fn new() -> Self {
        Self::as_shipped().replace(
            "[\"prediction-error\", \"least-squares\", \"lsff\"]",
            LINEAR,
        )
    }

    /// With the estimators of the demo.
    pub(crate) fn as_shipped() -> Self {
        let folder = TempDir::new().unwrap();
        for file in ["experiment.toml", "identification.csv", "truth.toml"] {
            std::fs::copy(demo().join(file), folder.path().join(file)).unwrap();
        }
        Self { folder }
    }

    /// An experiment from file names and texts.
    pub(crate) fn of(files: &[(&str, &str)]) -> Self {
        let folder = TempDir::new().unwrap();
        for (file, text) in files {
            std::fs::write(folder.path().join(file), text).unwrap();
        }
        Self { folder }
    }

    pub(crate) fn path(&self, file: &str) -> PathBuf {
        self.folder.path().join(file)
    }

    /// Replaces text in the experiment file.
    pub(crate) fn replace(self, from: &str, to: &str) -> Self {
        self.replace_in("experiment.toml", from, to)
    }

    /// Replaces text in a file.
    pub(crate) fn replace_in(self, file: &str, from: &str, to: &str) -> Self {
        let path = self.path(file);
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "{file} does not hold {from:?}");
        std::fs::write(path, text.replace(from, to)).unwrap();
        self
    }

    /// Changes the cells of the log; row 0 is the header.
    pub(crate) fn log(self, change: impl FnMut(usize, &mut Vec<String>)) -> Self {
        self.cells("identification.csv", change)
    }

    /// Changes the cells of the log in `file`.
    pub(crate) fn cells(self, file: &str, mut change: impl FnMut(usize, &mut Vec<String>)) -> Self {
        let file = self.path(file);
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
        self.column_of("identification.csv", column, change)
    }

    /// Applies a function to the numbers of one column of a log.
    pub(crate) fn column_of(self, file: &str, column: usize, change: impl Fn(f64) -> f64) -> Self {
        self.cells(file, |row, cells| {
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

    /// Records a log of the twin as `file`.
    pub(crate) fn record(&self, file: &str, more: &[&str]) {
        let (experiment, out) = (self.path("experiment.toml"), self.path("twin"));
        let (experiment, out) = (experiment.to_str().unwrap(), out.to_str().unwrap());
        let name = format!("log.file={file}");
        let mut args = vec!["simulate", experiment, "-q", "--out", out, "--set", &name];
        args.extend(more);
        let output = sprung(&args);
        assert!(output.status.success(), "{}", stderr(&output));
        std::fs::rename(self.path("twin").join(file), self.path(file)).unwrap();
    }

    /// Identifies and returns the exit code and the results.
    pub(crate) fn results(&self, more: &[&str]) -> (i32, Value) {
        let mut args = vec!["--json"];
        args.extend(more);
        let output = self.identify(&args);
        let json = serde_json::from_slice(&output.stdout);
        (
            output.status.code().unwrap(),
            json.unwrap_or_else(|_| panic!("{}", stderr(&output))),
        )
    }

    /// What the program printed on stderr, with FOLDER for the folder of the case.
    pub(crate) fn message(&self, output: &Output) -> String {
        stderr(output).replace(self.folder.path().to_str().unwrap(), "FOLDER")
    }

    /// Checks that identification fails with a code and leaves no results; returns the message, one line.
    #[track_caller]
    pub(crate) fn refused(&self, code: i32, more: &[&str]) -> String {
        let output = self.identify(more);
        let message = self.message(&output);
        assert_eq!(output.status.code(), Some(code), "{more:?}: {message}");
        assert!(message.starts_with("error: "), "{message}");
        // Further lines of a correction are indented.
        let is_first = |line: &&str| !line.starts_with("    ");
        assert_eq!(
            message.trim().lines().filter(is_first).count(),
            1,
            "{message}"
        );
        let out = self.path("sprung-out");
        assert!(!out.exists(), "{more:?}: a failed run left results");
        message
    }

    /// Checks that identification fails with a code and a message.
    #[track_caller]
    pub(crate) fn fails(&self, code: i32, fragments: &[&str]) {
        let message = self.refused(code, &[]);
        println!("{message}");
        for fragment in fragments {
            assert!(message.contains(fragment), "no {fragment:?} in: {message}");
        }
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

/// A parameter of the first result.
pub(crate) fn parameter<'a>(json: &'a Value, name: &str) -> &'a Value {
    let all = json["results"][0]["parameters"].as_array().unwrap();
    (all.iter().find(|p| p["name"] == name)).unwrap_or_else(|| panic!("no {name} in {json:#}"))
}

/// The value of a parameter of the first result.
pub(crate) fn value(json: &Value, name: &str) -> f64 {
    parameter(json, name)["value"].as_f64().unwrap()
}

/// Largest standard error of a parameter relative to its value with which a comparison with the truth says something.
const USEFUL: f64 = 0.1;

/// Checks that parameters of the first result are the true ones within their standard errors.
#[track_caller]
pub(crate) fn assert_true(json: &Value, truth: &[(&str, f64)]) {
    let limit = largest_of_normals(truth.len());
    for (name, truth) in truth.iter().copied() {
        let found = parameter(json, name);
        let [value, error] = ["value", "standard_error"].map(|key| found[key].as_f64().unwrap());
        let away = (value - truth) / error;
        println!("{name}: {value:.5} ± {error:.5}, {away:.1} standard errors from {truth}");
        assert!(away.abs() < limit, "{name}: {value} ± {error}, not {truth}");
        let useful = truth == 0.0 || error < USEFUL * truth.abs();
        assert!(useful, "{name}: {value} ± {error}");
    }
}

/// The text of a finding about the log, or about the first result.
pub(crate) fn finding<'a>(json: &'a Value, code: &str) -> Option<&'a str> {
    [&json["findings"], &json["results"][0]["warnings"]]
        .into_iter()
        .flat_map(|list| list.as_array().unwrap())
        .find(|finding| finding["code"] == code)
        .map(|finding| finding["text"].as_str().unwrap())
}
