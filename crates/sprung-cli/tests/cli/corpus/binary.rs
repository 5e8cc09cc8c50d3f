//! Binary files that are cut off, damaged, or of another kind than their name.

use super::keys::{ARRAYS, MATLAB, NUMBERS, RECORDS, TOPICS, USUAL};
use super::{Faulty, fixture};

/// A file of each format, and the keys that read it.
const FORMATS: [(&str, &str); 16] = [
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
    ("lz4.mcap", TOPICS),
    ("none.mcap", TOPICS),
    ("plain.db3", TOPICS),
    ("defined.db3", TOPICS),
];

/// Messages about files without their second half, in the order of `FORMATS`.
const CUT_OFF: [&str; 16] = [
    "log-cut-off",
    "its zstd stream: it was cut off",
    "cut off",
    "cut off",
    "cut off",
    "cut off",
    "cut off",
    "is damaged or was cut off",
    "is damaged or was cut off",
    "is damaged or was cut off",
    "is damaged or was cut off",
    "cut off",
    "cut off",
    "cut off",
    "cut off",
    "cut off",
];

pub(super) fn all() -> Vec<Faulty> {
    [
        cut_off(),
        damaged(),
        in_disguise(),
        npy(),
        mat73(),
        others(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn cut_off() -> Vec<Faulty> {
    let one = |((file, keys), says): (&(&str, &str), &'static str)| {
        let mut bytes = fixture(file);
        bytes.truncate(bytes.len() / 2);
        // Of a text the samples before its end are read.
        let code = if says == "log-cut-off" { 0 } else { 3 };
        Faulty::log(&format!("half of {file}"), bytes, keys, &[says]).code(code)
    };
    FORMATS.iter().zip(CUT_OFF).map(one).collect()
}

/// Files with an overwritten part, in formats where a checksum or the compression reveals it.
fn damaged() -> Vec<Faulty> {
    let told = [
        ("log.csv.gz", "its gzip stream is damaged"),
        ("log.csv.zst", "is not a number"),
        ("packed.npz", "its checksum is wrong"),
        ("struct.mat", "damaged"),
        ("snappy.parquet", "is damaged"),
        ("zstd.parquet", "is damaged"),
        ("stream.arrows", "is damaged"),
        ("zstd.mcap", "damaged"),
        ("lz4.mcap", "damaged"),
    ];
    let one = |(file, says): (&str, &'static str)| {
        let mut bytes = fixture(file);
        // A quarter into most files there are numbers. In this file there is an index that sprung does not read.
        let begin = match file {
            "lz4.mcap" => 17 * bytes.len() / 20,
            _ => bytes.len() / 4,
        };
        for byte in &mut bytes[begin..begin + 64] {
            *byte = !*byte;
        }
        let keys = FORMATS.iter().find(|(name, _)| *name == file).unwrap().1;
        Faulty::log(&format!("{file} written over"), bytes, keys, &[says])
    };
    told.into_iter().map(one).collect()
}

/// Files with a wrong name: sprung recognises a file by its first bytes, not by its name.
fn in_disguise() -> Vec<Faulty> {
    let wrong_name = |file: &str, name: &str, keys: &str| {
        let mut faulty = Faulty::log(
            &format!("{file} called {name}"),
            fixture(file),
            keys,
            &["\"samples\": 240"],
        )
        .naming("run.log", name)
        .code(0);
        name.clone_into(&mut faulty.files[1].0);
        faulty
    };
    vec![
        wrong_name("plain.csv", "log.parquet", USUAL),
        wrong_name("zstd.parquet", "log.csv", USUAL),
        wrong_name("plain.db3", "log.mcap", TOPICS),
        Faulty::log(
            "a table asked for topics",
            fixture("zstd.parquet"),
            TOPICS,
            &["is a table and has no topics, so there is no \"/joint_states\""],
        ),
        Faulty::log(
            "arrays asked for columns",
            fixture("plain.npz"),
            USUAL,
            &["has no column \"t_s\""],
        ),
    ]
}

fn header(text: &str, data: &[u8]) -> Vec<u8> {
    let length = u16::try_from(text.len()).unwrap().to_le_bytes();
    [b"\x93NUMPY\x01\x00", &length[..], text.as_bytes(), data].concat()
}

#[rustfmt::skip]
fn npy() -> Vec<Faulty> {
    let of = |name: &str, text: &str, data: &[u8], says: &[&'static str]| {
        Faulty::log(name, header(text, data), NUMBERS, says)
    };
    let shape =
        |shape: &str| format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n");
    vec![
        of("objects of Python", "{'descr': '|O', 'fortran_order': False, 'shape': (10, 7), }\n", &[0; 560], &["|O"]),
        of("an array larger than memory", &shape("(900000000000000000, 7)"), &[0; 560], &["its shape is absurd"]),
        of("an array whose size overflows", &shape("(18446744073709551615, 7)"), &[0; 560], &["run.log"]),
        of(
            "an array of three dimensions",
            &shape("(240, 7, 2)"),
            &[0; 560],
            &[
                "run.log has the shape (240, 7, 2)",
                "reshape it to samples × columns",
            ],
        ),
        of("an array without rows", &shape("(0, 7)"), &[], &["run.log"]),
        of(
            "an array without rows whose columns overflow",
            &shape("(0, 4294967296, 4294967296)"),
            &[],
            &["its shape is absurd"],
        ),
        of(
            "records longer than memory",
            "{'descr': [('a', '<f8'), ('', '|V99999999999')], 'fortran_order': False, 'shape': (2,), }\n",
            &[0; 16],
            &["its records are absurdly long"],
        ),
        of("an array without a header", "what?\n", &[0; 560], &["run.log"]),
    ]
}

/// A MATLAB file with one matrix of no numbers.
fn matrix(dimensions: &[u32]) -> Vec<u8> {
    let element = |kind: u32, bytes: &[u8]| {
        let length = u32::try_from(bytes.len()).unwrap();
        let mut all = [&kind.to_le_bytes()[..], &length.to_le_bytes(), bytes].concat();
        all.resize(all.len().next_multiple_of(8), 0);
        all
    };
    let sides: Vec<u8> = dimensions.iter().flat_map(|n| n.to_le_bytes()).collect();
    let flags = [6, 0, 0, 0, 0, 0, 0, 0];
    let parts = [
        element(6, &flags),
        element(5, &sides),
        element(1, b"data"),
        element(9, &[]),
    ];
    let mut head = b"MATLAB 5.0 MAT-file".to_vec();
    head.resize(124, b' ');
    head.extend(b"\x00\x01IM");
    [head, element(14, &parts.concat())].concat()
}

/// Files of MATLAB 7.3. Builds without the feature mat73 refuse them.
#[rustfmt::skip]
fn mat73() -> Vec<Faulty> {
    let of = |name: &str, bytes: &[u8], keys: &str, says: &'static str| {
        let says = if cfg!(feature = "mat73") {
            vec![says]
        } else {
            vec!["version 7.3", "-v7", "--features mat73"]
        };
        Faulty::log(name, bytes.to_vec(), keys, &says)
    };
    let (flat, packed) = (fixture("flat73.mat"), fixture("struct73.mat"));
    let no_numbers = |name: &str| NUMBERS.replace("= 1", &format!("= \"{name}\""));
    vec![
        of("the beginning of MATLAB 7.3", b"MATLAB 7.3 MAT-file, Platform: GLNXA64", USUAL, "is damaged"),
        of("half of struct73.mat", &packed[..packed.len() / 2], MATLAB, "cut off"),
        of("text in MATLAB 7.3", &flat, &no_numbers("note"), "\"note\" is text"),
        of("three dimensions in MATLAB 7.3", &flat, &no_numbers("cube(:,1)"), "\"cube\" is an array of 40 × 3 × 2"),
    ]
}

#[rustfmt::skip]
fn others() -> Vec<Faulty> {
    let usual = |name: &str, bytes: &[u8], says: &[&'static str]| {
        Faulty::log(name, bytes.to_vec(), USUAL, says)
    };
    let empty_zip = [&b"PK\x05\x06"[..], &[0; 18]].concat();
    vec![
        usual("an archive with nothing in it", &empty_zip, &["run.log"]),
        Faulty::log(
            "a matrix without rows whose columns overflow",
            matrix(&[0, 0x8000_0000, 0x8000_0000, 0x8000_0000]),
            MATLAB,
            &["absurd dimensions"],
        ),
        usual("a bag of ROS 1", b"#ROSBAG V2.0\n", &["a bag of ROS 1"]),
        usual("a picked-up database", b"SQLite format 3\0", &["run.log"]),
        usual("the beginning of Parquet", b"PAR1", &["is damaged or was cut off"]),
        usual("the beginning of gzip", b"\x1f\x8b\x08", &["cut off"]),
        Faulty::log(
            "text among numbers",
            fixture("stamped.parquet"),
            &USUAL.replace("phi1_rad", "note"),
            &["column \"note\" is of type", "which is no number"],
        ),
        Faulty::log("text in MATLAB", fixture("flat.mat"), &NUMBERS.replace("= 1", "= \"note\""), &["\"note\" is text"]),
    ]
}
