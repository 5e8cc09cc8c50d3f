//! Archives of NumPy arrays: every kind of member, and damaged directories.

use crate::keys::{ARRAYS, NUMBERS};
use crate::support::{Files, damage, difference, fixture, read_log, says, truth};

fn read_bytes(bytes: Vec<u8>, log: &str) -> Result<Vec<Vec<f64>>, String> {
    read_log(&Files::Memory(vec![("run.log", bytes)]), "run.log", log)
}

fn whole(file: &str) -> Vec<u8> {
    std::fs::read(fixture(file)).unwrap()
}

/// Bytes before each entry of the directory.
fn entries(archive: &[u8]) -> Vec<usize> {
    let starts = |at: &usize| archive[*at..].starts_with(b"PK\x01\x02");
    (0..archive.len()).filter(starts).collect()
}

/// Bytes before the end record.
fn end_record(archive: &[u8]) -> usize {
    let mut fours = archive.windows(4);
    fours.rposition(|four| four == b"PK\x05\x06").unwrap()
}

/// A damaged archive is refused, or its numbers are those of the whole one: the directory, the header of
/// an array and its numbers are compared with the checksum and with each other.
#[test]
fn damage_changes_no_number() {
    for file in ["plain.npz", "packed.npz"] {
        let whole = whole(file);
        let truth = read_bytes(whole.clone(), ARRAYS).unwrap();
        let directory = entries(&whole)[0];
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        let mut refused = 0;
        for k in 0..600 {
            // Every other time in the directory, which is a small part of the archive.
            let bytes = if k % 2 == 0 {
                damage(&whole, &mut state)
            } else {
                let damaged = damage(&whole[directory..], &mut state);
                [&whole[..directory], &damaged].concat()
            };
            match read_bytes(bytes, ARRAYS) {
                Ok(found) => assert_eq!(found, truth, "{file}, damage {k}"),
                Err(message) => {
                    refused += 1;
                    assert!(message.contains("run.log"), "{message}");
                }
            }
        }
        println!("{file}: {refused} of 600 damaged archives are refused");
        // Most bytes are numbers with a checksum, or tell where these are.
        assert!(refused > 300, "{file}: {refused}");
    }
}

#[test]
fn members_that_are_encrypted_or_packed_otherwise_are_told() {
    let plain = whole("plain.npz");
    for (offset, value, told) in [
        (8, 1, "is encrypted"),
        (10, 93, "is compressed with method 93 (ZSTD)"),
    ] {
        let mut bytes = plain.clone();
        bytes[entries(&plain)[0] + offset] = value;
        let message = read_bytes(bytes, ARRAYS).unwrap_err();
        says(&message, &["run.log: ", ".npy ", told, "numpy.savez"]);
    }
}

#[test]
fn a_directory_with_fewer_entries_than_it_says_is_told() {
    let mut bytes = whole("plain.npz");
    let end = end_record(&bytes);
    let count = bytes[end + 10];
    bytes[end + 10] = count + 1;
    let told = format!("it lists {count} of {} members", count + 1);
    let message = read_bytes(bytes, ARRAYS).unwrap_err();
    says(&message, &["the list of its members is damaged", &told]);
}

/// Sizes and places of ZIP64 are in separate records, and those of the usual record are all ones.
#[test]
fn the_directory_may_be_that_of_zip64() {
    let plain = whole("plain.npz");
    let end = end_record(&plain);
    let number = |at: usize, bytes: usize| {
        let bytes = plain[at..at + bytes].iter().rev();
        bytes.fold(0_u64, |all, byte| all << 8 | u64::from(*byte))
    };
    let (count, size, start) = (
        number(end + 10, 2),
        number(end + 12, 4),
        number(end + 16, 4),
    );
    let mut bytes = plain[..end].to_vec();
    bytes.extend(b"PK\x06\x06");
    bytes.extend(44_u64.to_le_bytes());
    bytes.extend([45, 0, 45, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    for number in [count, count, size, start] {
        bytes.extend(number.to_le_bytes());
    }
    bytes.extend(b"PK\x06\x07\0\0\0\0");
    bytes.extend((end as u64).to_le_bytes());
    bytes.extend([1, 0, 0, 0]);
    bytes.extend(b"PK\x05\x06\0\0\0\0");
    bytes.extend([0xff; 12]);
    bytes.extend([0; 2]);
    let found = read_bytes(bytes, ARRAYS).unwrap();
    assert!(difference(&found, &truth()) <= 1e-12);
}

#[test]
fn arrays_of_three_dimensions_say_what_to_do() {
    let text = "{'descr': '<f8', 'fortran_order': False, 'shape': (240, 7, 2), }\n";
    let length = (text.len() as u16).to_le_bytes();
    let npy = [
        b"\x93NUMPY\x01\x00",
        &length[..],
        text.as_bytes(),
        &[0; 560],
    ]
    .concat();
    let told = [
        "the shape (240, 7, 2)",
        "reshape it to samples × columns, as a.reshape(240, -1)",
    ];
    let message = read_bytes(npy.clone(), NUMBERS).unwrap_err();
    says(&message, &["run.log has", told[0], told[1]]);
    // In an archive it is an error only if it is requested.
    let zip = stored_zip(&[("cube.npy", &npy), ("q.npy", &whole("plain.npy"))]);
    assert!(read_bytes(zip.clone(), NUMBERS).is_ok());
    let message = read_bytes(zip, &NUMBERS.replace("= 1", "= \"cube[:,0,1]\"")).unwrap_err();
    says(&message, &["run.log: \"cube\" has", told[0], told[1]]);
}

/// A member that is longer than its array has a damaged size or a damaged header.
#[test]
fn members_of_another_size_than_their_array_are_told() {
    let mut npy = whole("plain.npy");
    npy.push(0);
    let zip = stored_zip(&[("q.npy", &npy)]);
    let message = read_bytes(zip, NUMBERS).unwrap_err();
    let told = format!("has {} bytes in the archive", npy.len());
    says(&message, &["run.log: \"q\" ", &told, "copy or write"]);
}

/// Returns an archive whose members are not compressed.
fn stored_zip(members: &[(&str, &[u8])]) -> Vec<u8> {
    let (mut all, mut directory) = (Vec::new(), Vec::new());
    for (name, bytes) in members {
        let mut sum = flate2::Crc::new();
        sum.update(bytes);
        let sizes = [
            sum.sum().to_le_bytes(),
            (bytes.len() as u32).to_le_bytes(),
            (bytes.len() as u32).to_le_bytes(),
            [name.len() as u8, 0, 0, 0],
        ]
        .concat();
        directory.extend(b"PK\x01\x02\x14\0\x14\0\0\0\0\0\0\0\0\0");
        directory.extend(&sizes);
        directory.extend([0; 10]);
        directory.extend((all.len() as u32).to_le_bytes());
        directory.extend(name.bytes());
        all.extend(b"PK\x03\x04\x14\0\0\0\0\0\0\0\0\0");
        all.extend(&sizes);
        all.extend(name.bytes());
        all.extend(*bytes);
    }
    let (at, length) = (all.len() as u32, directory.len() as u32);
    let count = members.len() as u8;
    all.extend(directory);
    all.extend(b"PK\x05\x06\0\0\0\0");
    all.extend([count, 0, count, 0]);
    all.extend(length.to_le_bytes());
    all.extend(at.to_le_bytes());
    all.extend([0; 2]);
    all
}
