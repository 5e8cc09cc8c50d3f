//! Small experiments on disk, and runs of the program.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use serde_json::Value;
use sprung_testing::{Messages, largest_of_normals};
pub(crate) use sprung_testing::{contains, each};
use tempfile::TempDir;

/// Exit code and output of a run.
#[derive(Debug, PartialEq)]
pub(crate) struct Ran {
    pub(crate) code: Option<i32>,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Ran {
    pub(crate) fn of(command: &mut Command) -> Self {
        Self::from(&command.output().unwrap())
    }

    pub(crate) fn from(output: &Output) -> Self {
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        Self {
            code: output.status.code(),
            out: text(&output.stdout),
            err: text(&output.stderr),
        }
    }

    /// Checks the exit code.
    #[track_caller]
    pub(crate) fn ends(&self, code: i32) -> &Self {
        assert_eq!(self.code, Some(code), "{}{}", self.err, self.out);
        self
    }

    /// Checks that the exit code is that of a result, with or without serious findings.
    #[track_caller]
    pub(crate) fn has_a_result(&self) -> &Self {
        assert!(matches!(self.code, Some(0 | 1)), "{self:?}");
        self
    }

    /// Checks parts of the output on stderr.
    #[track_caller]
    pub(crate) fn tells(&self, parts: &[&str]) -> &Self {
        contains(&self.err, parts);
        self
    }

    /// Checks parts of the output on stdout.
    #[track_caller]
    pub(crate) fn prints(&self, parts: &[&str]) -> &Self {
        contains(&self.out, parts);
        self
    }

    /// The JSON on stdout.
    #[track_caller]
    pub(crate) fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap_or_else(|_| panic!("{}", self.err))
    }
}

/// A command that runs the program.
pub(crate) fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_sprung"))
}

/// Runs the program.
pub(crate) fn sprung(args: &[&str]) -> Ran {
    Ran::of(program().args(args))
}

/// Checks that a text has all lines.
#[track_caller]
pub(crate) fn has_lines(text: &str, lines: &[&str]) {
    for line in lines {
        let has = text.lines().any(|known| known == *line);
        assert!(has, "no line {line} in: {text}");
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

/// The folder that `sprung demo` writes; all tests share it.
pub(crate) fn demo() -> &'static Path {
    static DEMO: OnceLock<TempDir> = OnceLock::new();
    DEMO.get_or_init(|| {
        let folder = TempDir::new().unwrap();
        let out = folder.path().to_str().unwrap();
        sprung(&["demo", "--quiet", "--out", out]).ends(0);
        folder
    })
    .path()
}

/// A count of the demo's encoders, rad.
pub(crate) const COUNT: f64 = std::f64::consts::TAU / 16384.0;

/// Estimators of most tests.
const LINEAR: &str = "[\"least-squares\", \"lsff\"]";

/// A copy of the demo's experiment, to be changed by a test.
#[derive(Debug)]
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

    /// The path of a file as an argument.
    pub(crate) fn at(&self, file: &str) -> String {
        self.path(file).to_str().unwrap().to_owned()
    }

    #[track_caller]
    pub(crate) fn read(&self, file: &str) -> String {
        std::fs::read_to_string(self.path(file)).unwrap()
    }

    #[track_caller]
    pub(crate) fn json(&self, file: &str) -> Value {
        serde_json::from_str(&self.read(file)).unwrap()
    }

    #[track_caller]
    pub(crate) fn write(&self, file: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.path(file), bytes).unwrap();
    }

    #[track_caller]
    pub(crate) fn remove(&self, file: &str) {
        std::fs::remove_file(self.path(file)).unwrap();
    }

    /// Replaces text in the experiment file.
    pub(crate) fn replace(self, from: &str, to: &str) -> Self {
        self.replace_in("experiment.toml", from, to)
    }

    /// Replaces text in a file.
    pub(crate) fn replace_in(self, file: &str, from: &str, to: &str) -> Self {
        let text = self.read(file);
        assert!(text.contains(from), "{file} does not hold {from:?}");
        self.write(file, text.replace(from, to));
        self
    }

    /// Changes the cells of the log; row 0 is the header.
    pub(crate) fn log(self, change: impl FnMut(usize, &mut Vec<String>)) -> Self {
        self.cells("identification.csv", change)
    }

    /// Keeps the first samples of the log.
    pub(crate) fn first_rows(self, count: usize) -> Self {
        self.log(|row, cells| {
            if row > count {
                cells.clear();
            }
        })
    }

    /// Writes a text into one cell of the log.
    pub(crate) fn cell(self, row: usize, column: usize, text: &str) -> Self {
        self.log(|at, cells| {
            if at == row {
                text.clone_into(&mut cells[column]);
            }
        })
    }

    /// Delays a column of the log by a number of samples.
    pub(crate) fn late(self, column: usize, samples: usize) -> Self {
        let mut past: Vec<String> = Vec::new();
        self.log(|row, cells| {
            if row > 0 {
                past.push(cells[column].clone());
                cells[column].clone_from(&past[past.len().saturating_sub(samples + 1)]);
            }
        })
    }

    /// Changes the cells of the log in `file`.
    pub(crate) fn cells(self, file: &str, mut change: impl FnMut(usize, &mut Vec<String>)) -> Self {
        let text = self.read(file);
        let mut changed = String::new();
        for (row, line) in text.lines().enumerate() {
            let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
            change(row, &mut cells);
            if !cells.is_empty() {
                changed.push_str(&cells.join(","));
                changed.push('\n');
            }
        }
        self.write(file, changed);
        self
    }

    /// Applies a function to the numbers of one column of the log.
    pub(crate) fn column(self, column: usize, change: impl Fn(f64) -> f64) -> Self {
        self.column_of("identification.csv", column, change)
    }

    /// Applies a function to the numbers of some columns of the log.
    pub(crate) fn columns(self, columns: &[usize], change: fn(f64) -> f64) -> Self {
        (columns.iter()).fold(self, |case, column| case.column(*column, change))
    }

    /// Applies a function to the numbers of one column of a log.
    pub(crate) fn column_of(self, file: &str, column: usize, change: impl Fn(f64) -> f64) -> Self {
        self.cells(file, |row, cells| {
            if row > 0 {
                cells[column] = change(cells[column].parse().unwrap()).to_string();
            }
        })
    }

    /// Runs a verb on the experiment with more arguments.
    pub(crate) fn run(&self, verb: &str, more: &[&str]) -> Ran {
        Ran::of(
            program()
                .arg(verb)
                .arg(self.path("experiment.toml"))
                .args(more),
        )
    }

    /// Runs `sprung identify` with more arguments.
    pub(crate) fn identify(&self, more: &[&str]) -> Ran {
        self.run("identify", more)
    }

    /// Records a log of the twin as `file`.
    pub(crate) fn record(&self, file: &str, more: &[&str]) {
        let (out, name) = (self.at("twin"), format!("log.file={file}"));
        let usual = ["-q", "--out", &out, "--set", &name];
        self.run("simulate", &[&usual[..], more].concat()).ends(0);
        std::fs::rename(self.path("twin").join(file), self.path(file)).unwrap();
    }

    /// Identifies and returns the exit code and the results.
    pub(crate) fn results(&self, more: &[&str]) -> (i32, Value) {
        let output = self.identify(&[&["--json"], more].concat());
        (output.code.unwrap(), output.json())
    }

    /// What the program printed on stderr, with FOLDER for the folder of the case.
    pub(crate) fn message(&self, output: &Ran) -> String {
        let folder = self.folder.path().to_str().unwrap();
        output.err.replace(folder, "FOLDER")
    }

    /// Checks that identification fails with a code and leaves no results; returns the message, one line.
    #[track_caller]
    pub(crate) fn refused(&self, code: i32, more: &[&str]) -> String {
        let output = self.identify(more);
        let message = self.message(&output);
        output.ends(code);
        assert!(message.starts_with("error: "), "{message}");
        // Further lines of a correction are indented.
        let is_first = |line: &&str| !line.starts_with("    ");
        let lines = message.trim().lines().filter(is_first).count();
        assert_eq!(lines, 1, "{message}");
        let out = self.path("sprung-out");
        assert!(!out.exists(), "{more:?}: a failed run left results");
        message
    }

    /// Checks that identification fails with a code and a message.
    #[track_caller]
    pub(crate) fn fails(&self, code: i32, fragments: &[&str]) {
        contains(&self.refused(code, &[]), fragments);
    }

    /// Checks that identification ends with a code and warns.
    pub(crate) fn warns(&self, code: i32, fragments: &[&str]) {
        self.identify(&["-v"]).ends(code).tells(fragments);
        assert!(self.path("sprung-out/report.html").exists());
    }
}

/// A number of a JSON file.
#[track_caller]
pub(crate) fn f64_of(value: &Value) -> f64 {
    (value.as_f64()).unwrap_or_else(|| panic!("no number: {value}"))
}

/// A list of a JSON file.
#[track_caller]
pub(crate) fn list_of(value: &Value) -> &[Value] {
    (value.as_array()).unwrap_or_else(|| panic!("no list: {value}"))
}

/// A text of a JSON file.
#[track_caller]
pub(crate) fn str_of(value: &Value) -> &str {
    (value.as_str()).unwrap_or_else(|| panic!("no text: {value}"))
}

/// A parameter of the first result.
pub(crate) fn parameter<'a>(json: &'a Value, name: &str) -> &'a Value {
    let all = list_of(&json["results"][0]["parameters"]);
    (all.iter().find(|p| p["name"] == name)).unwrap_or_else(|| panic!("no {name} in {json:#}"))
}

/// Checks that a parameter of the first result is the true one within its standard error, which is at most this share of it.
#[track_caller]
pub(crate) fn is_known(json: &Value, name: &str, truth: f64, share: f64) {
    let found = parameter(json, name);
    let [value, error] = ["value", "standard_error"].map(|key| f64_of(&found[key]));
    let away = (value - truth).abs();
    assert!(away < 4.0 * error, "{name} = {value} ± {error}, {truth}");
    assert!(error < share * truth.abs(), "{name} = {value} ± {error}");
}

/// The value of a parameter of the first result.
pub(crate) fn value(json: &Value, name: &str) -> f64 {
    f64_of(&parameter(json, name)["value"])
}

/// The parameters of a result that have a value under a key, as TOML.
pub(crate) fn values_of(result: &Value, key: &str) -> String {
    let line = |one: &Value| Some(format!("{} = {}\n", one["name"], one[key].as_f64()?));
    list_of(&result["parameters"])
        .iter()
        .filter_map(line)
        .collect()
}

/// Largest standard error of a parameter relative to its value with which a comparison with the truth says something.
const USEFUL: f64 = 0.1;

/// Checks that parameters of the first result are the true ones within their standard errors.
#[track_caller]
pub(crate) fn assert_true(json: &Value, truth: &[(&str, f64)]) {
    let limit = largest_of_normals(truth.len());
    for (name, truth) in truth.iter().copied() {
        let found = parameter(json, name);
        let [value, error] = ["value", "standard_error"].map(|key| f64_of(&found[key]));
        let away = (value - truth) / error;
        println!("{name}: {value:.5} ± {error:.5}, {away:.1} standard errors from {truth}");
        assert!(away.abs() < limit, "{name}: {value} ± {error}, not {truth}");
        let useful = truth == 0.0 || error < USEFUL * truth.abs();
        assert!(useful, "{name}: {value} ± {error}");
    }
}

/// A finding about the log, or about the first result.
pub(crate) fn found<'a>(json: &'a Value, code: &str) -> Option<&'a Value> {
    [&json["findings"], &json["results"][0]["warnings"]]
        .into_iter()
        .filter_map(Value::as_array)
        .flatten()
        .find(|finding| finding["code"] == code)
}

/// The text of a finding about the log, or about the first result.
pub(crate) fn finding<'a>(json: &'a Value, code: &str) -> Option<&'a str> {
    found(json, code).map(|finding| str_of(&finding["text"]))
}
