//! Long texts of files on the terminal.

use std::borrow::Cow;

use sprung::foreign::shortened;

/// Longest text between quotes that is written whole. Longer ones come from files that are no logs or experiments.
const MAX_QUOTED_CHARS: usize = 400;

/// Longest word that is written whole; paths may be long.
const MAX_WORD_CHARS: usize = 4096;

/// Returns a message in which long texts between quotes and long words are cut.
pub(super) fn bounded(text: &str) -> Cow<'_, str> {
    if text.len() <= MAX_QUOTED_CHARS {
        return Cow::Borrowed(text);
    }
    let quoted = text.split('"').enumerate().map(|(i, part)| {
        // Every second part stands between quotes; an odd number of them leaves the last one open.
        let is_quoted = i % 2 == 1;
        if is_quoted && part.chars().count() > MAX_QUOTED_CHARS {
            shortened(part)
        } else {
            words(part)
        }
    });
    Cow::Owned(quoted.collect::<Vec<_>>().join("\""))
}

fn words(text: &str) -> String {
    let words = text.split_inclusive(char::is_whitespace);
    let short = |word: &str| {
        if word.chars().count() > MAX_WORD_CHARS {
            shortened(word) + " "
        } else {
            word.to_owned()
        }
    };
    words.map(short).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_foreign_texts_are_cut_and_messages_stay_whole() {
        let long = "x".repeat(5000);
        for (text, shown) in [
            (
                format!("no key \"{long}\" here"),
                format!("no key \"{}…\" here", "x".repeat(80)),
            ),
            (
                format!("begins with <{long}> here"),
                format!("begins with <{}… here", "x".repeat(79)),
            ),
            (
                "many short words ".repeat(1000),
                "many short words ".repeat(1000),
            ),
        ] {
            assert_eq!(bounded(&text), shown);
        }
    }
}
