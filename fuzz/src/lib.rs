//! Functions shared by the fuzz targets. They read files in memory as a session reads those of a
//! user.
//!
//! An error is an acceptable outcome. A panic, an endless loop or unbounded memory is a fault.

// Writes the bytes of a bag, in the same way as the tests.
#[path = "../../crates/sprung-log/tests/formats/mcap_bytes.rs"]
#[allow(dead_code, clippy::unwrap_used, reason = "made for tests")]
mod mcap_bytes;

#[path = "../../crates/sprung-log/tests/formats/keys.rs"]
pub mod keys;

pub mod results;

use std::fs::File;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use sprung::model::Model;
use sprung_log::{Channels, Input, LogBlock, LogFile, LogSource, Opener, panics_are_caught};
use sprung_robot::{Experiment, NamedFiles, no_files, read};

const ROBOT: &str = r#"
format = 1
[robot]
name = "two joints"
kinematics = "planar-2r"
[[robot.joint]]
name = "joint1"
[[robot.joint]]
name = "joint2"
[log]
"#;

/// Reads a log in memory to its end.
///
/// - `keys`: the keys of `[log]`, one of the constants in [`keys`].
///
/// # Panics
///
/// If the keys are wrong; they do not depend on the input.
pub fn read_log(data: &[u8], keys: &str) {
    let bytes = data.to_vec();
    let mut reader = |_: Option<&Path>| -> std::io::Result<Box<dyn Input>> {
        Ok(Box::new(Cursor::new(bytes.clone())))
    };
    read_with(&mut reader, keys);
}

/// Reads a log in a file to its end.
///
/// # Panics
///
/// If the keys are wrong or the temporary folder cannot be written.
pub fn read_log_file(data: &[u8], keys: &str) {
    let path = written("run.log", data);
    let mut reader = |_: Option<&Path>| -> std::io::Result<Box<dyn Input>> {
        Ok(Box::new(LogFile::new(File::open(&path)?, &path)))
    };
    read_with(&mut reader, keys);
}

fn read_with<'a>(reader: &'a mut Opener<'a>, keys: &str) {
    expect_some_panics();
    let text = format!("{ROBOT}{keys}");
    let experiment = read("experiment.toml", &text, &[], &mut no_files).expect("these are right");
    let log = experiment.log.as_ref().expect("it is there");
    let channels = Channels::new(&experiment.robot, log).expect("these are right");
    let mut source = LogSource::files("run.log", reader);
    let Ok(mut log) = source.open(&channels) else {
        return;
    };
    let mut block = LogBlock::new(channels.all.len());
    while let Ok(true) = log.read(&mut block) {}
}

/// Writes a file into the temporary folder of this process and returns its path.
fn written(name: &str, data: &[u8]) -> PathBuf {
    let path = std::env::temp_dir()
        .join(format!("sprung-fuzz-{}", std::process::id()))
        .join(name);
    let folder = path.parent().expect("it has one");
    std::fs::create_dir_all(folder).expect("the temporary folder can be written");
    std::fs::write(&path, data).expect("the temporary folder can be written");
    path
}

/// Suppresses panics that the readers of logs catch. Some crates panic on damaged files, and
/// libFuzzer ends at any panic that reaches its hook.
fn expect_some_panics() {
    static ONCE: std::sync::Once = std::sync::Once::new();
    ONCE.call_once(|| {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            if !panics_are_caught() {
                before(info);
            }
        }));
    });
}

/// Returns a bag with a message definition (the data up to the first zero) and three messages with
/// equal contents.
#[must_use]
pub fn bag_of(data: &[u8]) -> Vec<u8> {
    let end = data
        .iter()
        .position(|&byte| byte == 0)
        .unwrap_or(data.len());
    let definition = String::from_utf8_lossy(&data[..end]);
    let mut records = mcap_bytes::topic("my_msgs/msg/State", &definition, "cdr");
    for k in 1..4 {
        records.extend(mcap_bytes::message(k * 1_000_000, &data[end..]));
    }
    mcap_bytes::file_of(&records)
}

/// Reads an experiment and makes the model of its robot.
pub fn read_experiment(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else {
        return;
    };
    if let Ok(experiment) = read("experiment.toml", text, &[], &mut no_files) {
        use_experiment(&experiment);
    }
}

/// Reads a URDF file as a robot with one joint.
pub fn read_urdf(data: &[u8]) {
    let Ok(urdf) = std::str::from_utf8(data) else {
        return;
    };
    let text = "format = 1\n[robot]\nname = \"r\"\nurdf = \"robot.urdf\"\n\
                [[robot.joint]]\nname = \"joint1\"\n";
    let mut open = |_: &Path| Ok(urdf.to_owned());
    if let Ok(experiment) = read("experiment.toml", text, &[], &mut open) {
        use_experiment(&experiment);
    }
}

/// A robot whose link has a mesh and no inertia.
const WITH_MESH: &str = "<robot name='r'><link name='base'/><link name='upper'>\
     <collision><geometry><mesh filename='upper.stl'/></geometry></collision></link>\
     <joint name='joint1' type='continuous'><parent link='base'/><child link='upper'/></joint></robot>";

struct WithMesh<'a>(&'a [u8]);

impl NamedFiles for WithMesh<'_> {
    fn text(&mut self, _: &Path) -> std::io::Result<String> {
        Ok(WITH_MESH.to_owned())
    }

    fn bytes(&mut self, _: &Path, _: u64) -> std::io::Result<Vec<u8>> {
        Ok(self.0.to_vec())
    }
}

/// Reads a mesh of a robot with one joint.
pub fn read_mesh(data: &[u8]) {
    let text = "format = 1\n[robot]\nname = \"r\"\nurdf = \"robot.urdf\"\n\
                [[robot.joint]]\nname = \"joint1\"\n";
    if let Ok(experiment) = read("experiment.toml", text, &[], &mut WithMesh(data)) {
        use_experiment(&experiment);
    }
}

fn use_experiment(experiment: &Experiment) {
    let _ = Model::new(experiment);
    if let Some(log) = &experiment.log {
        let _ = Channels::new(&experiment.robot, log);
    }
}
