//! Base64 without line breaks.

const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// Encodes bytes.
///
/// # Source
///
/// RFC 4648, section 4.
pub(super) fn encode(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let of = |i: usize| u32::from(three.get(i).copied().unwrap_or(0));
        let word = of(0) << 16 | of(1) << 8 | of(2);
        for place in 0..4 {
            let digit = DIGITS[(word >> (18 - 6 * place) & 63) as usize];
            text.push(if place > three.len() {
                '='
            } else {
                char::from(digit)
            });
        }
    }
    text
}

/// Decodes what [`encode`] returns.
#[cfg(test)]
pub(super) fn decode(text: &str) -> Vec<u8> {
    let digits: Vec<u32> = (text.bytes())
        .filter_map(|c| DIGITS.iter().position(|digit| *digit == c))
        .map(|digit| u32::try_from(digit).unwrap())
        .collect();
    let of_four = |four: &[u32]| {
        let word = (0..4).fold(0, |word, i| word << 6 | four.get(i).copied().unwrap_or(0));
        let [_, bytes @ ..] = u32::to_be_bytes(word);
        bytes[..four.len() - 1].to_vec()
    };
    digits.chunks(4).flat_map(of_four).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_examples_of_the_standard_hold() {
        let examples = [
            "", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy",
        ];
        for (length, expected) in examples.iter().enumerate() {
            let bytes = &b"foobar"[..length];
            assert_eq!(encode(bytes), *expected);
            assert_eq!(decode(expected), bytes);
        }
    }
}
