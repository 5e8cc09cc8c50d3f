//! Returns the typed command, for reports.

/// Returns the typed command, with `sprung` as the name of the program.
pub(crate) fn command_line() -> String {
    let mut words = std::env::args_os();
    words.next();
    std::iter::once("sprung".to_owned())
        .chain(words.map(|word| quoted(&word.to_string_lossy())))
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
