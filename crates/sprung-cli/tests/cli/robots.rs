//! Identification of small robots: gravity, friction, given parameters, several logs.

use std::fmt::Write as _;

use serde_json::Value;
use sprung_core::spatial::BODY_NAMES;

use crate::arm::{EXPERIMENT, URDF, described, read, recorded};
use crate::common::{
    Case, assert_true, contains, f64_of, finding, found, list_of, parameter, sprung, str_of, value,
};

/// An arm with one vertical and two horizontal axes, described by a table, with a log.
fn turret() -> Case {
    let mut nominal = String::new();
    #[rustfmt::skip]
    let rows = [
        (1, &[("izz", 0.02)][..]),
        (2, &[("m", 3.0), ("mx", 0.6), ("ixx", 0.01), ("iyy", 0.17), ("izz", 0.17)]),
        (3, &[("m", 1.5), ("mx", 0.2), ("ixx", 0.005), ("iyy", 0.05), ("izz", 0.05)]),
    ];
    for (link, given) in rows {
        for name in BODY_NAMES {
            let entry = given.iter().find(|(known, _)| *known == name);
            let number = entry.map_or(0.0, |(_, number)| *number);
            writeln!(nominal, "\"link{link}.{name}\" = {number:?}").unwrap();
        }
    }
    let shoulder = EXPERIMENT.find("[[robot.joint]]").unwrap();
    let text = format!(
        "format = 1
[robot]
name = \"turret\"
dh_modified = [{{}}, {{ alpha_deg = 90.0 }}, {{ a_m = 0.4 }}]
[robot.nominal]
{nominal}
[[robot.joint]]
name = \"pan\"
transmission = \"rigid\"
nominal = {{ rotor_inertia = 0.2, motor_viscous = 1.0, motor_coulomb = 0.5, motor_offset = 0.1 }}
{}",
        &EXPERIMENT[shoulder..]
    );
    let case = Case::of(&[("experiment.toml", &text)])
        .replace("[\"phi1\", \"phi2\"]", "[\"phi0\", \"phi1\", \"phi2\"]")
        .replace("[\"tau1\", \"tau2\"]", "[\"tau0\", \"tau1\", \"tau2\"]")
        .replace("[300.0, 100.0]", "[100.0, 300.0, 100.0]")
        .replace("[10.0, 5.0]", "[5.0, 10.0, 5.0]")
        .replace("[0.02, 0.01]", "[0.01, 0.02, 0.01]")
        .replace(
            "sines = [",
            "sines = [
  { joint = \"pan\", amplitude_deg = 20.0, frequency_hz = 0.4, phase_deg = 90.0 },
  { joint = \"pan\", amplitude_deg = 20.0, frequency_hz = 1.1, phase_deg = -90.0 },",
        );
    case.record("run.csv", &[]);
    case
}

#[test]
fn a_zero_that_is_a_right_angle_off_is_named() {
    let off = [
        "--set",
        "robot.joint.shoulder.position_offset_deg=90.0",
        "--set",
        "identify.on_check_error=go-on",
    ];
    // The pan turns the arm about the vertical, so no direction of gravity explains the torques.
    let (_, json) = turret().results(&off);
    assert_eq!(finding(&json, "gravity-tilted"), None);
    let zero = found(&json, "zero-off").unwrap();
    let text = str_of(&zero["text"]);
    contains(text, &["-90° added to the positions of shoulder"]);
    assert_eq!(
        zero["remedy"],
        "set position_offset_deg = 0 in the block of shoulder"
    );

    // Without the pan, both explanations are the same motion of the robot.
    let (_, json) = recorded().results(&off);
    assert_eq!(finding(&json, "zero-off"), None);
    let tilted = found(&json, "gravity-tilted").unwrap();
    let (text, remedy) = (str_of(&tilted["text"]), str_of(&tilted["remedy"]));
    contains(
        text,
        &["or the zero of shoulder differs from that of the model by 90°"],
    );
    contains(
        remedy,
        &["set position_offset_deg = 0 in the block of shoulder"],
    );
}

#[test]
fn gravity_in_a_wrong_frame_is_found_and_named() {
    let case = turret();
    let (_, json) = case.results(&[]);
    assert_eq!(finding(&json, "gravity-tilted"), None);
    for (gravity, angle) in [
        ("[0.0, 0.0, 9.81]", "turned by 180°"),
        ("[0.0, 9.81, 0.0]", "turned by 90°"),
        ("[3.355, 0.0, -9.218]", "turned by 20°"),
    ] {
        let set = format!("robot.gravity_m_per_s2={gravity}");
        let (code, json) = case.results(&["--set", &set]);
        let text = finding(&json, "gravity-tilted").unwrap_or_else(|| panic!("{gravity}"));
        println!("{text}");
        assert_eq!(code, 0);
        assert!(text.contains(angle), "{gravity}: {text}");
        contains(
            text,
            &["the base is mounted differently from what the file says"],
        );
        let remedy = str_of(&found(&json, "gravity-tilted").unwrap()["remedy"]);
        let (_, list) = remedy.split_once("gravity_m_per_s2 = [").unwrap();
        let named: Vec<f64> = (list.split(']').next().unwrap().split(','))
            .map(|x| x.trim().parse().unwrap())
            .collect();
        // The direction in the remedy is within two degrees of the true one.
        assert!(named[2] < -9.81 * 2_f64.to_radians().cos(), "{remedy}");
        let (_, json) = case.results(&["--set", &format!("robot.gravity_m_per_s2={named:?}")]);
        assert_eq!(finding(&json, "gravity-tilted"), None, "{remedy}");
    }
}

#[test]
fn twin_of_a_table_comes_back() {
    let (code, json) = turret().results(&[]);
    assert_eq!(code, 0);
    let truth = [
        ("link2.mx + 0.4*link3.m", 1.2),
        ("link2.izz + 0.16*link3.m", 0.41),
        ("shoulder.stiffness", 400.0),
        ("shoulder.rotor_inertia", 0.3),
        ("elbow.motor_viscous", 1.0),
        ("pan.motor_coulomb", 0.5),
    ];
    assert_true(&json, &truth);
}

/// A wheel with Stribeck friction. Its log has no noise.
fn wheel(laws: &str, velocity: f64) -> Case {
    let text = format!(
        "format = 1
[robot]
name = \"wheel\"
dh_modified = [{{}}]
[robot.nominal]
\"link1.izz\" = 0.5
[[robot.joint]]
name = \"wheel\"
transmission = \"rigid\"
motor_friction = [{laws}]
nominal = {{ rotor_inertia = 0.1, motor_viscous = 1.0, motor_coulomb = 1.0, motor_coulomb_positive = 1.0, motor_coulomb_negative = 0.6, motor_stribeck = 1.0 }}
[log]
file = \"run.csv\"
time_s = \"t\"
motor_position_rad = [\"phi\"]
motor_torque_nm = [\"tau\"]
[identify]
estimator = \"least-squares\"
position_cutoff_hz = 40.0
[controller]
kind = \"pd\"
kp_nm_per_rad = [100.0]
kd_nms_per_rad = [5.0]
[controller.reference]
sines = [
  {{ joint = \"wheel\", amplitude_deg = 20.0, frequency_hz = 0.4, phase_deg = 90.0 }},
  {{ joint = \"wheel\", amplitude_deg = 20.0, frequency_hz = 0.1, phase_deg = -90.0 }},
]
[simulate]
"
    );
    let case = Case::of(&[("experiment.toml", &text)]);
    let set = format!("robot.joint.wheel.stribeck_velocity_rad_per_s={velocity}");
    case.record("run.csv", &["--set", &set]);
    case
}

#[test]
fn stribeck_velocity_is_found() {
    for truth in [0.03, 0.1, 0.3] {
        let case = wheel("\"viscous\", \"coulomb\", \"stribeck\"", truth);
        let (_, json) = case.results(&["-v"]);
        let found = f64_of(&json["results"][0]["stribeck_velocity"]["wheel"]);
        println!("{truth} rad/s: found {found:.4}");
        // The search tries nine velocities in equal ratios over a factor of 0.5 / 0.003, and then makes eight golden
        // sections of two of these ratios. Each of its two ends may be wrong by what is left.
        let ratio = (0.5_f64 / 0.003).ln() / 8.0;
        let left = 2.0 * ratio * 0.618_f64.powi(8);
        assert!((found / truth).ln().abs() < 2.0 * left, "{found} {truth}");
        contains(
            finding(&json, "stribeck-velocity").unwrap(),
            &["was found by a search"],
        );
        assert_true(&json, &[("wheel.motor_stribeck", 1.0)]);
        // A given velocity is not searched.
        let set = format!("robot.joint.wheel.stribeck_velocity_rad_per_s={truth}");
        let (_, json) = case.results(&["-v", "--set", &set]);
        assert_eq!(finding(&json, "stribeck-velocity"), None);
        assert_eq!(json["results"][0]["stribeck_velocity"]["wheel"], truth);
    }
}

#[test]
fn validation_uses_the_velocities_of_the_identification() {
    let case = wheel("\"viscous\", \"coulomb\", \"stribeck\"", 0.03);
    let laws = "robot.joint.wheel.motor_friction=[\"viscous\", \"coulomb\", \"presliding\"]";
    for laws in [&[][..], &["--set", laws]] {
        let (_, json) = case.results(laws);
        let identified = f64_of(&json["results"][0]["relative_residual"]["wheel.motor_nm"]);
        let experiment = case.at("experiment.toml");
        let run = "validate=[{ name = \"same log\" }]";
        let mut words = vec!["validate", &experiment, "--json"];
        words.extend(["--set", run]);
        words.extend(laws);
        let validation: Value = serde_json::from_str(&sprung(&words).out).unwrap();
        let set = &validation["runs"][0]["sets"][0];
        let again = f64_of(&set["torque_relative_residual"]["wheel"]);
        // With the velocities before a search the residual is 0.03 and 0.2.
        assert!(
            (again / identified - 1.0).abs() < 0.1,
            "{identified} {again}"
        );
        let beside = json["results"][0]["dependence"].as_array();
        // Viscous and Coulomb friction, which both further laws resemble.
        assert_eq!(beside.map(Vec::len), Some(2));
    }
}

#[test]
fn stribeck_friction_that_is_not_there_comes_out_small() {
    let case = wheel("\"viscous\", \"coulomb\"", 0.1);
    let laws = "[\"viscous\", \"coulomb\", \"stribeck\"]";
    let set = format!("robot.joint.wheel.motor_friction={laws}");
    let (_, json) = case.results(&["--set", &set]);
    let truth = [("wheel.motor_stribeck", 0.0), ("wheel.motor_coulomb", 1.0)];
    assert_true(&json, &truth);
}

#[test]
fn friction_of_each_direction() {
    let case = wheel("\"viscous\", \"coulomb-asymmetric\"", 0.1);
    let (_, json) = case.results(&[]);
    let truth = [
        ("wheel.motor_coulomb_positive", 1.0),
        ("wheel.motor_coulomb_negative", 0.6),
    ];
    assert_true(&json, &truth);
}

#[test]
fn laws_of_an_earlier_result_give_one_model() {
    let case = wheel("\"viscous\", \"coulomb\"", 0.1);
    let declared = "robot.joint.wheel.motor_friction=[\"viscous\"]";
    let (_, first) = case.results(&["--set", declared]);
    let added = |json: &Value| json["unknowns"][0]["law"]["law"].clone();
    assert_eq!(added(&first), "coulomb");
    assert_eq!(first["applied"][0]["kind"], "law");
    let earlier = case.path("earlier.json");
    std::fs::copy(case.path("sprung-out/identification.json"), &earlier).unwrap();
    let earlier = earlier.to_str().unwrap();
    let (_, second) = case.results(&["--set", declared, "--laws-from", earlier]);
    assert_eq!(added(&second), "coulomb");
    assert_eq!(second["unknowns"][0]["status"], "given");
    let coulomb = |json: &Value| value(json, "wheel.motor_coulomb");
    assert!((coulomb(&first) - coulomb(&second)).abs() < 1e-9);
    // Later commands know the law.
    let run = "validate=[{ name = \"same log\" }]";
    case.run("validate", &["--json", "--set", run, "--set", declared])
        .ends(0);
}

#[test]
fn urdf_without_inertias() {
    let case = recorded();
    let start = URDF.find("<inertial>").unwrap();
    let end = URDF.rfind("</inertial>").unwrap() + "</inertial>".len();
    let bare: String = URDF[start..end]
        .split_inclusive("</inertial>")
        .map(|part| part.split("<inertial>").next().unwrap())
        .collect();
    let bare = [&URDF[..start], &bare, &URDF[end..]].concat();
    assert!(!bare.contains("inertial"));
    case.write("arm.urdf", bare);
    let (code, json) = case.results(&[]);
    assert_eq!(code, 0);
    let mass = "upper.mx + 0.4*fore.m";
    assert_eq!(parameter(&json, mass)["nominal"], Value::Null);
    assert_true(&json, &[(mass, 1.2)]);
    // Without inertias the robot cannot be simulated.
    sprung(&["simulate", &case.at("")])
        .ends(2)
        .tells(&["no value for upper.mx + 0.4*fore.m"]);
}

#[test]
fn what_is_given_comes_out_as_given() {
    let fixed = "robot.fixed={\"shoulder.stiffness\"=401.5,\"elbow.rotor_inertia\"=0.05,\
                 \"fore.mx\"=0.2251}";
    let (code, json) = recorded().results(&["--set", fixed]);
    assert_eq!(code, 0);
    for (name, given) in [
        ("shoulder.stiffness", 401.5),
        ("elbow.rotor_inertia", 0.05),
        ("fore.mx", 0.2251),
    ] {
        let p = parameter(&json, name);
        assert_eq!(p["value"], given, "{p}");
        assert!(p["standard_error"].is_null() && p["ci95"].is_null(), "{p}");
        assert_eq!(p["fixed"], true, "{p}");
    }
    assert_eq!(parameter(&json, "shoulder.rotor_inertia")["fixed"], false);
    let unknowns = json["results"][0]["unknowns"].as_u64().unwrap();
    let all = list_of(&json["results"][0]["parameters"]).len() as u64;
    assert_eq!(unknowns, all - 3);
    // A rotor inertia that is lumped with its link becomes a separate parameter if it is given.
    let lumped = "link1.izz + wheel.rotor_inertia";
    let case = wheel("\"viscous\", \"coulomb\"", 0.1);
    let (_, json) = case.results(&[]);
    assert_true(&json, &[(lumped, 0.6)]);
    let (_, json) = case.results(&["--set", "robot.fixed={\"wheel.rotor_inertia\"=0.1}"]);
    assert_eq!(parameter(&json, "wheel.rotor_inertia")["fixed"], true);
    assert_true(&json, &[("link1.izz", 0.5)]);
}

#[test]
fn what_is_assumed_zero_is_gone() {
    let zero = "robot.assume_zero=[\"upper.mz\",\"fore.mz\"]";
    let (code, json) = recorded().results(&["--set", zero]);
    assert_eq!(code, 0);
    let text = json["results"][0]["parameters"].to_string();
    assert!(!text.contains("mz"), "{text}");
}

#[test]
fn several_logs_count_together() {
    let case = recorded();
    case.record("second.csv", &["--set", "simulate.seed=2"]);
    let both = "log.file=[\"run.csv\",\"second.csv\"]";
    let (code, json) = case.results(&["--set", both]);
    assert_eq!(code, 0);
    assert_eq!(json["log"]["samples"], 3000);
    assert_eq!(json["further_logs"][0]["samples"], 3000);
    assert_eq!(json["further_logs"][0]["file"], "second.csv");
    assert_true(&json, &[("shoulder.stiffness", 400.0)]);
    contains(
        &case.read("sprung-out/report.html"),
        &["run.csv, second.csv (6000 samples, 12.00 s)"],
    );
    // In the curves, the second log follows the first.
    for file in ["trace.csv", "fit.csv"] {
        let text = read(&case.path("sprung-out").join(file));
        let rows = text
            .lines()
            .skip(1)
            .map(|line| line.split(',').collect::<Vec<_>>());
        let times: Vec<(&str, f64)> = rows.map(|row| (row[0], row[1].parse().unwrap())).collect();
        let rises = |w: &[(&str, f64)]| w[0].0 != w[1].0 || w[0].1 < w[1].1;
        assert!(times.windows(2).all(rises), "{file}");
        let last = times.last().unwrap().1;
        // The two logs last 12 s together; the curves end up to 10 ms earlier.
        assert!((11.0..=12.0).contains(&last), "{file} ends at {last} s");
    }
    // Each log is checked separately.
    let broken = case.read("second.csv").replacen("0.002,", "0.000,", 1);
    case.write("second.csv", broken);
    case.identify(&["--set", both])
        .ends(3)
        .tells(&["second.csv: time goes from"]);
}

#[test]
fn a_log_in_two_files_is_the_whole() {
    let case = recorded();
    let text = case.read("run.csv");
    let lines: Vec<&str> = text.lines().collect();
    let (head, rows) = lines.split_first().unwrap();
    for (file, part) in [("a.csv", &rows[..1400]), ("b.csv", &rows[1400..])] {
        case.write(file, [&[*head], part].concat().join("\n"));
    }
    // At a low cut-off, the zero-phase filter has a long transient on both sides of the cut.
    let fast = "identify.position_cutoff_hz=100";
    let (_, whole) = case.results(&["--set", fast]);
    let files = "log.file=[\"a.csv\",\"b.csv\"]";
    let (_, parts) = case.results(&["--set", fast, "--set", files]);
    for p in list_of(&whole["results"][0]["parameters"]) {
        let name = str_of(&p["name"]);
        let (a, b) = (f64_of(&p["value"]), value(&parts, name));
        let error = f64_of(&p["standard_error"]);
        println!("{name}: {a:.5} ± {error:.5}, in two files {b:.5}");
        // Beside the cut, about 130 of 3000 samples are lost to filters that settle. Without a share of the samples, an
        // estimate moves by the root of this share of its standard error.
        let moved = (130_f64 / 3000.0).sqrt() * error;
        assert!((a - b).abs() < 4.0 * moved, "{name}: {a} {b}");
    }
}

#[test]
fn lsff_needs_logs_of_one_period() {
    let case = recorded();
    case.record("second.csv", &["--set", "simulate.period_s=0.001"]);
    let both = "log.file=[\"run.csv\",\"second.csv\"]";
    case.identify(&["--set", both, "--set", "identify.estimator=lsff"])
        .ends(2)
        .tells(&["runs at one sampling period, the logs have 0.002000 s and 0.001000 s"]);
    // Least squares accepts logs with different periods.
    let (code, json) = case.results(&["--set", both]);
    assert_eq!(code, 0);
    assert_true(&json, &[("shoulder.stiffness", 400.0)]);
}

#[test]
fn a_rigid_robot_may_call_its_positions_those_of_its_links() {
    let case = wheel("\"viscous\", \"coulomb\"", 0.1);
    let (_, motor) = case.results(&[]);
    let case = case.replace("motor_position_rad", "link_position_rad");
    let (code, link) = case.results(&[]);
    assert_eq!(code, 0);
    assert_eq!(
        motor["results"][0]["parameters"],
        link["results"][0]["parameters"]
    );
    // Positions of the motors must not be given too.
    case.identify(&["--set", "log.motor_position_rad=[\"phi\"]"])
        .ends(2)
        .tells(&["wheel is rigid, so motor and link have one position"]);
}

#[test]
fn names_with_dots_and_commas() {
    let case = recorded()
        .replace("\"elbow\"", "\"el.bow 1\"")
        .replace_in("arm.urdf", "name=\"elbow\"", "name=\"el.bow 1\"")
        .replace_in("arm.urdf", "\"fore\"", "\"fore, &lt;b&gt;left&lt;/b&gt;\"");
    let (code, json) = case.results(&[]);
    assert_eq!(code, 0);
    let truth = [
        ("el.bow 1.motor_viscous", 1.0),
        ("fore, <b>left</b>.mx", 0.225),
    ];
    assert_true(&json, &truth);
    contains(
        &case.read("sprung-out/parameters.csv"),
        &[",\"fore, <b>left</b>.mx\","],
    );
    let report = case.read("sprung-out/report.html");
    assert!(!report.contains("<b>left"), "a name became markup");
    case.identify(&["--set", "robot.joint.\"el.bow 1\".gear_ratio=0"])
        .tells(&["el.bow 1: gear_ratio = 0"]);
    described()
        .replace("\"elbow\"", "\"el,bow\"")
        .replace_in("arm.urdf", "name=\"elbow\"", "name=\"el,bow\"")
        .fails(2, &["line 12 of", "\"el,bow\" must consist of letters"]);
}

#[test]
fn many_joints() {
    let case = |n: usize, more: &str| {
        let names = |letter| {
            (1..=n)
                .map(move |i| format!("\"{letter}{i}\""))
                .collect::<Vec<_>>()
        };
        let joint = |i| format!("[[robot.joint]]\nname = \"j{i}\"\ntransmission = \"rigid\"\n");
        let rows: Vec<String> = (0..n)
            .map(|i| format!("{{ alpha_deg = {:?}, a_m = 0.1 }}", [0.0, 90.0][i % 2]))
            .collect();
        let text = format!(
            "format = 1\n[robot]\ndh_modified = [{}]\n{}[log]\nfile = \"run.csv\"\ntime_s = \"t\"\n\
             motor_position_rad = [{}]\nmotor_torque_nm = [{}{more}]\n[identify]\n\
             estimator = \"least-squares\"\nposition_cutoff_hz = 20.0\n",
            rows.join(", "),
            (1..=n).map(joint).collect::<String>(),
            names('p').join(", "),
            names('u').join(", ")
        );
        let mut log = format!("t,{},{}\n", names('p').join(","), names('u').join(","));
        for k in 0..600 {
            let t = f64::from(k) * 0.004;
            let wave = |i: usize| (t * (1.0 + 0.37 * i as f64) + i as f64).sin();
            let cells = (0..n).map(wave).chain((0..n).map(|i| 3.0 * wave(i + 1)));
            let cells: Vec<String> = cells.map(|x| x.to_string()).collect();
            writeln!(log, "{t},{}", cells.join(",")).unwrap();
        }
        Case::of(&[
            ("experiment.toml", &text),
            ("run.csv", &log.replace('"', "")),
        ])
    };
    let (_, json) = case(8, "").results(&[]);
    let parameters = list_of(&json["results"][0]["parameters"]);
    assert_eq!(parameters.len(), 80);
    case(40, ", \"one\"").fails(
        2,
        &["motor_torque_nm names 41 columns, the robot has 40 joints (j1, j2, j3"],
    );
    // A model of forty joints is built; only the log is missing.
    let forty = case(40, "");
    forty.remove("run.csv");
    forty.fails(4, &["cannot read", "run.csv"]);
}
