//! SHA-256, for the provenance of a file.

use std::fmt::Write;
use std::io::{BufRead, BufReader, Read, Result};

use sha2::{Digest, Sha256};

/// Returns the hash of the contents of a reader, as 64 hexadecimal digits.
///
/// # Errors
///
/// The error of the reader.
pub fn sha256(from: impl Read) -> Result<String> {
    let mut from = BufReader::new(from);
    let mut hash = Sha256::new();
    loop {
        let bytes = from.fill_buf()?;
        let count = bytes.len();
        if count == 0 {
            break;
        }
        hash.update(bytes);
        from.consume(count);
    }
    let mut text = String::with_capacity(64);
    for byte in hash.finalize() {
        // Writing to a string does not fail.
        let _ = write!(text, "{byte:02x}");
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_of_the_standard() {
        for (text, hash) in [
            (
                String::new(),
                "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855",
            ),
            (
                "abc".to_owned(),
                "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad",
            ),
            (
                "abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq".to_owned(),
                "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1",
            ),
            (
                "a".repeat(1_000_000),
                "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0",
            ),
        ] {
            assert_eq!(sha256(text.as_bytes()).unwrap(), hash);
        }
    }
}
