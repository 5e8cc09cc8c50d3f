//! Points of a mesh in STL.

use std::io::Cursor;

/// Bytes of a binary file before its triangles, and of each triangle.
const HEAD: usize = 84;
const TRIANGLE: usize = 50;

/// More bytes than the reader takes ahead.
const AHEAD: usize = 64 << 10;

/// Returns the corners of the triangles of an STL file, ASCII or binary.
///
/// # Errors
///
/// What is wrong with the file, as the end of a sentence.
pub(super) fn corners(mut bytes: Vec<u8>) -> Result<Vec<[f64; 3]>, String> {
    let count = (bytes.get(80..HEAD))
        .and_then(|bytes| bytes.try_into().ok())
        .map(|bytes| u64::from(u32::from_le_bytes(bytes)));
    let expected = count.map(|count| HEAD as u64 + TRIANGLE as u64 * count);
    let is_ascii = bytes.starts_with(b"solid") && expected != Some(bytes.len() as u64);
    if is_ascii {
        // The reader expects a name, which may be empty.
        bytes.insert(b"solid".len(), b' ');
    } else {
        match (count, expected) {
            (Some(count), Some(expected)) if expected > bytes.len() as u64 => {
                let there = (bytes.len() - HEAD) / TRIANGLE;
                return Err(format!(
                    "its header announces {count} triangles, but it has {there}; is the file complete?"
                ));
            }
            (Some(_), _) => (),
            (None, _) => return Err("it is too short for an STL file".to_owned()),
        }
        // The headers of some binary files begin like an ASCII file.
        bytes[0] = 0;
    }
    let mut cursor = Cursor::new(bytes);
    let triangles = stl_io::create_stl_reader(&mut cursor).map_err(|error| error.to_string())?;
    let mut corners = Vec::new();
    for triangle in triangles {
        for corner in triangle.map_err(|error| error.to_string())?.vertices {
            let corner = corner.0.map(f64::from);
            if corner.iter().any(|x| !x.is_finite()) {
                return Err("a corner of a triangle is not a number".to_owned());
            }
            corners.push(corner);
        }
    }
    if is_ascii {
        let read = cursor.position() as usize;
        several_solids(cursor.get_ref().get(read.saturating_sub(AHEAD)..))?;
    }
    if corners.is_empty() {
        return Err("it has no triangles".to_owned());
    }
    Ok(corners)
}

/// The reader ends at the end of the first solid.
fn several_solids(last: Option<&[u8]>) -> Result<(), String> {
    let words = last.unwrap_or_default().windows(8);
    let ends = words.filter(|word| *word == b"endsolid").count();
    if ends > 1 {
        return Err(
            "it has several solids, of which only the first would be read; join them in one"
                .to_owned(),
        );
    }
    Ok(())
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// The twelve triangles of a box between two corners, m.
    fn triangles(least: [f32; 3], largest: [f32; 3]) -> Vec<stl_io::Triangle> {
        let corner = |k: usize| {
            stl_io::Vertex::new(std::array::from_fn(|i| {
                if k >> i & 1 == 1 {
                    largest[i]
                } else {
                    least[i]
                }
            }))
        };
        let sides = [
            [0, 1, 3, 2],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 3, 7, 6],
            [0, 2, 6, 4],
            [1, 3, 7, 5],
        ];
        let halves = sides
            .into_iter()
            .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
        halves
            .map(|half| stl_io::Triangle {
                normal: stl_io::Normal::new([0.0; 3]),
                vertices: half.map(corner),
            })
            .collect()
    }

    pub(crate) fn binary(least: [f32; 3], largest: [f32; 3]) -> Vec<u8> {
        let mut bytes = Vec::new();
        stl_io::write_stl(&mut bytes, triangles(least, largest).iter()).unwrap();
        bytes
    }

    pub(crate) fn ascii(least: [f32; 3], largest: [f32; 3]) -> Vec<u8> {
        let facets = triangles(least, largest).into_iter().map(|triangle| {
            let corners = triangle
                .vertices
                .map(|v| format!("vertex {} {} {}\n", v[0], v[1], v[2]));
            format!(
                "facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n",
                corners.concat()
            )
        });
        format!("solid\n{}endsolid\n", facets.collect::<String>()).into_bytes()
    }

    #[test]
    fn a_cube_is_the_same_in_ascii_and_binary() {
        let ends = ([-0.5, 0.0, 0.25], [0.5, 1.0, 1.25]);
        let found = corners(binary(ends.0, ends.1)).unwrap();
        assert_eq!(found.len(), 36);
        assert_eq!(found, corners(ascii(ends.0, ends.1)).unwrap());
        assert!(found.contains(&[0.5, 1.0, 1.25]) && found.contains(&[-0.5, 0.0, 0.25]));
        // Some programs write this word into the header of a binary file.
        let mut named = binary(ends.0, ends.1);
        named[..6].copy_from_slice(b"solid ");
        assert_eq!(corners(named).unwrap(), found);
    }

    #[test]
    fn broken_files_are_refused_with_their_fault() {
        let ends = ([0.0; 3], [1.0; 3]);
        let mut nan = binary(ends.0, ends.1);
        nan[HEAD + 12..HEAD + 16].copy_from_slice(&f32::NAN.to_le_bytes());
        let mut cut = ascii(ends.0, ends.1);
        cut.truncate(200);
        let two = [ascii(ends.0, ends.1), ascii(ends.0, ends.1)].concat();
        for (bytes, fault) in [
            (
                binary(ends.0, ends.1)[..400].to_vec(),
                "announces 12 triangles, but it has 6",
            ),
            (b"PK".to_vec(), "too short"),
            (vec![0; HEAD], "no triangles"),
            (nan, "not a number"),
            (cut, "got"),
            (b"solid cube".to_vec(), "EOF"),
            (b"solid cube\nendsolid".to_vec(), "no triangles"),
            (two, "several solids"),
        ] {
            let found = corners(bytes).unwrap_err();
            assert!(found.contains(fault), "{found}");
        }
    }

    #[test]
    fn no_mesh_makes_it_panic() {
        for text in [ascii([0.0; 3], [1.0; 3]), binary([0.0; 3], [1.0; 3])] {
            for end in 0..text.len() {
                let _ = corners(text[..end].to_vec());
                let mut other = text.clone();
                other[end] ^= 0x55;
                let _ = corners(other);
            }
        }
    }
}
