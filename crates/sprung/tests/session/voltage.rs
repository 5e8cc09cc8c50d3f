//! Voltage drives: the back-EMF is no friction.

use std::collections::BTreeMap;

use sprung::session::{Parameters, Session};
use sprung_base::demo;
use sprung_base::progress::Unheard;
use sprung_testing::{each, largest_of_normals};

use crate::support::{messages, opener, recorded};

/// Torque constants, N·m/A, equal to the back-EMF in V·s/rad, and resistances, ohm.
const CONSTANTS: [f64; 2] = [5.0, 1.0];
const RESISTANCES: [f64; 2] = [20.0, 5.0];

/// Returns the demo's experiment with voltages in the log.
///
/// - `drive`: keys of each joint's drive, by torque constant and resistance.
fn experiment(drive: impl Fn(f64, f64) -> String) -> String {
    let [first, second] = [0, 1].map(|i| {
        let keys = drive(CONSTANTS[i], RESISTANCES[i]);
        format!("torque_constant_nm_per_a = {}\n{keys}", CONSTANTS[i])
    });
    demo::EXPERIMENT
        .replace("amplifier_gain_a_per_v = 0.5\n", "")
        .replace("torque_constant_nm_per_a = 0.119", &first)
        .replace("torque_constant_nm_per_a = 0.0234", &second)
        .replace(
            "motor_torque_nm    = [\"tau1_nm\", \"tau2_nm\"]",
            "drive_voltage_v = [\"u1_v\", \"u2_v\"]",
        )
}

fn voltage_drive(constant: f64, resistance: f64) -> String {
    format!("winding_resistance_ohm = {resistance}\nback_emf_vs_per_rad = {constant}")
}

/// An amplifier with the same torque per volt and without back-EMF.
fn current_drive(_: f64, resistance: f64) -> String {
    format!("amplifier_gain_a_per_v = {}", 1.0 / resistance)
}

fn session(text: &str, log: &[u8], estimators: &str) -> Result<Session, String> {
    let mut files = BTreeMap::from([("truth.toml", demo::TRUTH.as_bytes().to_vec())]);
    files.insert("identification.csv", log.to_vec());
    files.insert("validation.csv", log.to_vec());
    let open = opener(files);
    let overrides = [
        "simulate.duration_s=3.0".to_owned(),
        format!("identify.estimator={estimators}"),
    ];
    Session::read("experiment.toml", text, &overrides, open).map_err(|error| error.to_string())
}

#[test]
fn the_back_emf_is_not_counted_as_viscous_friction() {
    let with = experiment(voltage_drive);
    let twin = session(&with, &[], "[\"least-squares\"]").unwrap();
    let log = recorded(&twin);
    let truth = twin.twin(None, None).unwrap().truth();
    for joint in 0..2 {
        let name = format!("joint{}.back_emf", joint + 1);
        let expected = CONSTANTS[joint].powi(2) / RESISTANCES[joint];
        assert!((truth[&name] - expected).abs() < 1e-12, "{name}");
    }

    let both = "[\"prediction-error\", \"least-squares\"]";
    let known = session(&with, &log, both).unwrap();
    let found = known.identify(&mut Unheard).unwrap().identification;
    let unknown = session(&experiment(current_drive), &log, both).unwrap();
    let without = unknown.identify(&mut Unheard).unwrap().identification;
    for (result, other) in found.results.iter().zip(&without.results) {
        let (values, other) = (result.values(), other.values());
        for name in ["joint1.motor_viscous", "joint2.motor_viscous"] {
            let off = values[name] - truth[name];
            let error = result.parameter(name).unwrap().standard_error.unwrap();
            assert!(
                off.abs() < largest_of_normals(4) * error,
                "{name}: {off} ± {error}"
            );
        }
        for joint in ["joint1", "joint2"] {
            let viscous = format!("{joint}.motor_viscous");
            let back_emf = values[&format!("{joint}.back_emf")];
            let shift = other[&viscous] - values[&viscous];
            assert!((shift / back_emf - 1.0).abs() < 1e-3, "{joint}: {shift}");
        }
    }
    let estimate = found.results[0]
        .parameters
        .iter()
        .find(|parameter| parameter.name == "joint1.back_emf");
    assert!(estimate.unwrap().fixed);

    // The simulated loops of both models are the same.
    let simulated = |session: &Session, found| {
        let parameters = Parameters::from(found);
        let validated = session.validate(&parameters, &mut Unheard).unwrap();
        let errors = serde_json::to_value(&validated.validation.runs[0].sets[0].e_rms).unwrap();
        errors["phi_rad"]["joint2"].as_f64().unwrap()
    };
    let (with, without) = (simulated(&known, found), simulated(&unknown, without));
    assert!((with / without - 1.0).abs() < 0.01, "{with} {without}");
}

#[test]
fn constants_that_do_not_fit_together_are_refused() {
    let mut messages = messages("voltage_drives");
    let with_gain = |constant, resistance| {
        let both = voltage_drive(constant, resistance);
        format!("{both}\namplifier_gain_a_per_v = 0.5")
    };
    #[rustfmt::skip]
    let rows = [
        ("no resistance", experiment(|constant, _| format!("back_emf_vs_per_rad = {constant}"))),
        ("no back-EMF", experiment(|_, resistance| format!("winding_resistance_ohm = {resistance}"))),
        ("a voltage and a current amplifier", experiment(with_gain)),
        ("opposite signs", experiment(|constant, resistance| voltage_drive(-constant, resistance))),
        ("a resistance of zero", experiment(|constant, _| voltage_drive(constant, 0.0))),
        ("currents in the log", experiment(voltage_drive).replace("drive_voltage_v", "motor_current_a")),
    ];
    each(rows, |(name, text)| {
        let refused = session(&text, &[], "[\"least-squares\"]");
        messages.note(name, &refused.err().unwrap());
    });
    messages.compare();
}
