//! Files that are cut off, damaged, or of another kind.

use crate::keys::{ARRAYS, MATLAB, NUMBERS, RECORDS, TOPICS, USUAL};
use crate::support::{Files, damage, fixture, messages, read_log, read_text, says};

const ALL: [(&str, &str); 15] = [
    ("log.csv.gz", USUAL),
    ("log.csv.zst", USUAL),
    ("plain.npy", NUMBERS),
    ("records.npy", RECORDS),
    ("plain.npz", ARRAYS),
    ("packed.npz", ARRAYS),
    ("struct.mat", MATLAB),
    ("snappy.parquet", USUAL),
    ("zstd.parquet", USUAL),
    ("file.arrow", USUAL),
    ("stream.arrows", USUAL),
    ("zstd.mcap", TOPICS),
    ("none.mcap", TOPICS),
    ("plain.db3", TOPICS),
    ("defined.db3", TOPICS),
];

fn read_bytes(bytes: Vec<u8>, log: &str) -> Result<Vec<Vec<f64>>, String> {
    read_log(&Files::Memory(vec![("run.log", bytes)]), "run.log", log)
}

#[test]
fn files_that_were_cut_off_are_told() {
    // A text is read up to the place where its stream was cut off, and the check says so.
    let is_text = |file: &str| file.ends_with(".csv.gz") || file.ends_with(".csv.zst");
    for (file, log) in ALL.into_iter().filter(|(file, _)| !is_text(file)) {
        let whole = std::fs::read(fixture(file)).unwrap();
        for part in [0.001, 0.1, 0.5, 0.9] {
            let length = (part * whole.len() as f64) as usize;
            let message = match read_bytes(whole[..length].to_vec(), log) {
                Ok(found) => panic!("{file}, {length} bytes: {} rows", found[0].len()),
                Err(message) => message,
            };
            assert!(message.contains("run.log"), "{file}: {message}");
            if part >= 0.5 {
                let told = ["cut off", "damaged", "ends"]
                    .iter()
                    .any(|word| message.contains(word));
                assert!(told, "{file}, {length} bytes: {message}");
            }
        }
    }
}

/// Changes random bytes. The reader must not panic or hang, and it must refuse a damaged file that has checksums.
#[test]
fn damaged_files_are_errors_or_other_numbers() {
    for (file, log) in ALL {
        let whole = std::fs::read(fixture(file)).unwrap();
        let (mut errors, mut state) = (0_usize, 0x9e37_79b9_7f4a_7c15_u64);
        for _ in 0..150 {
            let bytes = damage(&whole, &mut state);
            errors += usize::from(read_bytes(bytes, log).is_err());
        }
        println!("{file}: {errors} of 150 damaged files are refused");
        if ["log.csv.gz", "packed.npz", "none.mcap"].contains(&file) {
            // Less than a tenth of the bytes have no checksum, and a damage changes three bytes.
            let least = sprung_testing::least_inside(150, 1.0 - 0.1_f64.powi(3));
            assert!(errors >= least, "{file}: {errors}");
        }
    }
}

#[test]
fn what_is_not_read_says_what_it_is() {
    let mut messages = messages("what_is_not_read_says_what_it_is");
    for (name, bytes) in [
        ("a bag of ROS 1", &b"#ROSBAG V2.0\n"[..]),
        ("bzip2", b"BZh91AY"),
        ("UTF-16", b"\xff\xfet\0,\0"),
        ("a program", b"\x7fELF\x02\0\0\0"),
    ] {
        messages.note(name, &read_bytes(bytes.to_vec(), USUAL).unwrap_err());
    }
    let npy = std::fs::read(fixture("plain.npy")).unwrap();
    let packed = zstd::encode_all(&npy[..], 3).unwrap();
    messages.note("a packed array", &read_bytes(packed, NUMBERS).unwrap_err());
    messages.compare();
    // The feature mat73 changes these messages.
    for (bytes, fragments) in [
        (&b"\x89HDF\r\n\x1a\n"[..], ["is HDF5", ".npz"]),
        (b"MATLAB 7.3 MAT-file, Platform", ["version 7.3", "\"-v7\""]),
    ] {
        says(&read_bytes(bytes.to_vec(), USUAL).unwrap_err(), &fragments);
    }
    if cfg!(not(feature = "mat73")) {
        let mat = std::fs::read(fixture("flat73.mat")).unwrap();
        says(
            &read_bytes(mat, USUAL).unwrap_err(),
            &["cargo install", "--features mat73"],
        );
    }
}

#[test]
fn bags_and_tables_are_told_apart() {
    let mut messages = messages("bags_and_tables_are_told_apart");
    let bag = |file: &str, log: &str| read_log(&Files::Fixtures, file, log).unwrap_err();
    for file in ["zstd.mcap", "plain.db3"] {
        for (name, log) in [
            ("no topic", USUAL.to_owned()),
            (
                "another topic",
                TOPICS.replace("/joint_states", "/joint_state"),
            ),
            ("another field", TOPICS.replace("effort", "efort")),
            (
                "other joints",
                TOPICS.replace("unit", "joint_names = [\"a\", \"b\"], unit"),
            ),
            (
                "one other joint",
                TOPICS.replace("unit", "joint_names = [\"joint1\", \"b\"], unit"),
            ),
            (
                "an empty field",
                TOPICS.replace("\"effort\"", "\"velocity\""),
            ),
        ] {
            messages.note(&format!("{file}, {name}"), &bag(file, &log));
        }
    }
    for file in ["zstd.parquet", "plain.npz", "plain.csv"] {
        messages.note(file, &bag(file, TOPICS));
    }
    messages.compare();
}

#[test]
fn columns_that_are_absent_or_no_numbers() {
    let mut messages = messages("columns_that_are_absent_or_no_numbers");
    let header = "t_s;q1_rad;q2_rad;phi1_rad;phi2_rad;tau1_nm;tau2_nm";
    for (file, log) in [
        ("zstd.parquet", USUAL.replace("phi1_rad", "phi_1_rad")),
        ("stamped.parquet", USUAL.replace("phi1_rad", "note")),
        ("struct.mat", MATLAB.replace("data.time", "data.tme")),
        ("flat.mat", NUMBERS.replace("= 1", "= \"note\"")),
        ("bare.txt", USUAL.to_owned()),
        ("plain.npy", NUMBERS.replace('7', "8")),
        ("plain.npz", ARRAYS.replace("q[:,*]", "q*")),
    ] {
        let error = read_log(&Files::Fixtures, file, &log).unwrap_err();
        messages.note(file, &error);
    }
    // Numbers as people write them.
    for number in ["1.234,5", "1,234.5"] {
        let comma = number.ends_with(",5");
        let (zero, time) = if comma {
            ("0,0", "0,001")
        } else {
            ("0.0", "0.001")
        };
        let text = format!("{header}\n{zero};1;2;3;4;5;6\n{time};1;2;3;4;{number};6\n");
        messages.note(number, &read_text(text, USUAL).unwrap_err());
    }
    let ragged = read_text(
        "t_s,q1_rad\n0,1\n0.001\n",
        &USUAL.replace("q*_rad", "q1_rad"),
    );
    messages.note("a short row", &ragged.unwrap_err());
    messages.compare();
}
