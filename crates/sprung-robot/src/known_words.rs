//! Words from a fixed list; the error for an unknown word names the nearest known word.

pub(crate) use sprung_base::named::nearest;

/// Returns the index of `word` in `available`, or a message with the nearest word.
///
/// - `what`: name of the choice for the message.
pub(crate) fn choose(what: &str, word: &str, available: &[&str]) -> Result<usize, String> {
    if let Some(index) = available.iter().position(|&candidate| candidate == word) {
        return Ok(index);
    }
    let list = quoted(available);
    Err(match nearest(word, available.iter().copied()) {
        Some(candidate) => format!("unknown {what} \"{word}\"; did you mean \"{candidate}\"?"),
        None => format!("unknown {what} \"{word}\"; use {list}"),
    })
}

/// Returns `"a", "b" or "c"`.
pub(crate) fn quoted(words: &[&str]) -> String {
    match words {
        [] => String::new(),
        [one] => format!("\"{one}\""),
        [first @ .., last] => {
            let first: Vec<String> = first.iter().map(|word| format!("\"{word}\"")).collect();
            format!("{} or \"{last}\"", first.join(", "))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_offers_the_nearest_word_or_lists_all() {
        let words = ["least-squares", "lsff"];
        assert_eq!(choose("estimator", "lsff", &words), Ok(1));
        let message = choose("estimator", "least-square", &words).unwrap_err();
        assert!(
            message.contains("did you mean \"least-squares\""),
            "{message}"
        );
        let message = choose("estimator", "magic", &words).unwrap_err();
        assert!(
            message.contains("use \"least-squares\" or \"lsff\""),
            "{message}"
        );
    }
}
