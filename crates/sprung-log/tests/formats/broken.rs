//! Files that are cut off, damaged, or of another kind.

use crate::keys::{ARRAYS, MATLAB, NUMBERS, RECORDS, TOPICS, USUAL};
use crate::support::{Files, damage, fixture, read_log, read_text, says};

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
    for (file, log) in ALL {
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
    for (bytes, fragments) in [
        (&b"\x89HDF\r\n\x1a\n"[..], ["is HDF5", ".npz"]),
        (b"MATLAB 7.3 MAT-file, Platform", ["version 7.3", "\"-v7\""]),
        (b"#ROSBAG V2.0\n", ["a bag of ROS 1", "rosbags-convert"]),
        (b"BZh91AY", ["bzip2", "decompress"]),
        (b"\xff\xfet\0,\0", ["UTF-16", "UTF-8"]),
        (b"\x7fELF\x02\0\0\0", ["is a binary file", "Parquet"]),
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
    let npy = std::fs::read(fixture("plain.npy")).unwrap();
    let packed = zstd::encode_all(&npy[..], 3).unwrap();
    says(
        &read_bytes(packed, NUMBERS).unwrap_err(),
        &["is an .npy file compressed with zstd; decompress it"],
    );
}

#[test]
fn bags_and_tables_are_told_apart() {
    let bag = |file: &str, log: &str| read_log(&Files::Fixtures, file, log).unwrap_err();
    for file in ["zstd.mcap", "plain.db3"] {
        says(
            &bag(file, USUAL),
            &["is a bag; say which topic", "/joint_states, /motor_states"],
        );
        says(
            &bag(file, &TOPICS.replace("/joint_states", "/joint_state")),
            &["has no topic \"/joint_state\"; did you mean \"/joint_states\"?"],
        );
        says(
            &bag(file, &TOPICS.replace("effort", "efort")),
            &[
                "sensor_msgs/msg/JointState",
                "no number \"efort\"; did you mean \"effort\"?",
            ],
        );
        let strangers = TOPICS.replace("unit", "joint_names = [\"a\", \"b\"], unit");
        says(
            &bag(file, &strangers),
            &["has no joint \"a\"; its messages name joint1, joint2"],
        );
        let half = TOPICS.replace("unit", "joint_names = [\"joint1\", \"b\"], unit");
        says(
            &bag(file, &half),
            &["message 1 has no joint \"b\"; it has joint1, joint2"],
        );
        let empty = TOPICS.replace("\"effort\"", "\"velocity\"");
        says(
            &bag(file, &empty),
            &["message 1 has no value at \"velocity[joint1]\""],
        );
    }
    says(
        &bag("zstd.parquet", TOPICS),
        &["is a table and has no topics, so there is no \"/joint_states\""],
    );
    says(&bag("plain.npz", TOPICS), &["holds arrays and no topics"]);
    says(&bag("plain.csv", TOPICS), &["is text and has no topics"]);
}

#[test]
fn columns_that_are_absent_or_no_numbers() {
    let fixture_of = |file: &str, log: &str| read_log(&Files::Fixtures, file, log).unwrap_err();
    says(
        &fixture_of("zstd.parquet", &USUAL.replace("phi1_rad", "phi_1_rad")),
        &["has no column \"phi_1_rad\"; did you mean \"phi1_rad\"?"],
    );
    says(
        &fixture_of("stamped.parquet", &USUAL.replace("phi1_rad", "note")),
        &["column \"note\" is of type", "which is no number"],
    );
    says(
        &fixture_of("struct.mat", &MATLAB.replace("data.time", "data.tme")),
        &["has no column \"data.tme\"; did you mean \"data.time\"?"],
    );
    says(
        &fixture_of("flat.mat", &NUMBERS.replace("= 1", "= \"note\"")),
        &["\"note\" is text"],
    );
    says(
        &fixture_of("bare.txt", USUAL),
        &["has no column \"t_s\"; it has no names, only 7 numbered columns"],
    );
    says(
        &fixture_of("plain.npy", &NUMBERS.replace('7', "8")),
        &["has no column \"8\"; it has 7 columns"],
    );
    let arrays = ARRAYS.replace("q[:,*]", "q*");
    says(
        &fixture_of("plain.npz", &arrays),
        &["neither numbered nor named"],
    );
}

#[test]
fn numbers_as_people_write_them() {
    let header = "t_s;q1_rad;q2_rad;phi1_rad;phi2_rad;tau1_nm;tau2_nm";
    let text = format!("{header}\n0,0;1;2;3;4;5;6\n0,001;1;2;3;4;1.234,5;6\n");
    says(
        &read_text(text, USUAL).unwrap_err(),
        &[
            "line 3 of log.csv, column \"tau1_nm\": \"1.234,5\"",
            "no thousands separators",
        ],
    );
    let text = format!("{header}\n0.0;1;2;3;4;5;6\n0.001;1;2;3;4;1,234.5;6\n");
    says(
        &read_text(text, USUAL).unwrap_err(),
        &[
            "line 3 of log.csv, column \"tau1_nm\": \"1,234.5\"",
            "no thousands separators",
        ],
    );
    let ragged = "t_s,q1_rad\n0,1\n0.001\n";
    says(
        &read_text(ragged, &USUAL.replace("q*_rad", "q1_rad")).unwrap_err(),
        &["names 1 columns, the robot has 2 joints"],
    );
}
