//! MATLAB 7.3: HDF5 files as MATLAB lays them out.

use std::ops::Range;
use std::path::{Path, PathBuf};

use hdf5_metno as hdf5;

use crate::keys::{MATLAB, NUMBERS};
use crate::support::{Files, difference, fixture, random, read_log, says, truth};

/// Columns of flat73.mat, as of flat.mat.
const FLAT: &str = r#"
time_s = "t"
link_position_rad = "q(:,*)"
motor_position_rad = ["phi(1,:)", "phi(2, :)"]
motor_torque_nm = ["tau1(:,1)", "tau2"]
"#;

/// Writes a file where HDF5 can open it, and reads it.
fn read_bytes(name: &str, bytes: &[u8], log: &str) -> Result<Vec<Vec<f64>>, String> {
    let path = folder(name).join("run.log");
    std::fs::write(&path, bytes).unwrap();
    read_log(&Files::Folder(folder(name)), "run.log", log)
}

/// A folder for one test.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("mat73-{name}"));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn the_same_numbers_as_from_other_formats() {
    // Contiguous, big-endian, and packed in chunks within structures.
    for (file, log) in [("flat73.mat", FLAT), ("struct73.mat", MATLAB)] {
        let found = read_log(&Files::Fixtures, file, log).unwrap();
        let worst = difference(&found, &truth());
        println!("{file}: {worst:.1e}");
        assert!(worst <= 1e-12, "{file}: {worst}");
    }
}

#[test]
fn every_class_of_numbers() {
    let read = |first: &str, second: &str, time: &str| {
        let log = format!(
            "{time}\nlink_position_rad = [\"{first}\", \"{second}\"]\nmotor_position_rad = \"phi(*,:)\"\n\
             motor_torque_nm = [\"tau1\", \"tau2\"]"
        );
        read_log(&Files::Fixtures, "flat73.mat", &log).unwrap()
    };
    let whole = read("counts_i8", "q(:,1)", "time_s = \"t\"");
    let truth = truth();
    for (found, q) in whole[1].iter().zip(&truth[1]) {
        let off = (found - q * 1e6).rem_euclid(100.0);
        // A rounded count is at most half a count away; 0.001 counts are a margin for the arithmetic.
        assert!(off.min(100.0 - off) < 0.501, "{found} {q}");
    }
    for class in ["f4", "i1", "i2", "i4", "u8"] {
        let found = read(&format!("counts_{class}"), "on", "time_s = \"t\"");
        assert_eq!(found[1], whole[1], "{class}");
        for (on, q) in found[2].iter().zip(&truth[1]) {
            assert_eq!(*on > 0.5, *q > 0.0);
        }
    }
    // Nanoseconds since 1970, exactly.
    let stamped = read("q(:,1)", "q(:,2)", "time_ns = \"stamp\"");
    assert!(difference(&stamped, &truth) <= 1e-12);
}

#[test]
fn what_is_no_numbers_is_told() {
    for (name, why) in [
        ("note", "\"note\" is text"),
        ("cells", "\"cells\" is a cell array"),
        ("few", "\"few\" is sparse; save full(…) of it"),
        ("turning", "\"turning\" is complex"),
        ("turning(:,1)", "\"turning\" is complex"),
        ("frame", "\"frame\" is an object (a table"),
        (
            "cube(:,1)",
            "\"cube\" is an array of 40 × 3 × 2, and a log has two dimensions; reshape it",
        ),
        ("nothing", "has no column \"nothing\""),
        ("rate", "has no column \"rate\""),
        ("tau_1", "has no column \"tau_1\"; did you mean \"tau1\"?"),
    ] {
        let log = FLAT.replace("\"t\"", &format!("\"{name}\""));
        let message = read_log(&Files::Fixtures, "flat73.mat", &log).unwrap_err();
        says(&message, &["flat73.mat", why]);
    }
    let message = read_log(
        &Files::Fixtures,
        "struct73.mat",
        &MATLAB.replace("data.time", "data.signals(2).label"),
    );
    says(
        &message.unwrap_err(),
        &["\"data.signals(2).label\" is text"],
    );
}

#[test]
fn a_log_in_memory_is_told_to_be_a_file() {
    let bytes = std::fs::read(fixture("flat73.mat")).unwrap();
    let files = Files::Memory(vec![("run.log", bytes)]);
    let message = read_log(&files, "run.log", FLAT).unwrap_err();
    says(&message, &["read from a file and not from memory"]);
}

#[test]
fn files_that_were_cut_off_are_told() {
    for (file, log) in [("flat73.mat", FLAT), ("struct73.mat", MATLAB)] {
        let whole = std::fs::read(fixture(file)).unwrap();
        for part in [0.001, 0.1, 0.5, 0.9, 0.999] {
            let length = (part * whole.len() as f64) as usize;
            let message = read_bytes("cut", &whole[..length], log).unwrap_err();
            assert!(message.contains("run.log"), "{file}: {message}");
            if part >= 0.1 {
                says(&message, &["cut off"]);
            }
            // A message must be short: a few lines of a terminal.
            assert!(message.len() < 500, "{message}");
        }
    }
    let head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64";
    let message = read_bytes("head", head, NUMBERS).unwrap_err();
    says(&message, &["run.log"]);
}

#[test]
fn a_driver_that_claims_gigabytes_is_refused() {
    let mut bytes = std::fs::read(fixture("flat73.mat")).unwrap();
    // MATLAB's block of 512 bytes, the head of a superblock of version 0, and three addresses.
    assert_eq!((&bytes[513..516], bytes[520]), (&b"HDF"[..], 0));
    let address = 512 + 24 + 3 * 8;
    bytes[address..address + 8].copy_from_slice(&512_u64.to_le_bytes());
    let message = read_bytes("driver", &bytes, FLAT).unwrap_err();
    says(&message, &["its header", "it names a driver"]);
}

/// Outcome of a damaged file.
#[derive(Debug, PartialEq)]
enum Outcome {
    Refused(String),
    Same,
    Changed(Vec<Vec<f64>>),
}

/// A file that is read again with one byte changed.
struct Damaged {
    name: &'static str,
    log: &'static str,
    whole: Vec<u8>,
    truth: Vec<Vec<f64>>,
}

impl Damaged {
    fn of(name: &'static str, file: &str, log: &'static str) -> Self {
        let whole = std::fs::read(fixture(file)).unwrap();
        let truth = read_bytes(name, &whole, log).unwrap();
        Self {
            name,
            log,
            whole,
            truth,
        }
    }

    /// Reads the file with a bit pattern laid over one of its bytes.
    fn read(&self, at: usize, pattern: u8) -> Outcome {
        let mut bytes = self.whole.clone();
        bytes[at] ^= pattern;
        match read_bytes(self.name, &bytes, self.log) {
            Ok(found) if found == self.truth => Outcome::Same,
            Ok(found) => Outcome::Changed(found),
            Err(message) => Outcome::Refused(message),
        }
    }

    /// Returns where compressed chunks begin and end. zlib puts a checksum after each.
    fn chunks(&self) -> Vec<Range<usize>> {
        let mut chunks = Vec::new();
        for at in 0..self.whole.len() - 1 {
            if self.whole[at..].starts_with(&[0x78, 0x5e]) {
                let mut read = flate2::bufread::ZlibDecoder::new(&self.whole[at..]);
                if std::io::copy(&mut read, &mut std::io::sink()).is_ok() {
                    chunks.push(at..at + read.total_in() as usize);
                }
            }
        }
        chunks
    }
}

/// Whether a message states the fault of a damaged file: the unreadable part and the remedy, the name that is missing
/// or is no array of numbers, or the implausible number.
fn explains(message: &str) -> bool {
    let all = |parts: &[&str]| parts.iter().all(|part| message.contains(part));
    message.contains("run.log")
        && (all(&[" is damaged (", "copy or record it again"])
            || all(&["ends in the middle of", "copy or record it again"])
            || all(&["has no column \""])
            || all(&["\" is ", "that is not read"])
            || all(&["\" is a reference to an object that the file does not contain"])
            || all(&[" rows and \"", "the channels of a log are of one length"])
            || all(&["is an array of", "reshape it"])
            || all(&["column \"", "every sample must be a finite number"])
            || all(&["time goes from", "samples must be in order"])
            || all(&["is binary and none of the formats that are read"]))
}

#[test]
fn damage_in_compressed_numbers_is_found_by_their_checksum() {
    let file = Damaged::of("chunks", "struct73.mat", MATLAB);
    let chunks = file.chunks();
    // Chunks of the time, of q, of phi and of tau.
    assert_eq!(chunks.len(), 4 + 5 + 2 * 3 + 4);
    for at in chunks.into_iter().flatten().step_by(31) {
        let Outcome::Refused(message) = file.read(at, 0x24) else {
            panic!("byte {at} is damaged, and the file is read")
        };
        let parts = [
            "run.log: \"data.",
            " is damaged (",
            "copy or record it again",
        ];
        says(&message, &parts);
    }
}

/// HDF5 has no checksum for numbers that are not compressed, so a damaged number is read as another number.
#[test]
fn damage_in_plain_numbers_changes_that_number_alone() {
    let file = Damaged::of("plain", "flat73.mat", FLAT);
    let bytes = file.truth[1].iter().flat_map(|x| x.to_le_bytes());
    let bytes: Vec<u8> = bytes.collect();
    let mut windows = file.whole.windows(bytes.len());
    let start = windows.position(|window| window == bytes).unwrap();
    for row in (0..file.truth[1].len()).step_by(40) {
        let Outcome::Changed(mut found) = file.read(start + 8 * row + 5, 0x24) else {
            panic!("row {row}: not changed")
        };
        assert!((found[1][row] - file.truth[1][row]).abs() > 0.0);
        found[1][row] = file.truth[1][row];
        assert_eq!(found, file.truth);
    }
}

/// Changes one byte anywhere: names, types, shapes, places and numbers. MATLAB writes version 0 of HDF5, which
/// has checksums in compressed numbers only; elsewhere a changed number may pass.
#[test]
fn any_damaged_byte_is_explained_or_without_checksum() {
    for (name, file, log) in [
        ("any-flat", "flat73.mat", FLAT),
        ("any-struct", "struct73.mat", MATLAB),
    ] {
        let file = Damaged::of(name, file, log);
        let chunks = file.chunks();
        let (mut refused, mut same, mut changed) = (0, 0, 0);
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        for _ in 0..300 {
            let number = random(&mut state);
            let at = (number >> 16) as usize % file.whole.len();
            match file.read(at, (number >> 8) as u8 | 1) {
                Outcome::Refused(message) => {
                    assert!(explains(&message), "byte {at}: {message}");
                    refused += 1;
                }
                Outcome::Same => same += 1,
                Outcome::Changed(_) => {
                    let sealed = chunks.iter().any(|chunk| chunk.contains(&at));
                    assert!(!sealed, "byte {at} has a checksum and changes numbers");
                    changed += 1;
                }
            }
        }
        println!(
            "{name}: of 300 files with a damaged byte {refused} are refused, {same} give the same numbers, \
             {changed} give others"
        );
        assert!(refused > 0 && same > 0, "{refused} {same}");
    }
}

/// Writes a variable as MATLAB does.
fn variable(file: &hdf5::File, name: &str, shape: [usize; 2], chunk: [usize; 2], value: &[f64]) {
    let builder = file.new_dataset::<f64>().shape(shape).chunk(chunk);
    let dataset = builder.deflate(1).create(name).unwrap();
    dataset.write_raw(value).unwrap();
}

#[test]
fn long_arrays_are_read_in_parts() {
    const ROWS: usize = 50_000;
    let path = folder("long").join("run.log");
    let time: Vec<f64> = (0..ROWS).map(|k| k as f64 / 1000.0).collect();
    let wave = |k: usize| (0..ROWS).map(move |i| (0.001 * i as f64 + k as f64).sin());
    let file = hdf5::File::with_options()
        .with_fcpl(|create| create.userblock(512))
        .create(&path)
        .unwrap();
    // Chunks along one column, across both, across rows, and one of the whole array.
    variable(&file, "t", [1, ROWS], [1, 1000], &time);
    let pair = |a, b| wave(a).chain(wave(b)).collect::<Vec<f64>>();
    variable(&file, "q", [2, ROWS], [2, 30_000], &pair(0, 1));
    let rows = wave(2).zip(wave(3)).flat_map(|(a, b)| [a, b]);
    let rows: Vec<f64> = rows.collect();
    variable(&file, "phi", [ROWS, 2], [7000, 1], &rows);
    variable(&file, "tau", [2, ROWS], [2, ROWS], &pair(4, 5));
    file.close().unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    let head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64";
    bytes[..head.len()].copy_from_slice(head);
    let log = r#"
time_s = "t"
link_position_rad = "q(:,*)"
motor_position_rad = "phi(*,:)"
motor_torque_nm = "tau(:,*)"
"#;
    let found = read_bytes("long", &bytes, log).unwrap();
    let mut truth = vec![time];
    truth.extend((0..6).map(|k| wave(k).collect()));
    assert!(difference(&found, &truth) <= 1e-12);
}
