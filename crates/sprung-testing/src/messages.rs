//! Texts of messages in files, so that a reviewer sees every change of a text.

use std::path::{Path, PathBuf};

/// Starts the line with the name of a case.
const MARK: &str = "── ";

/// With this variable, [`Messages::compare`] writes the file.
const WRITE: &str = "SPRUNG_WRITE_MESSAGES";

/// Messages of one test, in the order of their cases, and the file with the accepted ones.
///
/// The file has a line `── case`, the message and an empty line for each of them. The caller removes what differs
/// between machines, such as temporary folders.
#[must_use = "compare the messages with the file"]
pub struct Messages {
    file: PathBuf,
    noted: Vec<Noted>,
}

#[derive(Debug, PartialEq)]
struct Noted {
    case: String,
    message: String,
}

impl Messages {
    /// - `file`: the accepted messages.
    pub fn new(file: impl Into<PathBuf>) -> Self {
        Self {
            file: file.into(),
            noted: Vec::new(),
        }
    }

    /// Adds the message of a case.
    ///
    /// # Panics
    ///
    /// If the file could not tell the case from another one: its name is taken or has several lines, or a line of the
    /// message looks like a name.
    #[track_caller]
    pub fn note(&mut self, case: &str, message: &str) {
        let is_taken = self.noted.iter().any(|noted| noted.case == case);
        assert!(!is_taken, "two cases are called {case}");
        let has_one_line = case.lines().count() == 1 && case.trim() == case;
        assert!(has_one_line, "a case is called {case:?}");
        let looks_like_case = message.lines().any(|line| line.starts_with(MARK));
        assert!(!looks_like_case, "{case}: {message}");
        self.noted.push(Noted {
            case: case.to_owned(),
            message: trimmed(message),
        });
    }

    /// Compares all messages with the file, or writes the file if `SPRUNG_WRITE_MESSAGES` is set.
    ///
    /// # Panics
    ///
    /// If a message or a case differs, is new or is gone; or if the file cannot be read or written.
    #[track_caller]
    pub fn compare(&self) {
        let file = self.file.display();
        if std::env::var_os(WRITE).is_some() {
            let folder = self.file.parent().unwrap_or(Path::new(""));
            let written = std::fs::create_dir_all(folder)
                .and_then(|()| std::fs::write(&self.file, text(&self.noted)));
            assert!(written.is_ok(), "{file}: {written:?}");
            return;
        }
        let accepted = std::fs::read_to_string(&self.file);
        let accepted = accepted.map_or_else(|_| Vec::new(), |text| parsed(&text));
        if let Some(difference) = difference(&accepted, &self.noted) {
            panic!(
                "{file}, {difference}\n\nTo accept all new texts of this test: {}",
                command()
            );
        }
    }
}

/// Returns the first case that differs, with its old and new text.
fn difference(accepted: &[Noted], found: &[Noted]) -> Option<String> {
    let cases = accepted.len().max(found.len());
    let first = (0..cases).find(|&k| accepted.get(k) != found.get(k))?;
    let (old, new) = (accepted.get(first), found.get(first));
    let shown = |noted: Option<&Noted>, what: &str| match noted {
        Some(noted) => format!("\n{what}: {MARK}{}\n{}", noted.case, noted.message),
        None => format!("\n{what}: no further case"),
    };
    Some(format!(
        "message {}:{}{}",
        first + 1,
        shown(old, "old"),
        shown(new, "new")
    ))
}

/// Returns the command that accepts the new messages of the running test.
fn command() -> String {
    let package = std::env::var("CARGO_PKG_NAME")
        .map_or_else(|_| String::new(), |name| format!(" --package {name}"));
    let thread = std::thread::current();
    let test = thread.name().unwrap_or_default();
    format!("{WRITE}=1 cargo test{package} -- {test}")
}

/// Returns the text of a file.
fn text(all: &[Noted]) -> String {
    let cases: Vec<String> = (all.iter())
        .map(|noted| format!("{MARK}{}\n{}\n\n", noted.case, noted.message))
        .collect();
    cases.concat()
}

/// Returns the cases of a file.
fn parsed(text: &str) -> Vec<Noted> {
    let mut all: Vec<Noted> = Vec::new();
    for line in text.lines() {
        if let Some(case) = line.strip_prefix(MARK) {
            all.push(Noted {
                case: case.to_owned(),
                message: String::new(),
            });
        } else if let Some(last) = all.last_mut() {
            last.message.push_str(line);
            last.message.push('\n');
        }
    }
    for noted in &mut all {
        noted.message = trimmed(&noted.message);
    }
    all
}

/// Returns a message without spaces at the ends of its lines and without empty lines around it.
fn trimmed(message: &str) -> String {
    let lines: Vec<&str> = message.lines().map(str::trim_end).collect();
    lines.join("\n").trim_matches('\n').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noted(case: &str, message: &str) -> Noted {
        let (case, message) = (case.to_owned(), message.to_owned());
        Noted { case, message }
    }

    #[test]
    fn a_file_gives_back_its_cases() {
        let all = [
            noted("a cut-off of 600 Hz", "error: too high\n\n  hint: lower it"),
            noted("nothing", ""),
        ];
        assert_eq!(parsed(&text(&all)), all);
    }

    #[test]
    fn the_first_difference_is_shown() {
        let [one, two] = [noted("one", "a"), noted("two", "b")];
        let old = [noted("one", "a"), noted("two", "c")];
        let new = [one, two];
        assert_eq!(difference(&new, &new), None);
        let told = difference(&old, &new).unwrap();
        assert_eq!(told, "message 2:\nold: ── two\nc\nnew: ── two\nb");
        let told = difference(&new[..1], &new).unwrap();
        assert_eq!(told, "message 2:\nold: no further case\nnew: ── two\nb");
    }

    #[test]
    #[should_panic(expected = "two cases are called one")]
    fn two_cases_of_one_name_are_refused() {
        let mut messages = Messages::new("unused.txt");
        messages.note("one", "a");
        messages.note("one", "b");
    }
}
