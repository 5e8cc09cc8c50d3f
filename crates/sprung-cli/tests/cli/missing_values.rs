//! Samples in which a column has no value.

use crate::common::{Case, finding, stderr, value};

const Q2: usize = 2;
const TAU1: usize = 5;

const GAP: [&str; 2] = ["--set", "log.nan=gap"];

/// A log with three single samples and five consecutive ones without a value.
fn case() -> Case {
    Case::new().log(|row, cells| {
        let word = match row {
            1000 => "NaN",
            2000 => "",
            3000 => " null ",
            6000..6005 => "nan",
            _ => return,
        };
        let column = if row == 2000 { TAU1 } else { Q2 };
        word.clone_into(&mut cells[column]);
    })
}

#[test]
fn a_refusal_names_the_setting() {
    let setting = "nan = \"gap\" in [log] leaves samples";
    let with = |word: &'static str| {
        Case::new().log(move |row, cells| {
            if row == 7 {
                word.clone_into(&mut cells[TAU1]);
            }
        })
    };
    let line = "line 8 of";
    with("nan").fails(3, &[line, "\"tau1_nm\"", "the value is NaN", setting]);
    with("N/A").fails(3, &[line, "\"N/A\" is not a number", setting]);
    with("").fails(
        3,
        &["line 8 of", "\"tau1_nm\"", "the cell is empty", setting],
    );
}

#[test]
fn samples_without_a_value_are_left_out_and_counted() {
    let case = case();
    let output = case.identify(&[&["--json", "--verbose"][..], &GAP].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["log"]["without_value"], 8);
    // Single samples are interpolated, five in a row are a gap.
    assert_eq!(json["log"]["dropped"], 3);
    assert_eq!(json["log"]["gaps"], 1);
    let text = finding(&json, "samples-without-value").unwrap();
    assert!(text.contains("8 of 10000 samples have no value"), "{text}");
    assert!(text.contains("first at line 1001"), "{text}");
    // As accurate as a log without a hole: the limit is that of a gap of half a second.
    let stiffness = value(&json, "joint1.stiffness");
    assert!((stiffness / 9.358_73 - 1.0).abs() < 0.02, "{stiffness}");
}

#[test]
fn what_is_no_missing_value_stays_an_error() {
    for (word, fragment) in [
        ("inf", "the value is inf"),
        ("x7", "\"x7\" is not a number"),
    ] {
        let case = case().log(|row, cells| {
            if row == 4000 {
                word.clone_into(&mut cells[Q2]);
            }
        });
        let output = case.identify(&GAP);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(3), "{message}");
        assert!(
            message.contains(fragment) && message.contains("line 4001"),
            "{message}"
        );
    }
    let output = case().identify(&["--set", "log.nan=gaps"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        stderr(&output).contains("did you mean \"gap\"?"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn columns_that_never_have_values_together_are_named() {
    let case = Case::new().log(|row, cells| {
        if row > 0 {
            cells[if row % 2 == 0 { Q2 } else { TAU1 }].clear();
        }
    });
    let output = case.identify(&GAP);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(3), "{message}");
    for fragment in [
        "has 0 samples",
        "10000 more samples have no value",
        "a file with their own time",
    ] {
        assert!(message.contains(fragment), "{message}");
    }
}
