//! Friction that changes with temperature, time and wear.

use std::collections::BTreeMap;

use sprung::session::{Parameters, Session};
use sprung_base::demo;
use sprung_base::progress::Unheard;
use sprung_method::estimate::Identification;
use sprung_testing::contains;

use crate::support::{messages, opener, owned, recorded};

/// Changes of the friction of both motors, per kelvin.
const CHANGES: &str = "\n\"joint1.motor_viscous_per_k\" = -0.12\n\"joint1.motor_coulomb_per_k\" = -0.015\n\
                       \"joint2.motor_viscous_per_k\" = -0.002\n";

const NAMES: [(&str, f64); 3] = [
    ("joint1.motor_viscous_per_k", -0.12),
    ("joint1.motor_coulomb_per_k", -0.015),
    ("joint2.motor_viscous_per_k", -0.002),
];

/// The covariates of both joints.
type OfJoints = [&'static str; 2];

const TEMPERATURES: OfJoints = [
    "temperature = [\"motor_viscous\", \"motor_coulomb\"], reference_c = 35.0",
    "temperature = [\"motor_viscous\"], reference_c = 35.0",
];

/// Returns the demo's experiment with covariates.
fn experiment(covariates: OfJoints) -> String {
    let key = "torque_constant_nm_per_a";
    let with = |covariates: &str| format!("friction_covariates = {{ {covariates} }}\n{key}");
    let mut text = demo::EXPERIMENT.replacen(key, &with(covariates[0]), 1);
    let at = text.rfind(key).unwrap();
    text.replace_range(at..at + key.len(), &with(covariates[1]));
    text = text.replace(
        "[\"prediction-error\", \"least-squares\", \"lsff\"]",
        "[\"least-squares\"]",
    );
    text.replace(
        "motor_torque_nm    =",
        "temperature_c = [\"warm1\", \"warm2\"]\nmotor_torque_nm    =",
    )
}

fn session(log: &[u8], more: &[&str]) -> Result<Session, String> {
    with_truth((TEMPERATURES, CHANGES), &[log.to_vec()], more)
}

/// Returns a session with logs `0.csv`, `1.csv` and so on, of which the first one is that of the demo.
fn with_truth(
    (covariates, changes): (OfJoints, &str),
    logs: &[Vec<u8>],
    more: &[&str],
) -> Result<Session, String> {
    let truth = [demo::TRUTH, changes].concat();
    let mut files = BTreeMap::from([("truth.toml".to_owned(), truth.into_bytes())]);
    for (i, log) in logs.iter().enumerate() {
        files.insert(format!("{i}.csv"), log.clone());
    }
    let first = logs.first().cloned().unwrap_or_default();
    files.insert("identification.csv".to_owned(), first.clone());
    files.insert("validation.csv".to_owned(), first);
    let open = opener(files);
    let usual = [
        "identify.estimator=[\"least-squares\"]",
        "simulate.duration_s=30.0",
    ];
    let overrides = owned(&[&usual[..], more].concat());
    Session::read("experiment.toml", &experiment(covariates), &overrides, open)
        .map_err(|error| error.to_string())
}

fn log(temperatures: [&str; 2]) -> Vec<u8> {
    let keys = [
        format!("simulate.temperature_start_c={}", temperatures[0]),
        format!("simulate.temperature_end_c={}", temperatures[1]),
    ];
    recorded(&session(&[], &[&keys[0], &keys[1]]).unwrap())
}

fn identified(log: &[u8]) -> Identification {
    let found = session(log, &[]).unwrap().identify(&mut Unheard).unwrap();
    found.identification
}

/// Returns the columns of temperatures that hardly change by the findings.
fn hardly_change(found: &Identification) -> Vec<&str> {
    (found.findings.iter())
        .filter(|finding| finding.code == "covariate-hardly-changes")
        .filter_map(|finding| finding.evidence.as_ref()?.column.as_deref())
        .collect()
}

#[test]
fn changes_of_friction_with_the_temperature_are_found() {
    let log = log(["[25.0, 28.0]", "[45.0, 42.0]"]);
    assert!(log.starts_with(b"t_s,q1_rad,q2_rad,phi1_rad,phi2_rad,tau1_nm,tau2_nm,warm1,warm2\n"));
    let found = identified(&log);
    assert_eq!(hardly_change(&found), [""; 0]);
    let result = &found.results[0];
    for (name, truth) in NAMES {
        let parameter = result.parameter(name).unwrap();
        let (value, error) = (parameter.value.unwrap(), parameter.standard_error.unwrap());
        assert!(
            (value - truth).abs() < 3.0 * error,
            "{name} {value} {error}"
        );
        assert!(error < 0.4 * truth.abs(), "{name} {error}");
    }
    assert_eq!(result.parameter(NAMES[0].0).unwrap().unit, "N·m·s/rad/K");
    // The friction at the reference is that of the demo.
    let viscous = result.parameter("joint1.motor_viscous").unwrap();
    assert!((viscous.value.unwrap() / 8.435_283 - 1.0).abs() < 0.02);
}

#[test]
fn a_constant_temperature_tells_nothing_about_its_effect() {
    let found = identified(&log(["[35.0, 35.0]", "[35.0, 35.0]"]));
    assert_eq!(hardly_change(&found), ["warm1", "warm2"]);
    let result = &found.results[0];
    for (name, _) in NAMES {
        let parameter = result.parameter(name).unwrap();
        assert!(
            !parameter.identifiable && parameter.value.is_none(),
            "{name}"
        );
    }
    assert!(
        result
            .parameter("joint1.motor_viscous")
            .unwrap()
            .identifiable
    );
    let mut findings = result.warnings.iter();
    let finding = findings
        .find(|finding| finding.code == "not-identifiable")
        .unwrap();
    assert!(finding.parameters.iter().any(|name| name == NAMES[0].0));
}

#[test]
fn simulated_loops_of_a_validation_follow_the_temperature_of_the_log() {
    let log = log(["[25.0, 28.0]", "[45.0, 42.0]"]);
    let session = session(&log, &[]).unwrap();
    let mut found = session.identify(&mut Unheard).unwrap().identification;
    let error = |found: &Identification| {
        let validated = session
            .validate(&Parameters::from(found.clone()), &mut Unheard)
            .unwrap();
        let set = &validated.validation.runs[0].sets[0];
        let errors = serde_json::to_value(&set.e_rms).unwrap();
        let simulated = errors["phi_rad"]["joint1"].as_f64().unwrap();
        let predicted = serde_json::to_value(&set.torque_residual_nm).unwrap();
        (simulated, predicted["joint1"].as_f64().unwrap())
    };
    let with = error(&found);
    for parameter in &mut found.results[0].parameters {
        if parameter.name.ends_with("_per_k") {
            parameter.value = Some(0.0);
        }
    }
    let without = error(&found);
    assert!(with.0 < 0.8 * without.0, "{with:?} {without:?}");
    assert!(with.1 < 0.8 * without.1, "{with:?} {without:?}");
}

#[test]
fn mistakes_are_named() {
    let mut messages = messages("covariates");
    for set in [
        "robot.joint.0.friction_covariates.temperature=[\"motor_stribeck\"]",
        "simulate.temperature_start_c=[20.0]",
        "log.temperature_c=[\"a\", \"b\", \"c\"]",
        "simulate.cycles=[0.0, nan]",
    ] {
        messages.note(set, &session(&[], &[set]).err().unwrap());
    }
    for keys in [
        "temperature = [\"motor_viscous\"]",
        "reference_h = 3.0, temperature = [\"motor_viscous\"], reference_c = 3.0",
        "",
    ] {
        let found = with_truth(([keys, TEMPERATURES[1]], ""), &[], &[]);
        let name = if keys.is_empty() { "no keys" } else { keys };
        messages.note(name, &found.err().unwrap());
    }
    let age = [
        "age = [\"motor_viscous\"], reference_d = 3.0",
        TEMPERATURES[1],
    ];
    let found = with_truth((age, ""), &[], &["log.temperature_c=\"warm\""]).unwrap();
    let error = found.identify(&mut Unheard).err().unwrap();
    messages.note("no age", &error.to_string());
    messages.compare();
}

/// The friction of the first motor depends on the temperature and on the hours of operation, which one
/// column gives for both joints.
const WORN: OfJoints = [
    "temperature = [\"motor_viscous\"], reference_c = 35.0, operation = [\"motor_coulomb\"], reference_h = 250.0",
    "operation = [\"motor_viscous\"], reference_h = 250.0",
];

const COLUMNS: [&str; 2] = ["log.temperature_c=\"warm\"", "log.operation_h=\"hours\""];

const WEAR: &str = "\n\"joint1.motor_viscous_per_k\" = -0.12\n\"joint1.motor_coulomb_per_h\" = 0.0008\n\
                    \"joint2.motor_viscous_per_h\" = 0.0001\n";

#[test]
fn logs_at_several_temperatures_and_hours_tell_both_effects() {
    let log = |temperatures: [f64; 2], hours: f64| {
        let [start, end] = temperatures;
        let keys = [
            COLUMNS[0].to_owned(),
            COLUMNS[1].to_owned(),
            format!("simulate.temperature_start_c=[{start}, {start}]"),
            format!("simulate.temperature_end_c=[{end}, {end}]"),
            format!("simulate.operation_h=[{hours}, {}]", hours + 0.01),
            format!("simulate.seed={hours}"),
            "simulate.duration_s=8".to_owned(),
        ];
        let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
        recorded(&with_truth((WORN, WEAR), &[], &keys).unwrap())
    };
    let logs = [log([25.0, 45.0], 0.0), log([40.0, 20.0], 500.0)];
    let more = [
        COLUMNS[0],
        COLUMNS[1],
        "log.file=[\"0.csv\", \"1.csv\"]",
        "identify.estimator=[\"prediction-error\", \"least-squares\"]",
    ];
    let session = with_truth((WORN, WEAR), &logs, &more).unwrap();
    let found = session.identify(&mut Unheard).unwrap().identification;
    for result in &found.results {
        for (name, truth, unit) in [
            ("joint1.motor_viscous_per_k", -0.12, "N·m·s/rad/K"),
            ("joint1.motor_coulomb_per_h", 0.0008, "N·m/h"),
            ("joint2.motor_viscous_per_h", 0.0001, "N·m·s/rad/h"),
        ] {
            let parameter = result.parameter(name).unwrap();
            let (value, error) = (parameter.value.unwrap(), parameter.standard_error.unwrap());
            let method = &result.estimator;
            assert!(
                (value - truth).abs() < 3.0 * error,
                "{method:?} {name} {value} {error}"
            );
            assert!(error < 0.5 * truth.abs(), "{method:?} {name} {error}");
            assert_eq!(parameter.unit, unit);
        }
    }
}

#[test]
fn time_and_temperature_that_rise_together_are_both_named() {
    let log = log(["[25.0, 28.0]", "[45.0, 42.0]"]);
    let both = [
        "temperature = [\"motor_viscous\"], reference_c = 35.0, time = [\"motor_viscous\"], reference_s = 15.0",
        TEMPERATURES[1],
    ];
    let found = with_truth((both, ""), std::slice::from_ref(&log), &[]).unwrap();
    let found = found.identify(&mut Unheard).unwrap().identification;
    let mut notes =
        (found.findings.iter()).filter(|finding| finding.code == "covariates-change-together");
    let note = notes.next().unwrap();
    contains(
        &note.text,
        &["temperature (\"warm1\") and time change together"],
    );
    assert!(notes.next().is_none());
    let result = &found.results[0];
    for name in ["joint1.motor_viscous_per_k", "joint1.motor_viscous_per_s"] {
        assert!(!result.parameter(name).unwrap().identifiable, "{name}");
    }
    // Alone the time represents the temperature, which rises by 20 K in 30 s.
    let alone = [
        "time = [\"motor_viscous\", \"motor_coulomb\"], reference_s = 15.0",
        TEMPERATURES[1],
    ];
    let columns = "log.temperature_c=[\"warm2\"]";
    let found = with_truth((alone, ""), &[log], &[columns]).unwrap();
    let found = found.identify(&mut Unheard).unwrap().identification;
    let parameter = found.results[0].parameter("joint1.motor_viscous_per_s");
    let (parameter, truth) = (parameter.unwrap(), -0.12 * 20.0 / 30.0);
    assert!(
        (parameter.value.unwrap() - truth).abs() < 3.0 * parameter.standard_error.unwrap(),
        "{parameter:?}"
    );
}
