//! Samples in which a column has no value.

use crate::common::{Case, assert_true, contains, finding, messages};

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
fn what_is_no_number_names_line_and_setting() {
    let mut messages = messages("what_is_no_number_names_line_and_setting");
    // Without the setting, every cell without a number is an error.
    for word in ["nan", "N/A", ""] {
        let case = Case::new().cell(7, TAU1, word);
        messages.note(&format!("{word:?}"), &case.refused(3, &[]));
    }
    // With it, what is no missing value stays an error.
    for word in ["inf", "x7"] {
        let case = case().cell(4000, Q2, word);
        messages.note(&format!("{word:?}, nan = \"gap\""), &case.refused(3, &GAP));
    }
    let message = case().refused(2, &["--set", "log.nan=gaps"]);
    messages.note("nan = \"gaps\"", &message);
    // Columns that never have values together.
    let apart = Case::new().log(|row, cells| {
        if row > 0 {
            cells[if row % 2 == 0 { Q2 } else { TAU1 }].clear();
        }
    });
    messages.note("columns that alternate", &apart.refused(3, &GAP));
    messages.compare();
}

#[test]
fn samples_without_a_value_are_left_out_and_counted() {
    let case = case();
    let json = case
        .identify(&[&["--json", "--verbose"][..], &GAP].concat())
        .ends(0)
        .json();
    assert_eq!(json["log"]["without_value"], 8);
    // Single samples are interpolated, five in a row are a gap.
    assert_eq!(json["log"]["dropped"], 3);
    assert_eq!(json["log"]["gaps"], 1);
    contains(
        finding(&json, "samples-without-value").unwrap(),
        &["8 of 10000 samples have no value", "first at line 1001"],
    );
    assert_true(&json, &[("joint1.stiffness", 9.358_73)]);
}
