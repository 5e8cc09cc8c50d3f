//! A robot with two joints, and logs of it.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use sprung_log::{Channels, Input, LogBlock, LogError, LogFile, LogSource, Timing};
use sprung_robot::{Experiment, Window, no_files, read};
use sprung_testing::Messages;

const ROBOT: &str = r#"
format = 1
[robot]
name = "two joints"
kinematics = "planar-2r"
[[robot.joint]]
name = "joint1"
torque_constant_nm_per_a = 2.0
torque_constant_side = "output"
gear_ratio = 10.0
[[robot.joint]]
name = "joint2"
torque_constant_nm_per_a = 4.0
torque_constant_side = "output"
gear_ratio = 100.0
[log]
"#;

/// A folder, or files in memory.
#[derive(Clone)]
pub(crate) enum Files {
    Fixtures,
    Folder(PathBuf),
    Memory(Vec<(&'static str, Vec<u8>)>),
}

/// A file that `make_fixtures.py` wrote: of the repository, or of the folder `SPRUNG_TEST_FORMATS`.
pub(crate) fn fixture(name: &str) -> PathBuf {
    let fixtures = || Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/formats/fixtures");
    let other = std::env::var_os("SPRUNG_TEST_FORMATS").map(PathBuf::from);
    other.unwrap_or_else(fixtures).join(name)
}

pub(crate) fn experiment(log: &str) -> Result<Experiment, String> {
    let text = format!("{ROBOT}{log}");
    read("experiment.toml", &text, &[], &mut no_files).map_err(|error| error.to_string())
}

/// Reads a log: time, then the channels in the order of `Channels::all`.
pub(crate) fn read_log(files: &Files, file: &str, log: &str) -> Result<Vec<Vec<f64>>, String> {
    let experiment = experiment(log)?;
    let channels = Channels::new(&experiment.robot, experiment.log.as_ref().unwrap())
        .map_err(|error| error.to_string())?;
    read_channels(files, file, &channels).map_err(|error| error.to_string())
}

pub(crate) fn read_channels(
    files: &Files,
    file: &str,
    channels: &Channels,
) -> Result<Vec<Vec<f64>>, LogError> {
    read_timed(files, file, channels).map(|found| found.columns)
}

fn open(path: &Path) -> std::io::Result<Box<dyn Input>> {
    Ok(Box::new(LogFile::new(std::fs::File::open(path)?, path)))
}

/// Content of a log.
pub(crate) struct Found {
    /// Time, then the channels.
    pub(crate) columns: Vec<Vec<f64>>,
    /// Indices of samples that follow a gap.
    pub(crate) gaps: Vec<usize>,
    pub(crate) timing: Timing,
}

pub(crate) fn read_timed(
    files: &Files,
    file: &str,
    channels: &Channels,
) -> Result<Found, LogError> {
    read_window(files, file, channels, Window::default())
}

pub(crate) fn read_window(
    files: &Files,
    file: &str,
    channels: &Channels,
    window: Window,
) -> Result<Found, LogError> {
    let (files, path) = (files.clone(), PathBuf::from(file));
    let mut reader = move |other: Option<&Path>| -> std::io::Result<Box<dyn Input>> {
        let name = other.unwrap_or(&path).to_str().unwrap().to_owned();
        match &files {
            Files::Fixtures => open(&fixture(&name)),
            Files::Folder(folder) => open(&folder.join(&name)),
            Files::Memory(all) => match all.iter().find(|(known, _)| *known == name) {
                Some((_, bytes)) => Ok(Box::new(Cursor::new(bytes.clone()))),
                None => Err(std::io::ErrorKind::NotFound.into()),
            },
        }
    };
    read_source(
        &mut LogSource::files(file, &mut reader).within(window),
        channels,
    )
}

/// Reads a source to its end.
pub(crate) fn read_source(
    source: &mut LogSource<'_>,
    channels: &Channels,
) -> Result<Found, LogError> {
    let mut log = source.open(channels)?;
    let mut block = LogBlock::new(channels.all.len());
    let mut all = vec![Vec::new(); 1 + channels.all.len()];
    let mut gaps = Vec::new();
    while log.read(&mut block)? {
        gaps.extend(block.gaps.iter().map(|gap| all[0].len() + gap));
        all[0].extend_from_slice(&block.time);
        for (column, values) in all[1..].iter_mut().zip(&block.values) {
            column.extend_from_slice(values);
        }
    }
    Ok(Found {
        columns: all,
        gaps,
        timing: log.timing(),
    })
}

/// Reads a text of bytes in memory.
pub(crate) fn read_text(text: impl AsRef<[u8]>, log: &str) -> Result<Vec<Vec<f64>>, String> {
    let files = Files::Memory(vec![("log.csv", text.as_ref().to_vec())]);
    read_log(&files, "log.csv", log)
}

/// The numbers that all fixtures contain, read from `plain.csv` by other code.
pub(crate) fn truth() -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(fixture("plain.csv")).unwrap();
    let mut columns = vec![Vec::new(); 7];
    for line in text.lines().skip(1) {
        for (column, cell) in columns.iter_mut().zip(line.split(',')) {
            column.push(cell.parse::<f64>().unwrap());
        }
    }
    columns
}

/// The largest difference between two logs of the same shape.
pub(crate) fn difference(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    assert_eq!(a.len(), b.len());
    let mut worst = 0.0_f64;
    for (a, b) in a.iter().zip(b) {
        assert_eq!(a.len(), b.len());
        for (x, y) in a.iter().zip(b) {
            worst = worst.max((x - y).abs());
        }
    }
    worst
}

/// Messages of a test, whose file is in `tests/messages`.
pub(crate) fn messages(test: &str) -> Messages {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/messages");
    Messages::new(format!("{folder}/{test}.txt"))
}

/// Checks that a message contains all fragments.
pub(crate) fn says(message: &str, fragments: &[&str]) {
    for fragment in fragments {
        assert!(message.contains(fragment), "no {fragment:?} in: {message}");
    }
}

/// Returns a copy in which up to three bytes are changed.
///
/// - `state`: state of the random numbers, not zero.
pub(crate) fn damage(whole: &[u8], state: &mut u64) -> Vec<u8> {
    let mut bytes = whole.to_vec();
    for _ in 0..3 {
        let number = random(state);
        let at = (number >> 16) as usize % bytes.len();
        bytes[at] = (number >> 8) as u8;
    }
    bytes
}

/// Returns the next number of xorshift64.
///
/// - `state`: of the random numbers, not zero.
pub(crate) fn random(state: &mut u64) -> u64 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    *state
}
