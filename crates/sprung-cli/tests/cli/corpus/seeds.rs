//! Seeds of the fuzz targets.

use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

use super::Faulty;
use super::mcap_bytes::{JOINT_STATE, joint_state};

/// Larger files make a fuzzer slow, bytes.
const LARGEST: usize = 100_000;

/// Targets of `fuzz/` by the first bytes of a file. Other files are text.
const TARGETS: [(&[u8], &str); 11] = [
    (b"\x1f\x8b", "compressed"),
    (b"\x28\xb5\x2f\xfd", "compressed"),
    (b"\x93NUMPY", "npy"),
    (b"PK", "npz"),
    (b"MATLAB 7.3", "mat73"),
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
        // An example of logs has no experiment yet.
        let path = path.join(file);
        if path.exists() {
            put(name, file, &std::fs::read(path).unwrap());
        }
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
    meshes(&folder.join("mesh"));
    results(folder);
}

/// Writes a mesh of one triangle, as text and in binary.
fn meshes(folder: &Path) {
    let text = "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\nvertex 0 0.1 0\nendloop\nendfacet\n\
                endsolid\n";
    let corners = [0_f32, 0.0, 1.0, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.1, 0.0];
    let mut binary = vec![0; 80];
    binary.extend(1_u32.to_le_bytes());
    binary.extend(corners.iter().flat_map(|corner| corner.to_le_bytes()));
    binary.extend([0; 2]);
    std::fs::create_dir_all(folder).unwrap();
    std::fs::write(folder.join("text"), text).unwrap();
    std::fs::write(folder.join("binary"), binary).unwrap();
}

/// Writes the results of the demo: short, because a fuzzer repeats them often.
fn results(folder: &Path) {
    let work = TempDir::new().unwrap();
    let demo = work.path().join("sprung-demo");
    let log = "sprung-demo/validation.csv";
    for words in [
        &["demo"][..],
        &["control", "sprung-demo"],
        &["watch", "sprung-demo", "--log", log],
    ] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_sprung"));
        let status = command
            .args(words)
            .arg("--quiet")
            .current_dir(&work)
            .status();
        assert!(status.unwrap().success(), "{words:?}");
    }
    let put = |target: &str, name: &str, bytes: &[u8]| {
        let folder = folder.join(target);
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join(name), bytes).unwrap();
    };
    for (target, name) in [
        ("identification", "identification.json"),
        ("identification", "validation.json"),
        ("control", "control.json"),
        ("watch", "watch.json"),
    ] {
        let text = std::fs::read(demo.join("sprung-out").join(name)).unwrap();
        let json: serde_json::Value = serde_json::from_slice(&text).unwrap();
        put(target, name, json.to_string().as_bytes());
    }
    put("parameters", "truth.toml", sprung::demo::TRUTH.as_bytes());
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap();
    entries.map(|entry| entry.unwrap().path()).collect()
}
