//! Faulty texts.

use super::keys::USUAL;
use super::{Faulty, fixture};

const GERMAN_HEADER: &str = "t_s;q1_rad;q2_rad;phi1_rad;phi2_rad;tau1_nm;tau2_nm";

/// The log of the fixtures with changed cells; row 0 is the header.
fn changed(mut change: impl FnMut(usize, &mut Vec<String>)) -> Vec<u8> {
    let text = String::from_utf8(fixture("plain.csv")).unwrap();
    let mut lines = String::new();
    for (row, line) in text.lines().enumerate() {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        change(row, &mut cells);
        if !cells.is_empty() {
            lines.push_str(&cells.join(","));
            lines.push('\n');
        }
    }
    lines.into_bytes()
}

/// The log with one changed cell in line 101.
fn cell(column: usize, text: &str) -> Vec<u8> {
    changed(|row, cells| {
        if row == 100 {
            text.clone_into(&mut cells[column]);
        }
    })
}

fn first_lines(count: usize) -> Vec<u8> {
    changed(|row, cells| {
        if row >= count {
            cells.clear();
        }
    })
}

/// Far more columns than usual logs have; the usual columns are last.
fn ten_thousand_columns() -> Vec<u8> {
    let strangers = 10_000 - 7;
    changed(|row, cells| {
        let cell = |k| match row {
            0 => format!("c{k}"),
            _ => "0".to_owned(),
        };
        let usual = std::mem::take(cells);
        cells.extend((0..strangers).map(cell).chain(usual));
    })
}

pub(super) fn all() -> Vec<Faulty> {
    [cells(), rows(), times(), columns(), whole_files()]
        .into_iter()
        .flatten()
        .collect()
}

#[rustfmt::skip]
fn cells() -> Vec<Faulty> {
    let usual = |name: &str, bytes, says: &[&'static str]| Faulty::log(name, bytes, USUAL, says);
    let line = ["line 101 of", "column \"q2_rad\""];
    let with = |more| [line[0], line[1], more];
    vec![
        usual("a word", cell(2, "n/a"), &with("\"n/a\" is not a number")),
        usual("no number", cell(2, ""), &with("the cell is empty")),
        usual("not a number", cell(2, "NaN"), &with("the value is NaN")),
        usual("infinity", cell(2, "-inf"), &with("the value is -inf")),
        usual("beyond floats", cell(2, "1e400"), &with("the value is inf")),
        usual("thousands in quotes", cell(2, "\"1,234.5\""), &with("no thousands separators")),
        usual("thousands", cell(2, "1,234.5"), &["line 101 of", "has 8 cells, the header has 7"]),
        usual(
            "thousands with points",
            format!("{GERMAN_HEADER}\n0,0;1;2;3;4;5;6\n0,1;1;1.234,5;3;4;5;6\n").into_bytes(),
            &["line 3 of", "\"1.234,5\"", "no thousands separators"],
        ),
        usual("a cell of a megabyte", cell(2, &"x".repeat(1 << 20)), &["line 102 has more than 1 MiB"]),
        usual(
            "bytes that are no text",
            changed(|_, _| {})
                .into_iter()
                .enumerate()
                .map(|(at, byte)| if at == 9000 { 0xfe } else { byte })
                .collect(),
            &["is not a number"],
        ),
        usual("hexadecimal", cell(2, "0x1f"), &with("is not a number")),
    ]
}

#[rustfmt::skip]
fn rows() -> Vec<Faulty> {
    let usual = |name: &str, bytes, says: &[&'static str]| Faulty::log(name, bytes, USUAL, says);
    let mut cut = fixture("plain.csv");
    cut.truncate(20_000);
    let end = cut.iter().rposition(|&byte| byte == b',').unwrap();
    cut.truncate(end);
    vec![
        usual("an empty text", Vec::new(), &["has 0 samples", "not even a header line"]),
        usual("blank lines", b"\n\n  \n".to_vec(), &["has "]),
        usual("a header alone", first_lines(1), &["has 0 samples, at least 2 are needed"]),
        usual("one row", first_lines(2), &["has 1 samples, at least 2 are needed"]),
        usual("a text that was cut off", cut, &["log-cut-off"]).code(0),
        usual(
            "a short row",
            changed(|row, cells| {
                if row == 7 {
                    cells.pop();
                }
            }),
            &["line 8 of", "has 6 cells, the header has 7"],
        ),
        usual("a quote that is not closed", cell(2, "\"0.1"), &["line 101 of", "cells"]),
        usual(
            "two logs in one file",
            [fixture("plain.csv"), fixture("plain.csv")].concat(),
            &["line 242 of", "\"t_s\" is not a number"],
        ),
    ]
}

#[rustfmt::skip]
fn times() -> Vec<Faulty> {
    let usual = |name: &str, bytes, says: &[&'static str]| Faulty::log(name, bytes, USUAL, says);
    let dates = |date: fn(usize) -> String| {
        changed(move |row, cells| {
            if row > 0 {
                cells[0] = date(row);
            }
        })
    };
    let of_dates = USUAL.replace(
        "time_s = \"t_s\"",
        "time = { column = \"t_s\", unit = \"date\" }",
    );
    vec![
        usual("time goes back", cell(0, "0.05"), &["line 101 of", "time goes from 0.098 s to 0.05 s"]),
        usual("one time with two values", cell(0, "0.098"), &["line 101 of", "sampling = \"even\""]),
        usual(
            "time stands still",
            changed(|row, cells| {
                if row > 0 {
                    "5.0".clone_into(&mut cells[0]);
                }
            }),
            &["line 3 of", "time goes from 5 s to 5 s"],
        ),
        usual("an infinite time", cell(0, "inf"), &["the value is inf"]),
        usual(
            "dates as time",
            dates(|row| format!("2024-05-01T12:00:00.{row:03}")),
            &["line 2 of", "it is a date: write time ="],
        ),
        Faulty::log(
            "dates of another kind",
            dates(|row| format!("01.05.2024 12:00:00.{row:03}")),
            &of_dates,
            &["line 2 of", "a date is written 2024-05-01T12:00:00.123"],
        ),
        Faulty::log(
            "a date without its month",
            dates(|_| "2024-13-01T12:00:00.0".to_owned()),
            &of_dates,
            &["line 2 of", "a date is written"],
        ),
    ]
}

#[rustfmt::skip]
fn columns() -> Vec<Faulty> {
    let said = |name: &str, from: &str, to: &str, says: &[&'static str]| {
        assert!(USUAL.contains(from));
        Faulty::log(name, fixture("plain.csv"), &USUAL.replace(from, to), says)
    };
    let header = |from: &str, to: &[u8]| {
        let text = String::from_utf8(fixture("plain.csv")).unwrap();
        let (before, after) = text.split_once(from).unwrap();
        [before.as_bytes(), to, after.as_bytes()].concat()
    };
    vec![
        said("a column of another name", "phi2_rad", "phi_2_rad", &["has no column \"phi_2_rad\"; did you mean \"phi2_rad\"?"]),
        said("a pattern for too many", "q*_rad", "*_rad", &["\"*_rad\" matches 4 columns", "list those that are meant"]),
        said("a pattern for none", "q*_rad", "link*_rad", &["has no column \"link*_rad\""]),
        said("a number too large", "\"t_s\"", "8", &["has no column \"8\""]),
        Faulty::log(
            "a column twice",
            header("q2_rad", b"q1_rad"),
            USUAL,
            &["two columns \"q1_rad\""],
        )
        .naming("\"q*_rad\"", "[\"q1_rad\", \"q2_rad\"]"),
        Faulty::log(
            "a header in Latin-1",
            header("q2_rad", b"q2_\xb0"),
            USUAL,
            &["did you mean", "q2_\u{b0}"],
        )
        .naming("\"q*_rad\"", "[\"q1_rad\", \"q2_deg\"]"),
        Faulty::log(
            "ten thousand columns of others",
            ten_thousand_columns(),
            &USUAL.replace("\"t_s\"", "\"seconds since the start\""),
            &["has no column \"seconds since the start\"", "c0, c1"],
        ),
        Faulty::log("ten thousand columns", ten_thousand_columns(), USUAL, &["\"samples\": 240"]).code(0),
        Faulty::log(
            "more lines to skip than there are",
            fixture("plain.csv"),
            &format!("csv = {{ skip_lines = 9999 }}\n{USUAL}"),
            &["before skip_lines = 9999"],
        ),
        Faulty::log(
            "another delimiter than was said",
            fixture("plain.csv"),
            &format!("csv = {{ delimiter = \";\" }}\n{USUAL}"),
            &["has no column \"t_s\""],
        ),
    ]
}

#[rustfmt::skip]
fn whole_files() -> Vec<Faulty> {
    let usual = |name: &str, bytes, says: &[&'static str]| Faulty::log(name, bytes, USUAL, says);
    let mut zeros = fixture("plain.csv");
    zeros[5000..5100].fill(0);
    let utf_16 = |text: &str| -> Vec<u8> {
        let bytes = text.encode_utf16().flat_map(u16::to_le_bytes);
        b"\xff\xfe".iter().copied().chain(bytes).collect()
    };
    vec![
        usual(
            "a page of the web",
            b"<!DOCTYPE html>\n<html><body>Sign in</body></html>\n".to_vec(),
            &["is a page of HTML or XML", "give the log"],
        ),
        usual(
            "a pointer to a large file",
            b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a2146\nsize 12345\n"
                .to_vec(),
            &["has no column \"t_s\""],
        ),
        usual("a picture", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".to_vec(), &["is a binary file in an unknown format"]),
        usual("a text with a hole", zeros, &["is a binary file in an unknown format"]),
        usual("text in UTF-16", utf_16("t_s,q1_rad\n0,1\n"), &["is UTF-16 text; save it as UTF-8"]),
    ]
}
