//! Accelerometers on the links of the demo's arm, described by its lengths.
//!
//! `cargo test --release -p sprung --test twin -- accelerometer --nocapture` prints the figures of
//! docs/how-to/inertial-sensors.md.

use sprung_base::demo;
use sprung_base::finding::{Finding, Severity};
use sprung_method::estimate::EstimateResult;
use sprung_model::{Model, Theta};
use sprung_robot::{self as description, Simulate, no_files};
use sprung_testing::{Figure, Messages, contains};

use crate::logs::{check_log, identify_log, named};
use crate::support::Twin;

/// Length of the first link, m.
const LENGTH: f64 = 0.3;

const LINKS: &str = "link_position_rad  = [\"q1_rad\", \"q2_rad\"]";
const GYROSCOPES: &str = "gyroscope_rad_per_s.z = [\"w1\", \"w2\"]";

/// One axis on each link, along its motion, or three tilted ones.
const ONE_AXIS: &str = "accelerometer_m_per_s2.y = [\"a1\", \"a2\"]";
const THREE_AXES: &str = "accelerometer_m_per_s2.x = \"ax*\"\naccelerometer_m_per_s2.y = \"ay*\"\n\
                          accelerometer_m_per_s2.z = \"az*\"";
const ALONG_LINKS: [&str; 2] = [
    "accelerometer_rpy_deg = [0, 0, 0]\naccelerometer_xyz_m = [0.25, 0, 0]",
    "accelerometer_rpy_deg = [0, 0, 0]\naccelerometer_xyz_m = [0.2, 0, 0]",
];
const TILTED: [&str; 2] = [
    "accelerometer_rpy_deg = [10, -20, 30]\naccelerometer_xyz_m = [0.25, 0.02, 0.01]",
    "accelerometer_rpy_deg = [-70, 15, 40]\naccelerometer_xyz_m = [0.2, -0.03, 0.02]",
];

/// 0.1 mg/√Hz at 1 kHz, and biases of 20 and -30 mg.
const NOISE: f64 = 0.022;
const BIAS: [f64; 2] = [0.2, -0.3];

/// The demo's arm with other sensors on its links.
///
/// - `mounting`: lines of each joint.
fn text(columns: &str, mounting: [&str; 2]) -> String {
    let estimators = "[\"prediction-error\", \"least-squares\", \"lsff\"]";
    let kinematics = format!("dh_modified = [{{}}, {{ a_m = {LENGTH} }}]");
    let text = (demo::EXPERIMENT)
        .replacen(LINKS, columns, 1)
        .replacen(estimators, "[\"least-squares\"]", 1)
        .replacen("kinematics = \"planar-2r\"", &kinematics, 1);
    // The nominal values have the names of the other description.
    let (begin, rest) = text.split_once("[robot.nominal]").unwrap();
    let (_, joints) = rest.split_once("[[robot.joint]]").unwrap();
    let mut text = format!("{begin}[[robot.joint]]{joints}");
    for (joint, mounting) in mounting.iter().enumerate() {
        let name = format!("name = \"joint{}\"", joint + 1);
        text = text.replacen(&name, &format!("{name}\n{mounting}"), 1);
    }
    text
}

fn twin(text: &str) -> Twin {
    let experiment = description::read("experiment.toml", text, &[], &mut no_files).unwrap();
    let model = Model::new(&experiment).unwrap();
    let known: toml::Table = toml::from_str(demo::TRUTH).unwrap();
    let known = |name: &str| known.get(name).and_then(toml::Value::as_float);
    let [total, coupling, second] =
        ["link1.inertia_total", "link2.coupling", "link2.inertia"].map(|name| known(name).unwrap());
    let value = |name: &str| match name {
        _ if name.starts_with("link1.izz") => total - second,
        _ if name.starts_with("link2.izz") => second,
        _ if name.starts_with("link2.mx") => coupling / LENGTH,
        _ => known(name).unwrap_or(0.0),
    };
    let truth: Theta = (model.parameters().iter())
        .map(|parameter| value(&parameter.name))
        .collect();
    Twin {
        experiment,
        model,
        truth,
    }
}

fn log(twin: &Twin, change: impl FnOnce(&mut Simulate)) -> Vec<u8> {
    let mut settings = twin.experiment.simulate.clone().unwrap();
    settings.duration_s = 30.0;
    settings.accelerometer_noise_m_per_s2 = vec![NOISE; 2];
    settings.accelerometer_bias_m_per_s2 = BIAS.to_vec();
    settings.gyroscope_noise_rad_per_s = vec![0.0022; 2];
    settings.gyroscope_bias_rad_per_s = vec![0.02, -0.03];
    change(&mut settings);
    twin.log(&settings)
}

fn identified(twin: &Twin, log: &[u8]) -> (EstimateResult, Vec<Finding>) {
    let found = identify_log(&twin.experiment, &twin.model, log).unwrap();
    let found = found.identification;
    for change in &found.applied {
        println!("  applied: {}", change.what);
    }
    (found.results[0].clone(), found.findings)
}

/// Prints the findings and the errors of the parameters. Returns the largest errors of the stiffnesses, of the inertias
/// of the links and of the rotor inertias, in percent.
fn errors(twin: &Twin, log: &[u8]) -> [f64; 3] {
    let (result, findings) = identified(twin, log);
    for finding in &findings {
        println!("  {}: {}", finding.code, finding.text);
    }
    let worst = |endings: &[&str]| {
        (result.parameters.iter().zip(&twin.truth))
            .filter(|(p, _)| endings.iter().any(|ending| p.name.contains(ending)))
            .filter(|(_, truth)| **truth != 0.0)
            .map(|(p, truth)| {
                let value = p.value.unwrap();
                let sigmas = (value - truth) / p.standard_error.unwrap();
                let error = 100.0 * (value / truth - 1.0);
                println!("  {}: {error:+.3} %, {sigmas:+.1} standard errors", p.name);
                error.abs()
            })
            .fold(0.0, f64::max)
    };
    [
        worst(&[".stiffness"]),
        worst(&["link1.", "link2."]),
        worst(&[".rotor_inertia"]),
    ]
}

/// Identifies a log of sensors with mountings from a description with the given ones.
fn follow(name: &str, columns: &str, mounted: [&str; 2], given: [&str; 2]) -> [f64; 3] {
    println!("{name}");
    let log = log(&twin(&text(columns, mounted)), |_| ());
    let found = errors(&twin(&text(columns, given)), &log);
    println!("{name}: stiffnesses, inertias of links and of rotors within {found:.2?} %");
    let kinds = ["stiffnesses", "inertias of the links", "rotor inertias"];
    for (kind, error) in kinds.into_iter().zip(found) {
        let key = format!("accelerometer, {name}, {kind}");
        let text = format!("{name}: largest error of the {kind}");
        Figure::lower(&key, &text, error, "%").note();
    }
    found
}

fn assert_within(found: [f64; 3], stiffness: f64) {
    assert!(
        found[0] < stiffness && found[1] < 5.0 && found[2] < 20.0,
        "{found:?}"
    );
}

#[test]
fn stiffnesses_and_inertias_follow_from_accelerations() {
    let open = ["", ""];
    follow("link encoders", LINKS, open, open);
    follow("gyroscopes", GYROSCOPES, open, open);
    assert_within(follow("one axis", ONE_AXIS, ALONG_LINKS, ALONG_LINKS), 2.0);
    assert_within(follow("three axes", THREE_AXES, TILTED, TILTED), 2.0);
}

#[test]
fn least_squares_is_the_default() {
    let text = text(ONE_AXIS, ALONG_LINKS).replacen("estimator = [\"least-squares\"]", "", 1);
    assert!(!text.contains("estimator ="), "{text}");
    let twin = twin(&text);
    let log = log(&twin, |settings| settings.duration_s = 15.0);
    assert_eq!(identified(&twin, &log).0.estimator, "least-squares");
}

/// Springs that are a hundred times stiffer and a motion that is five times larger: the links follow their motors.
fn stiffer(columns: &str, mounting: [&str; 2]) -> Twin {
    let text = text(columns, mounting).replace("amplitude_deg = 3.0", "amplitude_deg = 15.0");
    let mut twin = twin(&text);
    for (value, parameter) in twin.truth.iter_mut().zip(twin.model.parameters()) {
        if parameter.name.ends_with(".stiffness") {
            *value *= 100.0;
        }
    }
    twin
}

fn mountings(found: &[Finding]) -> Vec<&Finding> {
    (found.iter())
        .filter(|finding| finding.code == "accelerometer-mounting")
        .collect()
}

#[test]
fn a_mounting_must_be_given() {
    let recorded = twin(&text(THREE_AXES, TILTED));
    let found = checked(&recorded, &twin(&text(THREE_AXES, ["", ""])), |settings| {
        settings.duration_s = 8.0;
    });
    let errors = mountings(&found);
    assert_eq!(errors.len(), 2, "{found:#?}");
    for error in errors {
        println!("{}", error.text);
        assert_eq!(error.severity, Severity::Error);
    }
    contains(
        &named(&found, "link-by-inertial-sensor").text,
        &["leaves open that of joint1, joint2"],
    );
}

fn checked(recorded: &Twin, twin: &Twin, change: impl FnOnce(&mut Simulate)) -> Vec<Finding> {
    let log = log(recorded, change);
    check_log(&twin.experiment, &twin.model, &log).findings
}

#[test]
fn good_accelerometers_cause_notes_only() {
    let twin = twin(&text(ONE_AXIS, ALONG_LINKS));
    let found = checked(&twin, &twin, |_| ());
    println!("{found:#?}");
    assert!(
        found
            .iter()
            .all(|finding| finding.severity == Severity::Info)
    );
    let codes: Vec<&str> = found.iter().map(|finding| finding.code.as_str()).collect();
    assert!(codes.contains(&"link-by-inertial-sensor") && codes.contains(&"inertial-sensor-bias"));
}

#[test]
fn faulty_accelerometers_are_named() {
    let true_twin = stiffer(ONE_AXIS, ALONG_LINKS);
    let reversed = format!("{ONE_AXIS}\nsign = {{ a2 = -1 }}");
    for (code, columns, limit) in [
        ("inertial-sensor-saturated", ONE_AXIS, 2.0),
        ("inertial-sensor-sign", &reversed, f64::INFINITY),
        (
            "accelerometer-scale",
            "accelerometer_g.y = [\"a1\", \"a2\"]",
            f64::INFINITY,
        ),
    ] {
        let found = checked(&stiffer(columns, ALONG_LINKS), &true_twin, |settings| {
            settings.accelerometer_limit_m_per_s2 = vec![limit; 2];
        });
        let named = named(&found, code);
        println!("{}", named.text);
        assert_eq!(named.severity, Severity::Error);
    }
}

#[test]
fn mistakes_are_named() {
    let refused = |text: &str| {
        let found = description::read("experiment.toml", text, &[], &mut no_files);
        found.err().unwrap().to_string()
    };
    let mut messages = Messages::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/messages/accelerometer.txt"
    ));
    let description = text(ONE_AXIS, ALONG_LINKS);
    let both = text(&format!("{ONE_AXIS}\n{GYROSCOPES}"), ALONG_LINKS);
    messages.note("gyroscopes and accelerometers", &refused(&both));
    let with = |line: &str| description.replace(ONE_AXIS, &format!("{ONE_AXIS}\n{line}"));
    let two = with("accelerometer_m_per_s2.x = [\"b1\", \"b2\"]");
    messages.note("two axes", &refused(&two));
    let refined = description.replacen("[\"least-squares\"]", "[\"prediction-error\"]", 1);
    messages.note("refinement", &refused(&refined));
    let corner = with("accelerometer_corner_hz = 0.0");
    messages.note("a corner of zero", &refused(&corner));
    // These need the whole robot.
    let unsuited = |text: &str| {
        let experiment = description::read("experiment.toml", text, &[], &mut no_files).unwrap();
        let log = experiment.log.as_ref().unwrap();
        let found = sprung_log::Channels::new(&experiment.robot, log);
        found.err().unwrap().to_string()
    };
    let kinematics = format!("dh_modified = [{{}}, {{ a_m = {LENGTH} }}]");
    let planar = description.replacen(&kinematics, "kinematics = \"planar-2r\"", 1);
    messages.note("no lengths", &unsuited(&planar));
    let half = [ALONG_LINKS[0], "accelerometer_xyz_m = [0.2, 0, 0]"];
    messages.note("half a mounting", &unsuited(&text(ONE_AXIS, half)));
    let axis = "accelerometer_rpy_deg = [0, 0, 0]\naccelerometer_xyz_m = [0, 0, 0.1]";
    let on_axis = text(ONE_AXIS, [axis, ALONG_LINKS[1]]);
    messages.note("on the axis", &unsuited(&on_axis));
    messages.compare();
}
