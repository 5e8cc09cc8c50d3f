//! Units, sides of the gearbox, counts, and text in columns.

use crate::keys::USUAL;
use crate::support::{difference, experiment, messages, read_text, says, truth};

/// A log of four rows. `cells` returns the cells of a row from its time.
fn text(header: &str, cells: impl Fn(f64) -> String) -> String {
    let rows: Vec<String> = (0..4).map(|k| cells(f64::from(k) * 0.001)).collect();
    format!("{header}\n{}\n", rows.join("\n"))
}

fn near(found: &[Vec<f64>], expected: impl Fn(f64) -> Vec<f64>) {
    for (i, &time) in found[0].iter().enumerate() {
        for (k, expected) in expected(time).into_iter().enumerate() {
            let value = found[1 + k][i];
            assert!(
                (value - expected).abs() < 1e-12 * expected.abs().max(1.0),
                "row {i}, channel {k}: {value}, expected {expected}"
            );
        }
    }
}

#[test]
fn units_and_sides() {
    let log = r#"
time = { column = "t", unit = "µs" }
link_position = { column = "q*", unit = "turns" }
motor_position = { column = "p*", unit = "deg", side = "motor" }
motor_current = [{ column = "i1", unit = "mA" }, { column = "i2", unit = "A", gain = 0.5, sign = -1 }]
"#;
    let log_text = text("t,q1,q2,p1,p2,i1,i2", |t| {
        format!(
            "{},{},{},{},{},{},{}",
            t * 1e6,
            0.5 + t,
            t,
            90.0 + t,
            t,
            500.0 + t,
            1.0 + t
        )
    });
    let found = read_text(log_text, log).unwrap();
    assert!((found[0][3] - 0.003).abs() < 1e-15);
    let turn = std::f64::consts::TAU;
    near(&found, |t| {
        vec![
            (0.5 + t) * turn,
            t * turn,
            (90.0 + t) / 360.0 * turn / 10.0,
            t / 360.0 * turn / 100.0,
            2.0 * (0.5 + 1e-3 * t),
            -4.0 * 0.5 * (1.0 + t),
        ]
    });
}

#[test]
fn counters_roll_over_and_begin_anywhere() {
    let log = r#"
time_ms = "t"
link_position = { column = "q*", unit = "counts", counts_per_turn = 4096, sign = [1, -1], offset = [-100, 0], wrap = 65536 }
motor_position = { column = "p*", unit = "counts", counts_per_turn = [1000, 2000], starts_at_rad = "q_at_start_*" }
motor_torque = { column = "i*", unit = "mN·m" }
"#;
    // Both link counters overflow: one upwards, one downwards.
    let log_text = text("t,q1,q2,p1,p2,i1,i2,q_at_start_1,q_at_start_2", |t| {
        let k = (t * 1000.0).round() as i64;
        let (up, down) = (
            (65_000 + 400 * k) % 65_536,
            (900 - 400 * k).rem_euclid(65_536),
        );
        format!(
            "{k},{up},{down},{},{},1500,2000,0.25,-0.5",
            7000 + k,
            -3000 - 2 * k
        )
    });
    let found = read_text(log_text, log).unwrap();
    let turn = std::f64::consts::TAU;
    near(&found, |t| {
        let k = (t * 1000.0).round();
        vec![
            (64_900.0 + 400.0 * k) / 4096.0 * turn,
            -(900.0 - 400.0 * k) / 4096.0 * turn,
            0.25 + k / 1000.0 * turn,
            -0.5 - 2.0 * k / 2000.0 * turn,
            1.5,
            2.0,
        ]
    });
}

#[test]
fn text_may_be_written_in_many_ways() {
    let truth = truth();
    let plain = std::fs::read_to_string(crate::support::fixture("plain.csv")).unwrap();
    let blanks = plain.replace(',', "   ").replace('\n', "\r\n");
    let quoted = plain.replacen("t_s,q1_rad", "\"t_s\",\"q1_rad\"", 1);
    let commented = format!("% recorded by hand\n% twice\n{plain}");
    let skipped = format!("Logger 3000;v2\nserial 17\n{plain}");
    for (what, text, more) in [
        ("blanks", blanks, ""),
        ("quoted", quoted, ""),
        ("commented", commented, ""),
        ("skipped", skipped, "csv = { skip_lines = 2 }\n"),
        (
            "bars",
            plain.replace(',', "|"),
            "csv = { delimiter = \"|\" }\n",
        ),
    ] {
        let found = read_text(text, &format!("{more}{USUAL}"))
            .unwrap_or_else(|error| panic!("{what}: {error}"));
        assert!(difference(&found, &truth) <= 1e-12, "{what}");
    }
}

#[test]
fn names_that_are_no_utf_8_are_latin_1() {
    let mut bytes = "zeit [µs],q1_rad,q2_rad,phi1_rad,phi2_rad,tau1_nm,tau2_nm\n"
        .chars()
        .map(|c| c as u8)
        .collect::<Vec<u8>>();
    bytes.extend(b"0,1,2,3,4,5,6\n1000,1,2,3,4,5,6\n");
    let log = USUAL.replace("time_s = \"t_s\"", "time_us = \"zeit [µs]\"");
    let found = read_text(bytes, &log).unwrap();
    assert!((found[0][1] - 0.001).abs() < 1e-15);
}

#[test]
fn dates_are_times_when_they_are_called_so() {
    let rows = |k: i32| format!("2024-05-01T23:59:59.{:03}Z,1,2,3,4,5,6", 997 + k);
    let mut lines: Vec<String> = (0..3).map(rows).collect();
    lines.push("2024-05-02T00:00:00.000Z,1,2,3,4,5,6".to_owned());
    let text = format!(
        "stamp,q1_rad,q2_rad,phi1_rad,phi2_rad,tau1_nm,tau2_nm\n{}\n",
        lines.join("\n")
    );
    let log = USUAL.replace(
        "time_s = \"t_s\"",
        "time = { column = \"stamp\", unit = \"date\" }",
    );
    let found = read_text(&text, &log).unwrap();
    assert_eq!(found[0].len(), 4);
    assert!((found[0][3] - 0.003).abs() < 1e-12, "{:?}", found[0]);
    let error = read_text(&text, &USUAL.replace("t_s", "stamp")).unwrap_err();
    says(
        &error,
        &[
            "line 2 of log.csv, column \"stamp\"",
            "it is a date",
            "unit = \"date\"",
        ],
    );
}

#[test]
fn a_log_without_time_has_a_period() {
    let plain = std::fs::read_to_string(crate::support::fixture("plain.csv")).unwrap();
    let log = USUAL.replace("time_s = \"t_s\"", "period_s = 0.001");
    assert!(difference(&read_text(plain, &log).unwrap(), &truth()) <= 1e-12);
}

#[test]
fn ten_thousand_columns() {
    let mut header: Vec<String> = (0..10_000).map(|k| format!("channel_{k}")).collect();
    for (place, name) in [
        (0, "t_s"),
        (17, "q1_rad"),
        (9999, "q2_rad"),
        (5000, "phi1_rad"),
    ] {
        header[place] = name.to_owned();
    }
    for (place, name) in [(5001, "phi2_rad"), (70, "tau1_nm"), (71, "tau2_nm")] {
        header[place] = name.to_owned();
    }
    let row = |t: f64| {
        let mut cells = vec!["0.5".to_owned(); 10_000];
        cells[0] = t.to_string();
        cells[9999] = (2.0 * t).to_string();
        cells.join(",")
    };
    let text = format!("{}\n{}\n{}\n", header.join(","), row(0.0), row(0.001));
    let found = read_text(&text, USUAL).unwrap();
    assert!((found[2][1] - 0.002).abs() < 1e-15);
    let error = read_text(&text, &USUAL.replace("phi1_rad", "weight")).unwrap_err();
    assert!(error.len() < 1000, "{error}");
    says(&error, &["has no column \"weight\"", "and 9970 more"]);
}

#[test]
fn keys_that_do_not_fit_are_refused_with_their_line() {
    let mut messages = messages("keys_that_do_not_fit_are_refused_with_their_line");
    for key in [
        "motor_torque = \"tau*\"",
        "motor_torque = { column = \"tau*\", unit = \"rad\" }",
        "motor_torque = { column = \"tau*\", unit = \"Nmm\" }",
        "motor_torque_nm = { column = \"tau*\", unit = \"N·m\" }",
        "motor_torque = { column = \"tau*\", topic = \"/a\", unit = \"N·m\" }",
        "motor_torque = { column = \"tau*\", unit = \"N·m\", sign = [1, 1, 1] }",
        "motor_torque = { column = \"tau*\", unit = \"N·m\", sign = 2 }",
        "motor_torque = { column = \"tau*\", unit = \"N·m\", signs = 1 }",
        "motor_torque_nm = [0, 1]",
    ] {
        let log = USUAL.replace("motor_torque_nm = \"tau*_nm\"", key);
        messages.note(key, &experiment(&log).unwrap_err());
    }
    let counts = USUAL.replace(
        "link_position_rad = \"q*_rad\"",
        "link_position = { column = \"q*\", unit = \"counts\" }",
    );
    let borrowed = USUAL.replace(
        "\"tau*_nm\"",
        "[{ file = \"a.npy\", column = 1 }, { file = \"a.npy\", column = 2 }]\n\
         [[validate]]\nname = \"other\"\nlog = { file = \"other.csv\" }\n[log.sign]",
    );
    for (name, log) in [
        ("counts without size", counts),
        (
            "two times",
            USUAL.replace("\"t_s\"", "\"t_s\"\ntime_ms = \"t\""),
        ),
        ("a file for two logs", borrowed),
        (
            "two delimiters",
            format!("csv = {{ delimiter = \"ab\" }}\n{USUAL}"),
        ),
    ] {
        messages.note(name, &experiment(&log).unwrap_err());
    }
    messages.compare();
}
