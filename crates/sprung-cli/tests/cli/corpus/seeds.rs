//! Seeds of the fuzz targets.

use std::path::{Path, PathBuf};

use super::Faulty;
use super::mcap_bytes::{JOINT_STATE, joint_state};

/// Larger files make a fuzzer slow, bytes.
const LARGEST: usize = 100_000;

/// Targets of `fuzz/` by the first bytes of a file. Other files are text.
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

/// Writes the files of the corpus, and undamaged files of other programs, into one folder for each target.
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
    let crates = Path::new(env!("CARGO_MANIFEST_DIR"));
    for path in entries(&crates.join("../sprung-log/tests/formats/fixtures")) {
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        put(&name, &name, &std::fs::read(&path).unwrap());
    }
    for path in entries(&crates.join("../../examples")) {
        let file = "experiment.toml";
        let name = path.file_name().unwrap().to_str().unwrap();
        put(name, file, &std::fs::read(path.join(file)).unwrap());
    }
    put(
        "demo",
        "experiment.toml",
        sprung::demo::EXPERIMENT.as_bytes(),
    );
    // A definition, and a message after a zero.
    let state = joint_state(7, &["joint1", "joint2"], &[0.1, 0.2], &[1.0, 2.0]);
    let messages = folder.join("ros_message");
    std::fs::create_dir_all(&messages).unwrap();
    for (name, definition, message) in [
        ("joint-state", JOINT_STATE, &state[..]),
        (
            "nested",
            "my_msgs/Part[<=3] position\nbool[4] effort\nwstring x \"a\"\nint8 A=3\n\
             ================================================================================\n\
             MSG: my_msgs/Part\nint8 a 5\nstring<=9[2] names\nuint64[] b [1, 2]\n",
            &[0, 1, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0],
        ),
    ] {
        let seed = [definition.as_bytes(), &[0], message].concat();
        std::fs::write(messages.join(name), seed).unwrap();
    }
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap();
    entries.map(|entry| entry.unwrap().path()).collect()
}
