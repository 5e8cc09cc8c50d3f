//! Friction that changes with the temperature.

use std::collections::BTreeMap;
use std::io::{Cursor, Error, ErrorKind, Result as IoResult};
use std::path::Path;

use sprung::demo;
use sprung::estimate::Identification;
use sprung::log::Input;
use sprung::progress::Unheard;
use sprung::session::{Parameters, Session};

/// Changes of the friction of both motors, per kelvin.
const CHANGES: &str = "\n\"joint1.motor_viscous_per_k\" = -0.12\n\"joint1.motor_coulomb_per_k\" = -0.015\n\
                       \"joint2.motor_viscous_per_k\" = -0.002\n";

const NAMES: [(&str, f64); 3] = [
    ("joint1.motor_viscous_per_k", -0.12),
    ("joint1.motor_coulomb_per_k", -0.015),
    ("joint2.motor_viscous_per_k", -0.002),
];

/// Returns the demo's experiment with temperatures.
fn experiment() -> String {
    let covariates = |names: &str| {
        format!(
            "friction_covariates = {{ temperature = [{names}], reference_c = 35.0 }}\ntorque_constant_nm_per_a"
        )
    };
    let mut text = demo::EXPERIMENT.to_owned();
    let first = covariates("\"motor_viscous\", \"motor_coulomb\"");
    text = text.replacen("torque_constant_nm_per_a", &first, 1);
    let at = text.rfind("torque_constant_nm_per_a").unwrap();
    let second = covariates("\"motor_viscous\"");
    text.replace_range(at..at + "torque_constant_nm_per_a".len(), &second);
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
    let truth = [demo::TRUTH, CHANGES].concat();
    let mut files = BTreeMap::from([("truth.toml", truth.into_bytes())]);
    files.insert("identification.csv", log.to_vec());
    files.insert("validation.csv", log.to_vec());
    let open = move |path: &Path| -> IoResult<Box<dyn Input>> {
        match path.to_str().and_then(|name| files.get(name)) {
            Some(bytes) => Ok(Box::new(Cursor::new(bytes.clone()))),
            None => Err(Error::from(ErrorKind::NotFound)),
        }
    };
    let usual = [
        "identify.estimator=[\"least-squares\"]",
        "simulate.duration_s=30.0",
    ];
    let overrides: Vec<String> = usual
        .iter()
        .chain(more)
        .map(|text| (*text).to_owned())
        .collect();
    Session::read("experiment.toml", &experiment(), &overrides, open)
        .map_err(|error| error.to_string())
}

fn log(temperatures: [&str; 2]) -> Vec<u8> {
    let keys = [
        format!("simulate.temperature_start_c={}", temperatures[0]),
        format!("simulate.temperature_end_c={}", temperatures[1]),
    ];
    let twin = session(&[], &[&keys[0], &keys[1]]).unwrap();
    let mut log = Vec::new();
    let recording = twin.twin(None, None).unwrap();
    recording.write(&mut log, &mut Unheard).unwrap();
    log
}

fn identified(log: &[u8]) -> Identification {
    let found = session(log, &[]).unwrap().identify(&mut Unheard).unwrap();
    found.identification
}

/// Returns the columns of temperatures that hardly change by the findings.
fn hardly_change(found: &Identification) -> Vec<&str> {
    (found.findings.iter())
        .filter(|finding| finding.code == "temperature-hardly-changes")
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
        let own = result.parameter(name).unwrap();
        let (value, error) = (own.value.unwrap(), own.standard_error.unwrap());
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
        let own = result.parameter(name).unwrap();
        assert!(!own.identifiable && own.value.is_none(), "{name}");
    }
    assert!(
        result
            .parameter("joint1.motor_viscous")
            .unwrap()
            .identifiable
    );
    let mut findings = result.warnings.iter();
    let finding = findings.find(|own| own.code == "not-identifiable").unwrap();
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
    let refused = |more: &[&str]| session(&[], more).err().unwrap();
    let text = refused(&["identify.estimator=[\"prediction-error\"]"]);
    assert!(text.contains("knows no temperatures"), "{text}");
    let text = refused(&["robot.joint.0.friction_covariates.temperature=[\"motor_stribeck\"]"]);
    assert!(
        text.contains("motor_stribeck") && text.contains("motor_coulomb"),
        "{text}"
    );
    let text = refused(&["simulate.temperature_start_c=[20.0]"]);
    assert!(text.contains("temperature_start_c has 1 numbers"), "{text}");
}
