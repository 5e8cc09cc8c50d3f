//! Logs in other formats, and messages about logs that cannot be read.

use crate::common::{Case, messages, parameter};

#[test]
fn a_spreadsheet_with_decimal_commas_gives_the_same_results() {
    let plain = Case::new();
    let text = plain.read("identification.csv");
    let german = text.replace(',', ";").replace('.', ",");
    let case = Case::new();
    case.write("identification.csv", format!("\u{feff}{german}"));
    let ((code, one), (_, other)) = (case.results(&[]), plain.results(&[]));
    assert_eq!(code, 0);
    let name = "joint1.stiffness";
    assert_eq!(
        parameter(&one, name)["value"],
        parameter(&other, name)["value"]
    );
}

#[test]
fn one_log_in_two_files() {
    let plain = Case::new();
    let text = plain.read("identification.csv");
    let column = |k: usize| {
        let cells = text.lines().map(|line| line.split(',').nth(k).unwrap());
        cells.collect::<Vec<&str>>().join("\n")
    };
    let entry = "[{ file = \"motor.csv\", column = \"tau1_nm\" }, \"tau2_nm\"]";
    // The validation log has the plain columns, so it is left out.
    let case = Case::new()
        .replace("[\"tau1_nm\", \"tau2_nm\"]", entry)
        .replace("log = { file = \"validation.csv\" }", "");
    // motor.csv does not exist yet.
    case.fails(4, &["cannot read motor.csv", "No such file"]);
    case.write("motor.csv", column(5));
    let ((code, one), (_, other)) = (case.results(&[]), plain.results(&[]));
    assert_eq!(code, 0);
    let name = "joint1.stiffness";
    assert_eq!(
        parameter(&one, name)["value"],
        parameter(&other, name)["value"]
    );
}

#[test]
fn files_that_cannot_be_read() {
    let mut messages = messages("files_that_cannot_be_read");
    for (name, bytes) in [
        ("Parquet", &b"PAR1 and then nothing of it"[..]),
        ("gzip", b"\x1f\x8b\x08\0\0\0"),
        ("MCAP", b"\x89MCAP0\r\n"),
        ("ZIP", b"PK\x03\x04"),
    ] {
        let case = Case::new();
        case.write("identification.csv", bytes);
        messages.note(name, &case.refused(3, &[]));
    }
    // With the feature mat73 the message is another one.
    let case = Case::new();
    case.write("identification.csv", b"\x89HDF\r\n\x1a\n");
    case.fails(3, &["HDF5"]);
    let case = Case::new();
    case.remove("identification.csv");
    std::fs::create_dir(case.path("identification.csv")).unwrap();
    messages.note("an empty folder", &case.refused(4, &[]));
    for name in ["a_0.mcap", "a_1.mcap"] {
        case.write(&format!("identification.csv/{name}"), "t_s\n");
    }
    messages.note("a folder with two bags", &case.refused(4, &[]));
    case.remove("identification.csv/a_1.mcap");
    messages.note("a folder with text", &case.refused(3, &[]));
    messages.compare();
}

#[test]
fn a_topic_of_a_file_without_topics() {
    let topic = "motor_torque = { topic = \"/states\", unit = \"N·m\" }";
    let case = Case::new().replace("motor_torque_nm    = [\"tau1_nm\", \"tau2_nm\"]", topic);
    case.fails(
        3,
        &["is text and has no topics, so there is no \"/states\""],
    );
    case.identify(&["--set", "log.motor_torque.field=\"tau\""])
        .ends(3);
    case.identify(&["--set", "log.motor_torque.fild=\"tau\""])
        .ends(2)
        .tells(&["did you mean \"field\"?"]);
}
