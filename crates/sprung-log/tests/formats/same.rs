//! The same numbers from every format.

use crate::keys::{ARRAYS, NUMBERS, TOPICS, USUAL};
use crate::support::{Files, difference, read_log, says, truth};

pub(crate) fn cases() -> Vec<(&'static str, String)> {
    let mut all: Vec<(&str, &str)> = Vec::new();
    for file in [
        "plain.csv",
        "german.csv",
        "log.csv.gz",
        "log.csv.zst",
        "savetxt.dat",
    ] {
        all.push((file, USUAL));
    }
    for file in ["bare.txt", "plain.npy", "fortran.npy"] {
        all.push((file, NUMBERS));
    }
    all.push((
        "records.npy",
        r#"
time_s = "t"
link_position_rad = "q[:,*]"
motor_position_rad = "phi[:,*]"
motor_torque_nm = "tau[:,*]"
"#,
    ));
    all.push(("plain.npz", ARRAYS));
    all.push(("packed.npz", ARRAYS));
    all.push((
        "flat.mat",
        r#"
time_s = "t"
link_position_rad = "q(:,*)"
motor_position_rad = ["phi(1,:)", "phi(2, :)"]
motor_torque_nm = ["tau1(:,1)", "tau2"]
"#,
    ));
    all.push((
        "struct.mat",
        r#"
time_s = "data.time"
link_position_rad = ["data.link.q(:,1)", "data.link.q(:,2)"]
motor_position_rad = "data.signals(1).values(:,*)"
motor_torque_nm = "data.signals(2).values(:,*)"
"#,
    ));
    for file in [
        "snappy.parquet",
        "zstd.parquet",
        "gzip.parquet",
        "lz4.parquet",
        "file.arrow",
        "stream.arrows",
    ] {
        all.push((file, USUAL));
    }
    all.push((
        "lists.parquet",
        r#"
time_s = "t_s"
link_position_rad = "q[*]"
motor_position_rad = ["phi[0]", "phi[1]"]
motor_torque_nm = "tau*_nm"
"#,
    ));
    for file in [
        "zstd.mcap",
        "lz4.mcap",
        "none.mcap",
        "late.mcap",
        "plain.db3",
        "defined.db3",
    ] {
        if file != "late.mcap" {
            all.push((file, TOPICS));
        }
    }
    all.push((
        "nested.mcap",
        r#"
link_position = { topic = "/state", field = "motors[*].pqt[1]", unit = "rad" }
motor_position = { topic = "/state", field = ["motors[0].pqt[0]", "motors[1].pqt[0]"], unit = "rad" }
motor_torque = { topic = "/state", field = "motors[*].pqt[2]", unit = "N·m" }
"#,
    ));
    all.into_iter()
        .map(|(file, log)| (file, log.to_owned()))
        .collect()
}

#[test]
fn every_format_gives_the_same_numbers() {
    let truth = truth();
    for (file, log) in cases() {
        let found = read_log(&Files::Fixtures, file, &log)
            .unwrap_or_else(|error| panic!("{file}: {error}"));
        let worst = difference(&found, &truth);
        println!("{file}: {worst:.1e}");
        assert!(worst <= 1e-12, "{file}: {worst}");
    }
}

#[test]
fn large_times_are_counted_from_the_first() {
    let truth = truth();
    // Stamps of 2024 in nanoseconds leave 256 ns in floating point.
    for (file, log) in [
        ("epoch.mcap", TOPICS.to_owned()),
        ("stamped.parquet", USUAL.replace("t_s", "stamp")),
    ] {
        let found = read_log(&Files::Fixtures, file, &log).unwrap();
        let worst = difference(&found, &truth);
        println!("{file}: {worst:.1e}");
        assert!(worst <= 1e-12, "{file}: {worst}");
    }
    // Received 1.5 ms late, by another clock.
    let received = TOPICS.replace("unit = ", "time = \"log_time\", unit = ");
    let found = read_log(&Files::Fixtures, "zstd.mcap", &received).unwrap();
    assert!((found[0][0] - 0.0015).abs() < 1e-12, "{}", found[0][0]);
}

#[test]
fn topics_on_other_clocks_come_onto_that_of_the_first() {
    let truth = truth();
    let found = read_log(&Files::Fixtures, "late.mcap", TOPICS).unwrap();
    // Before the second topic begins no sample is interpolated.
    assert_eq!(found[0].len(), truth[0].len() - 1);
    assert!((found[0][0] - 0.001).abs() < 1e-12);
    // Values recorded at t + 0.4 ms, taken at t: those of 0.4 ms before.
    let wave = |k: usize, t: f64| {
        let k = k as f64;
        0.3 * f64::sin((9.0 + 2.0 * k) * t + k) + 0.01 * k * t
    };
    let mut worst = 0.0_f64;
    let inner = found[0].iter().enumerate();
    for (i, &time) in inner.take(found[0].len() - 2).skip(1) {
        for k in 0..2 {
            assert!((found[1 + k][i] - wave(k, time)).abs() < 1e-12);
        }
        for k in 2..6 {
            worst = worst.max((found[1 + k][i] - wave(k, time - 0.0004)).abs());
        }
    }
    println!("cubics between samples: {worst:.1e} rad");
    assert!(worst < 1e-9, "{worst}");
}

#[test]
fn a_log_may_lie_in_several_files_and_formats() {
    let log = r#"
time_s = "t_s"
link_position_rad = [{ file = "plain.npy", column = 2 }, { file = "plain.npy", column = 3 }]
motor_position_rad = { file = "flat.mat", column = "phi(*,:)", time = "t" }
motor_torque = { file = "zstd.mcap", topic = "/motor_states", field = "effort", unit = "N·m" }
"#;
    let found = read_log(&Files::Fixtures, "plain.csv", log).unwrap();
    assert!(difference(&found, &truth()) <= 1e-12);
    let short = "t_s,q1_rad,q2_rad\n0,1,2\n0.001,2,3\n";
    let files = Files::Memory(vec![
        ("log.csv", short.into()),
        (
            "more.csv",
            "phi1_rad,phi2_rad,tau1_nm,tau2_nm\n1,2,3,4\n".into(),
        ),
    ]);
    let log = r#"
time_s = "t_s"
link_position_rad = "q*_rad"
motor_position_rad = { file = "more.csv", column = "phi*_rad" }
motor_torque_nm = { file = "more.csv", column = "tau*_nm" }
"#;
    let error = read_log(&files, "log.csv", log).unwrap_err();
    says(
        &error,
        &[
            "more.csv ends after 1 rows, but log.csv continues",
            "time = \"…\"",
        ],
    );
}

#[test]
fn names_do_not_decide_what_a_file_is() {
    for (file, log) in [("zstd.parquet", USUAL), ("plain.npy", NUMBERS)] {
        let bytes = std::fs::read(crate::support::fixture(file)).unwrap();
        let files = Files::Memory(vec![("log.csv", bytes)]);
        let found = read_log(&files, "log.csv", log).unwrap();
        assert!(difference(&found, &truth()) <= 1e-12);
    }
}
