//! Gyroscopes on the links of the demo's arm and of the arm with seven flexible joints.
//!
//! `cargo test --release -p sprung --test twin -- gyroscope --nocapture` prints the figures of
//! docs/how-to/inertial-sensors.md.

use sprung_base::demo;
use sprung_base::finding::{Finding, Severity};
use sprung_method::estimate::EstimateResult;
use sprung_model::{Model, Theta};
use sprung_robot::{self as description, Estimator, Simulate, no_files};
use sprung_testing::{Figure, Messages};

use crate::logs::{check_log, identify_log, named};
use crate::seven::{Arm, EXPERIMENT};
use crate::support::Twin;

const LINKS: &str = "link_position_rad  = [\"q1_rad\", \"q2_rad\"]";

/// One axis on each link of the demo, with 0.1 % of 125 °/s as noise, and a bias.
const ONE_AXIS: &str = "gyroscope_rad_per_s.z = [\"w1\", \"w2\"]";
const NOISE: f64 = 0.0022;
const BIAS: [f64; 2] = [0.02, -0.03];

fn twin(text: &str) -> Twin {
    let mut experiment = description::read("experiment.toml", text, &[], &mut no_files).unwrap();
    experiment.identify.estimator = vec![Estimator::LeastSquares];
    let model = Model::new(&experiment).unwrap();
    let truth = model.theta(&toml::from_str(demo::TRUTH).unwrap()).unwrap();
    Twin {
        experiment,
        model,
        truth,
    }
}

fn with_least_squares(columns: &str) -> String {
    let estimators = "[\"prediction-error\", \"least-squares\", \"lsff\"]";
    demo::EXPERIMENT
        .replacen(LINKS, columns, 1)
        .replacen(estimators, "[\"least-squares\"]", 1)
}

fn noisy(settings: &mut Simulate) {
    settings.gyroscope_noise_rad_per_s = vec![NOISE; 2];
    settings.gyroscope_bias_rad_per_s = BIAS.to_vec();
}

fn log(twin: &Twin, change: impl FnOnce(&mut Simulate)) -> Vec<u8> {
    let mut settings = twin.experiment.simulate.clone().unwrap();
    settings.duration_s = 30.0;
    noisy(&mut settings);
    change(&mut settings);
    twin.log(&settings)
}

fn identified(twin: &Twin, log: &[u8]) -> (EstimateResult, Vec<Finding>) {
    let found = identify_log(&twin.experiment, &twin.model, log).unwrap();
    let found = found.identification;
    (found.results[0].clone(), found.findings)
}

/// Returns the errors of the parameters with one of these endings, in percent.
fn errors(truth: &Theta, result: &EstimateResult, endings: &[&str]) -> Vec<f64> {
    (result.parameters.iter().zip(truth))
        .filter(|(p, _)| endings.iter().any(|ending| p.name.ends_with(ending)))
        .map(|(p, truth)| {
            let value = p.value.unwrap();
            let sigmas = (value - truth) / p.standard_error.unwrap();
            let error = 100.0 * (value / truth - 1.0);
            println!("{}: {error:+.3} %, {sigmas:+.1} standard errors", p.name);
            error
        })
        .collect()
}

const INERTIAS: [&str; 4] = ["inertia_total", "coupling", ".inertia", "rotor_inertia"];

fn worst(errors: &[f64]) -> f64 {
    errors.iter().map(|error| error.abs()).fold(0.0, f64::max)
}

#[test]
fn stiffnesses_and_inertias_are_as_accurate_as_with_link_encoders() {
    let encoders = twin(&with_least_squares(LINKS));
    let gyroscopes = twin(&with_least_squares(ONE_AXIS));
    let mut all = Vec::new();
    for (name, twin) in [("link encoders", &encoders), ("gyroscopes", &gyroscopes)] {
        println!("{name}");
        let (result, findings) = identified(twin, &log(twin, |_| ()));
        for finding in &findings {
            println!("  {}: {}", finding.code, finding.text);
        }
        for (kind, endings) in [
            ("stiffnesses", &[".stiffness"][..]),
            ("inertias", &INERTIAS),
        ] {
            let error = worst(&errors(&twin.truth, &result, endings));
            let key = format!("gyroscope, {name}, {kind}");
            let text = format!("{name}: largest error of the {kind}");
            Figure::lower(&key, &text, error, "%").note();
            all.push(error);
        }
    }
    println!("largest errors of stiffnesses and inertias, with encoders and gyroscopes: {all:.3?}");
    assert!(all[2] < 3.0 && all[3] < 15.0, "{all:?}");
}

/// Checks a log of the demo's arm, recorded with other columns than those of the check.
fn findings(recorded: &str, checked: &str, change: impl FnOnce(&mut Simulate)) -> Vec<Finding> {
    let log = log(&twin(&with_least_squares(recorded)), change);
    let twin = twin(&with_least_squares(checked));
    check_log(&twin.experiment, &twin.model, &log).findings
}

#[test]
fn good_gyroscopes_cause_notes_only() {
    let found = findings(ONE_AXIS, ONE_AXIS, |_| ());
    let codes: Vec<&str> = found.iter().map(|finding| finding.code.as_str()).collect();
    println!("{found:#?}");
    assert!(
        found
            .iter()
            .all(|finding| finding.severity == Severity::Info),
        "{codes:?}"
    );
    assert!(codes.contains(&"link-by-inertial-sensor") && codes.contains(&"inertial-sensor-bias"));
}

#[test]
fn faulty_gyroscopes_are_named() {
    type Case = (&'static str, &'static str, f64, Severity, &'static str);
    #[rustfmt::skip]
    let cases: [Case; 3] = [
        (
            "inertial-sensor-sign",
            "gyroscope_rad_per_s.z = [\"w1\", \"w2\"]\nsign = { w2 = -1 }",
            f64::INFINITY,
            Severity::Error,
            "sign = { \"w2\" = -1 }",
        ),
        ("gyroscope-scale", "gyroscope_deg_per_s.z = [\"w1\", \"w2\"]", f64::INFINITY, Severity::Error, ""),
        ("inertial-sensor-saturated", ONE_AXIS, 0.25, Severity::Error, ""),
    ];
    for (code, recorded, limit, severity, line) in cases {
        let found = findings(recorded, ONE_AXIS, |settings| {
            settings.gyroscope_limit_rad_per_s = vec![limit; 2];
        });
        let finding = named(&found, code);
        println!("{}", finding.text);
        assert_eq!(finding.severity, severity, "{code}");
        let setting = finding.setting.clone().unwrap_or_default();
        assert!(setting.contains(line), "{code}: {setting}");
    }
}

const LINKS_OF_ARM: &str = "link_position_rad  = [\"q1_rad\", \"q2_rad\", \"q3_rad\", \"q4_rad\", \"q5_rad\", \"q6_rad\", \"q7_rad\"]";
const THREE_AXES: &str = "gyroscope_rad_per_s.x = \"gx*\"\ngyroscope_rad_per_s.y = \"gy*\"\n\
                          gyroscope_rad_per_s.z = \"gz*\"";

/// The arm with seven joints and tilted gyroscopes, whose mounting the file gives or not.
fn arm(columns: &str, mounted: bool) -> Arm {
    let mut text = EXPERIMENT.replacen(LINKS_OF_ARM, columns, 1);
    assert_ne!(text, EXPERIMENT);
    if mounted {
        for joint in 1..=7 {
            let name = format!("name = \"joint{joint}\"");
            let mounting = format!("{name}\ngyroscope_rpy_deg = [{joint}0, -20, 30]");
            text = text.replacen(&name, &mounting, 1);
        }
    }
    Arm::of(&text, |e| {
        e.identify.estimator = vec![Estimator::LeastSquares];
    })
}

fn log_of_arm(arm: &Arm) -> Vec<u8> {
    arm.log(|settings| {
        settings.gyroscope_noise_rad_per_s = vec![NOISE; 7];
        settings.gyroscope_bias_rad_per_s = vec![0.01; 7];
    })
}

#[test]
fn mountings_are_found_in_space() {
    let log = log_of_arm(&arm(THREE_AXES, true));
    let unknown = arm(THREE_AXES, false);
    let found = unknown.identify(&log);
    let notes: Vec<&Finding> = (found.identification.findings.iter())
        .filter(|finding| finding.code == "gyroscope-mounting")
        .collect();
    assert_eq!(notes.len(), 7);
    for note in &notes {
        println!("{}", note.text);
    }
    for endings in [&[".stiffness"], &[".rotor_inertia"]] {
        errors(&unknown.truth, &found.identification.results[0], endings);
    }
    let known = arm(THREE_AXES, true);
    println!("known mountings");
    let found = known.identify(&log);
    let result = &found.identification.results[0];
    let stiffnesses = errors(&known.truth, result, &[".stiffness"]);
    errors(&known.truth, result, &[".rotor_inertia"]);
    assert!(worst(&stiffnesses[..4]) < 15.0);
    // The deflections of the wrist are as small as the noise.
    let mut notes = found.identification.findings.iter();
    let note = notes
        .find(|note| note.code == "link-by-inertial-sensor")
        .unwrap();
    println!("{}", note.text);
    assert_eq!(note.severity, Severity::Warning);
    assert!(note.text.contains("joint7, whose deflection contains"));
}

fn checked(arm: &Arm, log: &[u8]) -> Vec<Finding> {
    check_log(&arm.experiment, &arm.model, log).findings
}

#[test]
fn wrong_scales_are_named() {
    let log = log_of_arm(&arm(THREE_AXES, true));
    let in_degrees = checked(
        &arm(&THREE_AXES.replace("rad_per_s", "deg_per_s"), true),
        &log,
    );
    let of_scale = |found: &[Finding]| -> Vec<(Severity, String)> {
        (found.iter())
            .filter(|finding| finding.code == "gyroscope-scale")
            .map(|finding| (finding.severity, finding.text.clone()))
            .collect()
    };
    // Readings in radians that are declared as degrees are 57.3 times too small.
    let found = of_scale(&in_degrees);
    assert_eq!(found.len(), 7, "{in_degrees:#?}");
    let gain = ["gx*[joint1]", "gy*[joint1]", "gz*[joint1]"];
    let gain = gain.map(|column| format!("\"{column}\" = 1.3")).join(", ");
    let found = of_scale(&checked(
        &arm(&format!("{THREE_AXES}\ngain = {{ {gain} }}"), true),
        &log,
    ));
    println!("{found:?}");
    assert!(found.iter().any(|(severity, text)| {
        *severity == Severity::Warning && text.starts_with("joint1") && text.contains("1.30")
    }));
}

#[test]
fn exchanged_axes_are_named() {
    let log = log_of_arm(&arm(THREE_AXES, true));
    let exchanged = THREE_AXES.replace("gx*", "g?*").replace("gy*", "gx*");
    let found = checked(&arm(&exchanged.replace("g?*", "gy*"), true), &log);
    let named: Vec<&Finding> = (found.iter())
        .filter(|finding| finding.code == "gyroscope-axes")
        .collect();
    println!("{}", named[0].text);
    assert!(named.len() >= 5, "{found:#?}");
    assert!(
        named
            .iter()
            .all(|finding| finding.severity == Severity::Error)
    );
}

#[test]
fn mistakes_are_named() {
    let refused = |columns: &str, from: &str, to: &str| {
        let text = with_least_squares(columns).replacen(from, to, 1);
        let found = description::read("experiment.toml", &text, &[], &mut no_files);
        found.err().unwrap().to_string()
    };
    let mut messages = Messages::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/messages/gyroscope.txt"
    ));
    let two = ONE_AXIS.to_owned() + "\ngyroscope_rad_per_s.x = [\"v1\", \"v2\"]";
    messages.note("two axes", &refused(&two, "", ""));
    let both = format!("{LINKS}\n{ONE_AXIS}");
    messages.note("gyroscopes and link encoders", &refused(&both, "", ""));
    let corner = format!("{ONE_AXIS}\ngyroscope_corner_hz = 0.0");
    messages.note("a corner of zero", &refused(&corner, "", ""));
    let (linear, refined) = ("[\"least-squares\"]", "[\"prediction-error\"]");
    messages.note("refinement", &refused(ONE_AXIS, linear, refined));
    let joint = "torque_constant_nm_per_a";
    let cubic = format!("spring = [\"linear\", \"cubic\"]\n{joint}");
    messages.note("a cubic spring", &refused(ONE_AXIS, joint, &cubic));
    let one = "gyroscope_rad_per_s.z = [\"w1\"]";
    messages.note("one column", &refused(one, "", ""));
    messages.compare();
}
