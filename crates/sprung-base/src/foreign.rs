//! Texts of files in messages and in other files.

use std::borrow::Cow;
use std::fmt::Write;

use super::limits::SHOWN_CHARS;

/// Returns a text in which `\u001b` stands for each control character but tabs and ends of lines, and for each that
/// changes the direction of the text. JSON reads it as that character.
#[must_use]
pub fn escaped(text: &str) -> Cow<'_, str> {
    if !text.contains(is_control) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if is_control(c) {
            // Writing to a string does not fail.
            let _ = write!(out, "\\u{:04x}", u32::from(c));
        } else {
            out.push(c);
        }
    }
    Cow::Owned(out)
}

fn is_control(c: char) -> bool {
    let turns =
        matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || (c.is_control() && !matches!(c, '\n' | '\t'))
}

/// Returns the first [`SHOWN_CHARS`] characters of a text, with `…` in place of others.
#[must_use]
pub fn shortened(text: &str) -> String {
    match text.char_indices().nth(SHOWN_CHARS) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_written_as_text() {
        for (text, shown) in [
            ("q1\t[rad]\n", "q1\t[rad]\n"),
            ("ϕ̈ – ±", "ϕ̈ – ±"),
            ("\u{1b}[31mq\u{1b}[0m", "\\u001b[31mq\\u001b[0m"),
            ("a\rb\u{8}", "a\\u000db\\u0008"),
            ("\u{7f}\u{9b}31m", "\\u007f\\u009b31m"),
            ("\u{202e}dar", "\\u202edar"),
        ] {
            assert_eq!(escaped(text), shown);
        }
        let json = serde_json::to_string("q\u{9b}\u{7f}").unwrap();
        let read: String = serde_json::from_str(&escaped(&json)).unwrap();
        assert_eq!(read, "q\u{9b}\u{7f}");
    }

    #[test]
    fn long_texts_are_cut() {
        assert_eq!(shortened(&"é".repeat(81)).chars().count(), 81);
        assert_eq!(shortened("short"), "short");
    }
}
