//! Files that a fuzzer begins with.

use std::path::Path;

use super::Faulty;

/// Files larger than this make a fuzzer slow.
const LARGEST: usize = 100_000;

/// Targets of `fuzz/` by how a file begins; the rest is text.
const TARGETS: [(&[u8], &str); 10] = [
    (b"\x1f\x8b", "compressed"),
    (b"\x28\xb5\x2f\xfd", "compressed"),
    (b"\x93NUMPY", "npy"),
    (b"PK", "npz"),
    (b"MATLAB", "mat"),
    (b"PAR1", "parquet"),
    (b"ARROW1", "arrow"),
    (b"\xff\xff\xff\xff", "arrow"),
    (b"\x89MCAP", "mcap"),
    (b"SQLite", "db3"),
];

fn target(file: &str, bytes: &[u8]) -> &'static str {
    if file == "experiment.toml" {
        return "experiment";
    }
    if file == "robot.urdf" {
        return "urdf";
    }
    let known = TARGETS.iter().find(|(magic, _)| bytes.starts_with(magic));
    known.map_or("csv", |(_, target)| target)
}

/// Writes the files of the corpus, and the whole ones of other programs, to a folder for each
/// target.
pub(super) fn write(folder: &Path, corpus: &[Faulty]) {
    let put = |name: &str, file: &str, bytes: &[u8]| {
        let folder = folder.join(target(file, bytes));
        std::fs::create_dir_all(&folder).unwrap();
        if bytes.len() <= LARGEST {
            std::fs::write(folder.join(name), bytes).unwrap();
        }
    };
    for faulty in corpus {
        for (file, bytes) in &faulty.files {
            put(&faulty.name.replace([' ', '/'], "-"), file, bytes);
        }
    }
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../sprung/tests/formats/fixtures");
    for entry in std::fs::read_dir(fixtures).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        put(&name, &name, &std::fs::read(&path).unwrap());
    }
}
