//! Logs as machines recorded them, against tidy copies of these logs.

use std::path::Path;

use sprung_log::{Channels, Input, LogBlock, LogSource, Sampling, Timing};
use sprung_robot::{no_files, read};
use sprung_testing::data;

/// Reads a log in a folder: time, then channels.
fn log_of(folder: &Path, experiment: &str) -> Vec<Vec<f64>> {
    timed_log_of(folder, experiment).0
}

fn timed_log_of(folder: &Path, experiment: &str) -> (Vec<Vec<f64>>, Timing) {
    let experiment = read("experiment.toml", experiment, &[], &mut no_files).unwrap();
    let log = experiment.log.as_ref().unwrap();
    let channels = Channels::new(&experiment.robot, log).unwrap();
    let (folder, path) = (folder.to_owned(), log.file.clone().unwrap()[0].path.clone());
    let mut reader = move |other: Option<&Path>| -> std::io::Result<Box<dyn Input>> {
        Ok(Box::new(std::fs::File::open(
            folder.join(other.unwrap_or(&path)),
        )?))
    };
    let mut source = LogSource::files("log", &mut reader);
    let mut reader = source.open(&channels).unwrap();
    let mut block = LogBlock::new(channels.all.len());
    let mut all = vec![Vec::new(); 1 + channels.all.len()];
    while reader.read(&mut block).unwrap() {
        all[0].extend_from_slice(&block.time);
        for (column, values) in all[1..].iter_mut().zip(&block.values) {
            column.extend_from_slice(values);
        }
    }
    (all, reader.timing())
}

/// Largest difference relative to the largest number of each column, or to 1 if that is larger. The copies are
/// rounded to 8 decimals or 9 digits.
fn difference(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    assert_eq!(a.len(), b.len());
    let mut worst = 0.0_f64;
    for (a, b) in a.iter().zip(b) {
        assert_eq!(a.len(), b.len());
        let scale = a.iter().fold(1.0_f64, |scale, x| scale.max(x.abs()));
        for (x, y) in a.iter().zip(b) {
            worst = worst.max((x - y).abs() / scale);
        }
    }
    worst
}

#[test]
fn six_arrays_in_degrees() {
    let Some(folder) = data("quanser_2dsfl") else {
        return;
    };
    let recorded = include_str!("../../../../examples/quanser-2dsfl/as-recorded.toml");
    let tidy = include_str!("../../../../examples/quanser-2dsfl/experiment.toml");
    let (recorded, tidy) = (
        log_of(&folder.join("orig"), recorded),
        log_of(&folder, tidy),
    );
    let worst = difference(&recorded, &tidy);
    println!("{} samples, {worst:.1e} of the largest", tidy[0].len());
    // The currents have 8 decimals, and 5e-9 A are 4.5e-8 N·m at 8.9 N·m/A.
    assert!(worst < 5e-8, "{worst}");
}

#[test]
fn a_force_from_a_voltage() {
    let Some(folder) = data("emps") else {
        return;
    };
    let recorded = include_str!("../../../../examples/emps/as-recorded.toml");
    let tidy = include_str!("../../../../examples/emps/experiment.toml");
    let (recorded, tidy) = (
        log_of(&folder.join("orig"), recorded),
        log_of(&folder, tidy),
    );
    let worst = difference(&recorded, &tidy);
    println!("{} samples, {worst:.1e} of the largest", tidy[0].len());
    // The copy has 8 decimals or 9 digits, so its rounding is at most 5e-9. The largest value is above 0.5.
    assert!(worst < 1e-8, "{worst}");
}

/// Six joints with only positions and torques.
fn six(log: &str) -> String {
    let joints: Vec<String> = [121, 121, 101, 101, 101, 101]
        .into_iter()
        .enumerate()
        .map(|(i, ratio)| {
            format!(
                "[[robot.joint]]\nname = \"a{}\"\ngear_ratio = {ratio}.0\n",
                i + 1
            )
        })
        .collect();
    format!(
        "format = 1\n[robot]\nname = \"six\"\ndh_modified = [{{}}, {{}}, {{}}, {{}}, {{}}, {{}}]\n{}[log]\n{log}",
        joints.join("")
    )
}

#[test]
fn raw_counts_of_two_encoders() {
    let Some(folder) = data("neura_lara8") else {
        return;
    };
    for (tidy, recorded) in [
        ("lara8_jog_joint2_mass.csv", "jogging_joint_mass.csv"),
        ("lara8_jog_cart.csv", "jogging_final.csv"),
    ] {
        let counts = "unit = \"counts\", counts_per_turn = 16777216, sign = [-1, -1, 1, -1, 1, -1], \
                      starts_at_rad = \"joint_angles_*\"";
        let raw = six(&format!(
            "file = \"{recorded}\"\nperiod_s = 0.004\n\
             link_position = {{ column = \"encoder_loadinc_*\", wrap = 16777216, {counts} }}\n\
             motor_position = {{ column = \"encoder_motorinc_*\", side = \"motor\", {counts} }}\n\
             motor_torque_nm = \"joint_torque_current_*\"\n"
        ));
        let plain = six(&format!(
            "file = \"{tidy}\"\nperiod_s = 0.004\nlink_position_rad = \"q_link*\"\n\
             motor_position_rad = \"theta_motor*\"\nmotor_torque_nm = \"tau_motor*\"\n"
        ));
        let (raw, plain) = (log_of(&folder.join("orig"), &raw), log_of(&folder, &plain));
        let worst = difference(&raw, &plain);
        println!(
            "{recorded}: {} samples, {worst:.1e} of the largest",
            raw[0].len()
        );
        // The copy has 8 decimals or 9 digits, so its rounding is at most 5e-9. The largest value is above 0.5.
        assert!(worst < 1e-8, "{worst}");
    }
}

#[test]
fn a_controller_of_2_ms_and_a_recorder_that_is_late() {
    let Some(folder) = data("neura_lara8") else {
        return;
    };
    for recorded in ["jogging_joint_mass.csv", "jogging_final.csv"] {
        let counts = "unit = \"counts\", counts_per_turn = 16777216, sign = [-1, -1, 1, -1, 1, -1], \
                      starts_at_rad = \"joint_angles_*\"";
        let log = six(&format!(
            "file = \"{recorded}\"\ntime_s = \"Timestamp\"\n\
             link_position = {{ column = \"encoder_loadinc_*\", wrap = 16777216, {counts} }}\n\
             motor_position = {{ column = \"encoder_motorinc_*\", side = \"motor\", {counts} }}\n\
             motor_torque_nm = \"joint_torque_current_*\"\n"
        ));
        let (columns, timing) = timed_log_of(&folder.join("orig"), &log);
        println!("{recorded}: {timing:?}");
        // The logged targets of the controller advance by whole multiples of 2 ms.
        let cycle = timing.sampling.and_then(Sampling::cycle).unwrap();
        // The clocks of controller and recorder are quartzes, which are wrong by up to 50 ppm each.
        assert!((cycle / 2e-3 - 1.0).abs() < 1e-4, "{cycle}");
        // The recorder is late in few samples: fewer than one of twenty.
        let samples = columns[0].len() as u64;
        assert!(
            20 * timing.interpolated < samples && timing.gaps.count == 0,
            "{timing:?}"
        );
        // There is one period less than samples, and the last sample may be late by another one.
        let off = timing.period * columns[0].len() as f64 - timing.duration;
        assert!(off.abs() < 2.0 * timing.period, "{off}");
    }
}
