//! The typed command, for reports.

use std::ffi::OsString;
use std::sync::Mutex;

/// The words of the command that runs.
static WORDS: Mutex<Vec<OsString>> = Mutex::new(Vec::new());

/// Remembers the words of the command that runs, the program first.
pub(crate) fn remember(words: Vec<OsString>) {
    if let Ok(mut remembered) = WORDS.lock() {
        *remembered = words;
    }
}

/// Returns the typed words, the program first.
pub(crate) fn words() -> Vec<OsString> {
    WORDS
        .lock()
        .map_or_else(|_| Vec::new(), |remembered| remembered.clone())
}

/// Returns the typed command, with `sprung` as the name of the program.
pub(crate) fn command_line() -> String {
    let words = words();
    std::iter::once("sprung".to_owned())
        .chain(
            words
                .iter()
                .skip(1)
                .map(|word| quoted(&word.to_string_lossy())),
        )
        .collect::<Vec<_>>()
        .join(" ")
}

/// Returns a word, quoted for a shell if necessary.
pub(crate) fn quoted(word: &str) -> String {
    if word.is_empty() || word.contains(|c: char| c.is_whitespace() || "\"'$`\\".contains(c)) {
        format!("'{}'", word.replace('\'', r"'\''"))
    } else {
        word.to_owned()
    }
}
