//! Laws by cross-validation on logs that do not separate two laws.

use std::fmt::Write;

use sprung_method::estimate::Identification;
use sprung_method::unknowns::UnknownResult;
use sprung_model::Model;
use sprung_robot::{self as description, Experiment, no_files};
use sprung_testing::contains;

use crate::logs::identify_log;

/// A wheel that turns in one direction.
const WHEEL: &str = r#"
format = 1
[robot]
name = "wheel"
dh_modified = [{}]
[[robot.joint]]
name = "wheel"
transmission = "rigid"
motor_friction = LAWS
[log]
file = "run.csv"
time_s = "t"
motor_position_rad = ["phi"]
motor_torque_nm = ["tau"]
[identify]
estimator = "least-squares"
position_cutoff_hz = 10.0
laws = "declared"
"#;

/// Inertia, kg·m², viscous friction, N·m·s/rad, and Coulomb friction, N·m.
const INERTIA: f64 = 0.5;
const VISCOUS: f64 = 2.0;
const COULOMB: f64 = 1.0;

/// Mean speed, rad/s. A position of more than a turn seems to be in degrees.
const SPEED: f64 = 0.25;

/// Returns a log of 10 s at the mean speed and at most twice a part of it more or less.
fn log(part: f64) -> String {
    let mut text = "t,phi,tau\n".to_owned();
    let [slow, fast] = [4.0_f64, 11.0];
    for k in 0..10_000 {
        let t = f64::from(k) * 1e-3;
        let swing = (slow * t).cos() / slow + (fast * t).cos() / fast;
        let position = SPEED * (t - part * swing);
        let velocity = SPEED * (1.0 + part * ((slow * t).sin() + (fast * t).sin()));
        let acceleration = SPEED * part * (slow * (slow * t).cos() + fast * (fast * t).cos());
        // Any deterministic signal with a flat spectrum serves as noise.
        let noise = 5e-3 * (t * t * 1e4).sin();
        let torque = INERTIA * acceleration + VISCOUS * velocity + COULOMB + noise;
        writeln!(text, "{t:.3},{position:.9},{torque:.6}").unwrap();
    }
    text
}

fn identified(laws: &str, log: &str) -> Identification {
    identified_with(laws, log, "declared")
}

/// - `further`: value of the key `laws`.
fn identified_with(laws: &str, log: &str, further: &str) -> Identification {
    of_file(
        &WHEEL.replace("LAWS", laws).replace("declared", further),
        log,
    )
}

fn of_file(text: &str, log: &str) -> Identification {
    let experiment: Experiment =
        description::read("experiment.toml", text, &[], &mut no_files).unwrap();
    let model = Model::new(&experiment).unwrap();
    identify_log(&experiment, &model, log.as_bytes())
        .unwrap()
        .identification
}

#[test]
fn rigid_joints_are_refined_by_default_only_if_their_equations_explain_the_torques() {
    let by_default = WHEEL.replace("estimator = \"least-squares\"\n", "");
    for (laws, estimator) in [
        (r#"["viscous", "coulomb"]"#, "prediction-error"),
        (r#"["viscous"]"#, "least-squares"),
    ] {
        let found = of_file(&by_default.replace("LAWS", laws), &log(0.3));
        let used: Vec<&str> = (found.results.iter())
            .map(|one| one.estimator.as_str())
            .collect();
        assert_eq!(used, [estimator], "{laws}");
    }
}

fn laws(identification: &Identification) -> Vec<&UnknownResult> {
    let unknowns = identification.unknowns.iter();
    unknowns.filter(|unknown| unknown.law.is_some()).collect()
}

fn missing(identification: &Identification) -> &str {
    let mut findings = identification.findings.iter();
    let finding = findings.find(|finding| finding.code == "laws-missing");
    &finding.unwrap().text
}

#[test]
fn viscous_and_quadratic_friction_at_nearly_constant_speed_are_named_together() {
    let found = identified(r#"["coulomb"]"#, &log(0.02));
    let competing = |identification: &Identification| -> Vec<String> {
        let first = laws(identification)[0];
        assert_eq!(first.law.as_ref().unwrap().law, "viscous");
        (first.competing.iter())
            .map(|rival| rival.id.clone())
            .collect()
    };
    let quadratic = "law wheel.motor_friction.quadratic";
    let others = competing(&found);
    assert!(others.iter().any(|other| other == quadratic), "{others:?}");
    let text = missing(&found);
    contains(text, &["motor_friction \"viscous\""]);
    assert!(text.contains(quadratic), "{text}");
    // At speeds between 0.05 and 0.45 rad/s the log separates them.
    let others = competing(&identified(r#"["coulomb"]"#, &log(0.4)));
    assert!(!others.iter().any(|other| other == quadratic), "{others:?}");
}

#[test]
fn constant_torque_and_coulomb_friction_in_one_direction_are_named_together() {
    let found = identified(r#"["viscous"]"#, &log(0.4));
    let first = laws(&found)[0];
    let mut both: Vec<&str> = first
        .competing
        .iter()
        .map(|rival| rival.id.as_str())
        .collect();
    both.push(&first.id);
    for law in ["coulomb", "offset"] {
        let id = format!("law wheel.motor_friction.{law}");
        assert!(both.contains(&id.as_str()), "{both:?}");
    }
}

/// Returns a log of 20 s with reversals of large and small motion.
///
/// - `friction`: Coulomb friction by velocity and travel since the last call.
fn reversing(mut friction: impl FnMut(f64, f64) -> f64) -> String {
    let mut text = "t,phi,tau\n".to_owned();
    let waves = [(0.3, 2.0, 0.0), (0.1, 5.3, 1.0), (0.05, 11.7, 2.0)];
    let sum = |of: &dyn Fn(f64, f64, f64) -> f64| -> f64 {
        waves
            .iter()
            .map(|&(size, rate, phase)| of(size, rate, phase))
            .sum()
    };
    let mut before = None;
    for k in 0..20_000 {
        let t = f64::from(k) * 1e-3;
        let position = sum(&|size, rate, phase| size * (rate * t + phase).sin());
        let velocity = sum(&|size, rate, phase| size * rate * (rate * t + phase).cos());
        let acceleration = sum(&|size, rate, phase| -size * rate * rate * (rate * t + phase).sin());
        let travel = position - before.unwrap_or(position);
        before = Some(position);
        let noise = 5e-3 * (t * t * 1e4).sin();
        let torque =
            INERTIA * acceleration + VISCOUS * velocity + friction(velocity, travel) + noise;
        writeln!(text, "{t:.3},{position:.9},{torque:.6}").unwrap();
    }
    text
}

/// Returns the names of the laws that are used beyond those of the description.
fn used_laws(found: &Identification) -> Vec<&str> {
    let laws = found.unknowns.iter().filter_map(UnknownResult::used_law);
    laws.map(|law| law.law.as_str()).collect()
}

fn inertia(found: &Identification) -> f64 {
    let parameters = &found.results[0].parameters;
    let inertia = parameters.iter().find(|p| p.unit == "kg·m²");
    inertia.and_then(|p| p.value).unwrap()
}

/// Friction of Canudas de Wit, Olsson, Åström and Lischinsky, IEEE Transactions on Automatic Control 1995 (LuGre): a bristle of
/// this width bends before it slides. It is no sum of elements.
#[test]
fn presliding_friction_of_bristles_is_found_and_keeps_the_inertia_true() {
    let laws = r#"["viscous", "coulomb", "offset"]"#;
    let mut bend = 0.0;
    let width = 0.01;
    let log = reversing(|_, travel| {
        // The log's samples are a tenth of the width apart at most, so a few steps suffice.
        for _ in 0..100 {
            let step: f64 = travel / 100.0;
            bend += step - step.abs() * bend / width;
        }
        COULOMB * bend / width
    });
    let found = identified(laws, &log);
    assert!(used_laws(&found).is_empty());
    let declared = inertia(&found);
    let found = identified_with(laws, &log, "auto");
    assert_eq!(used_laws(&found), ["presliding"]);
    let with = inertia(&found);
    assert!((with / INERTIA - 1.0).abs() < 0.02, "{with}");
    assert!((declared / INERTIA - 1.0).abs() > 0.05, "{declared}");
    let sliding: f64 = (found.results[0].parameters.iter())
        .filter(|p| p.name.contains("presliding") || p.name.ends_with("motor_coulomb"))
        .filter_map(|p| p.value)
        .sum();
    assert!((sliding / COULOMB - 1.0).abs() < 0.05, "{sliding}");
}

#[test]
fn friction_that_jumps_is_no_presliding() {
    let laws = r#"["viscous", "coulomb", "offset"]"#;
    let log = reversing(|velocity, _| COULOMB * (100.0 * velocity).tanh());
    assert!(used_laws(&identified_with(laws, &log, "auto")).is_empty());
}
