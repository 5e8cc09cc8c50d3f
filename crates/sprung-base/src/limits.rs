//! Limits of inputs: one table, so that no file takes more than a bounded amount of memory and time.

use std::io::{Error, ErrorKind, Read, Result};

/// Largest number of bytes of a line of a log in text, with the lines between quotes that belong to it.
pub const LINE_BYTES: usize = 1 << 20;

/// Largest number of columns of a log: cells of a line, or columns of all arrays of a file.
pub const COLUMNS: usize = 1 << 14;

/// Largest number of bytes of a cell.
pub const CELL_BYTES: usize = 1 << 16;

/// Largest number of bytes of the name of a column.
pub const NAME_BYTES: usize = 1 << 12;

/// Largest number of bytes of a record of MCAP and of a buffer of Arrow, decompressed.
pub const RECORD_BYTES: usize = 128 << 20;

/// Largest number of joints of a robot in an experiment; time and memory grow with their cube.
pub const JOINTS: usize = 64;

/// Largest number of movable joints of a URDF, of which an experiment names some.
pub const URDF_JOINTS: usize = 256;

/// Largest number of links of a URDF.
pub const LINKS: usize = 1 << 12;

/// Largest number of bytes of an experiment file and of a file of parameter values.
pub const EXPERIMENT_BYTES: usize = 1 << 20;

/// Largest number of bytes of a URDF.
pub const URDF_BYTES: usize = 4 << 20;

/// Largest number of bytes of any other text file: results, controllers, factors of logs.
pub const TEXT_BYTES: usize = 64 << 20;

/// Largest number of values of a JSON file: numbers, texts, lists and objects.
pub const JSON_VALUES: usize = 1 << 20;

/// Largest number of objects of a JSON file. An empty one takes far more memory than a number.
pub const JSON_OBJECTS: usize = 1 << 17;

/// Largest number of cells of a log in JSON: its columns times their rows.
pub const JSON_CELLS: usize = 1 << 23;

/// Largest number of bytes of a mesh.
pub const MESH_BYTES: usize = 64 << 20;

/// Largest number of characters of a foreign text that a message shows.
pub const SHOWN_CHARS: usize = 80;

/// The limits as `SECURITY.md` lists them: what is limited, and how many.
#[must_use]
pub fn table() -> [(&'static str, String); 16] {
    [
        ("a line of a log in text", size(LINE_BYTES)),
        ("columns of a log", COLUMNS.to_string()),
        ("a cell", size(CELL_BYTES)),
        ("the name of a column", size(NAME_BYTES)),
        ("a record of MCAP, a buffer of Arrow", size(RECORD_BYTES)),
        ("joints of a robot in an experiment", JOINTS.to_string()),
        ("movable joints of a URDF", URDF_JOINTS.to_string()),
        ("links of a URDF", LINKS.to_string()),
        (
            "an experiment file, a file of parameter values",
            size(EXPERIMENT_BYTES),
        ),
        ("a URDF", size(URDF_BYTES)),
        ("any other text file", size(TEXT_BYTES)),
        ("values of a JSON file", JSON_VALUES.to_string()),
        ("objects of a JSON file", JSON_OBJECTS.to_string()),
        ("cells of a log in JSON", JSON_CELLS.to_string()),
        ("a mesh", size(MESH_BYTES)),
        (
            "characters of a foreign text that a message shows",
            SHOWN_CHARS.to_string(),
        ),
    ]
}

/// Returns a number of bytes in words.
#[must_use]
pub fn size(bytes: usize) -> String {
    match bytes {
        bytes if bytes >= 1 << 20 => format!("{} MiB", bytes >> 20),
        bytes => format!("{} KiB", bytes >> 10),
    }
}

/// Returns the contents of a text file.
///
/// # Errors
///
/// The error of the reader, or [`ErrorKind::FileTooLarge`] beyond [`TEXT_BYTES`].
pub fn read_text_bytes(from: impl Read) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    from.take(TEXT_BYTES as u64 + 1).read_to_end(&mut bytes)?;
    if bytes.len() > TEXT_BYTES {
        return Err(Error::new(
            ErrorKind::FileTooLarge,
            format!(
                "it has more than {}, and a text file is needed",
                size(TEXT_BYTES)
            ),
        ));
    }
    Ok(bytes)
}

/// Checks the number of values of a JSON text before it is read into memory.
///
/// # Errors
///
/// The limit, as a sentence about the file.
pub fn check_json(text: &str) -> std::result::Result<(), String> {
    let (mut values, mut objects) = (1_usize, 0_usize);
    let (mut inside, mut escaped) = (false, false);
    for byte in text.bytes() {
        match byte {
            _ if escaped => escaped = false,
            b'\\' => escaped = inside,
            b'"' => inside = !inside,
            b'{' if !inside => objects += 1,
            b',' | b'[' if !inside => values += 1,
            _ => {}
        }
    }
    if objects > JSON_OBJECTS {
        return Err(format!(
            "it has {objects} objects, and {JSON_OBJECTS} are the most that sprung reads"
        ));
    }
    if values > JSON_VALUES {
        return Err(format!(
            "it has {values} values, and {JSON_VALUES} are the most that sprung reads"
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_and_objects_of_json_are_counted_outside_of_texts() {
        let numbers = |count: usize| format!("[{}1]", "1,".repeat(count));
        let objects = |count: usize| format!("[{}1]", "{},".repeat(count));
        let text = |count: usize| format!("[\"{}\\\"{}\"]", "{,".repeat(count), "[".repeat(count));
        for (text, error) in [
            (numbers(10), None),
            (numbers(JSON_VALUES), Some("values")),
            (objects(JSON_OBJECTS), None),
            (objects(JSON_OBJECTS + 1), Some("objects")),
            (text(JSON_VALUES), None),
        ] {
            let found = check_json(&text).err();
            assert_eq!(found.is_some(), error.is_some(), "{found:?}");
            assert!(
                found
                    .unwrap_or_default()
                    .contains(error.unwrap_or_default())
            );
        }
    }

    #[test]
    fn the_page_on_security_lists_the_limits() {
        let page = std::fs::read_to_string("../../SECURITY.md").unwrap();
        let listed = table().map(|(what, most)| format!("  | {what} | {most} |\n"));
        assert!(page.contains(&listed.concat()), "{}", listed.concat());
    }

    #[test]
    fn an_endless_text_ends() {
        let error = read_text_bytes(std::io::repeat(b'a')).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::FileTooLarge);
        assert!(error.to_string().contains("64 MiB"), "{error}");
    }
}
