//! Presliding friction, hysteresis and play of a flexible joint, from a simulation that shares no code with the models.

use std::f64::consts::TAU;
use std::fmt::Write;

use sprung_method::estimate::Identification;
use sprung_model::Model;
use sprung_robot::{self as description, Experiment, no_files};
use sprung_testing::contains;

use crate::logs::identify_log;

const JOINT: &str = r#"
format = 1
[robot]
name = "flexible joint"
dh_modified = [{}]
gravity_m_per_s2 = [9.81, 0.0, 0.0]
[[robot.joint]]
name = "hip"
transmission = "flexible"
motor_friction = ["viscous", "coulomb", "offset"]
link_friction = ["viscous"]
[log]
file = "run.csv"
time_s = "t"
motor_position_rad = ["phi"]
link_position_rad = ["q"]
motor_torque_nm = ["tau"]
[identify]
estimator = "least-squares"
laws = "LAWS"
"#;

/// Rotor, kg·m², link, kg·m², stiffness, N·m/rad, viscous friction of motor and link, N·m·s/rad, Coulomb friction, N·m.
const ROTOR: f64 = 1.0;
const LINK: f64 = 2.0;
const STIFFNESS: f64 = 1e4;
const VISCOUS: [f64; 2] = [6.0, 1.0];
const COULOMB: f64 = 7.0;

/// Torque of the link's weight when it is horizontal, N·m.
const WEIGHT: f64 = 80.0;

/// Period of the controller and of the log, s, and steps of the simulation in it.
const PERIOD: f64 = 1e-3;
const STEPS: usize = 50;

/// Friction of the motor until it slides.
#[derive(Clone, Copy)]
enum Sliding {
    /// It jumps at once.
    Jump,
    /// A bristle of this width, rad, bends first (`LuGre`).
    Bristle(f64),
}

/// Torque of the spring.
#[derive(Clone, Copy)]
enum Spring {
    /// It is proportional to the deflection.
    Linear,
    /// Two elements of 2 N·m slide beside it, at these deflections, rad.
    Slips([f64; 2]),
    /// It begins at the end of a play of this half width about this deflection, rad.
    Play(f64, f64),
}

impl Spring {
    /// - `slips`: torque of the elements that slide, before and after the step; `travel`: of the deflection in the step.
    fn torque(self, deflection: f64, slips: &mut [f64; 2], travel: f64) -> f64 {
        match self {
            Self::Linear => STIFFNESS * deflection,
            Self::Slips(widths) => {
                for (slip, width) in slips.iter_mut().zip(widths) {
                    *slip = (*slip + 2.0 * travel / width).clamp(-2.0, 2.0);
                }
                STIFFNESS * deflection + slips[0] + slips[1]
            }
            Self::Play(half, centre) => {
                let from_centre = deflection - centre;
                STIFFNESS * from_centre.signum() * (from_centre.abs() - half).max(0.0)
            }
        }
    }
}

/// Returns a log of 15 s under a controller of the motor position, whose torque is held for a period.
fn log(sliding: Sliding, of_spring: Spring) -> String {
    let mut text = "t,phi,q,tau\n".to_owned();
    let sines = [
        (0.25, 0.13, 0.0),
        (0.12, 0.37, 1.0),
        (0.07, 0.9, 2.0),
        (0.03, 2.1, 3.0),
    ];
    let (mut motor, mut link, mut bend) = ([0.0_f64; 2], [0.0_f64; 2], 0.0_f64);
    let mut slips = [0.0; 2];
    for k in 0..15_000 {
        let time = f64::from(k) * PERIOD;
        let fade = (time / 1.5).min(1.0);
        let sum = |phase: f64| -> f64 {
            let of = |(a, f, p): &(f64, f64, f64)| a * (TAU * f * time + p + phase).sin();
            fade * fade * sines.iter().map(of).sum::<f64>()
        };
        let torque = 3000.0 * (sum(0.0) - motor[0]) - 90.0 * motor[1];
        // Any deterministic signal with a flat spectrum serves as noise.
        let noise = |a: f64| 2e-5 * (a * time * time * 1e4).sin();
        writeln!(
            text,
            "{time:.3},{:.9},{:.9},{torque:.6}",
            motor[0] + noise(1.0),
            link[0] + noise(1.3)
        )
        .unwrap();
        let step = PERIOD / STEPS as f64;
        for _ in 0..STEPS {
            let friction = match sliding {
                Sliding::Jump => COULOMB * (100.0 * motor[1]).tanh(),
                Sliding::Bristle(width) => {
                    bend += step * (motor[1] - motor[1].abs() * bend / width);
                    COULOMB * bend / width
                }
            };
            let travel = step * (motor[1] - link[1]);
            let spring = of_spring.torque(motor[0] - link[0], &mut slips, travel);
            motor[1] += step * (torque - spring - VISCOUS[0] * motor[1] - friction) / ROTOR;
            let weight = WEIGHT * link[0].sin();
            link[1] += step * (spring - weight - VISCOUS[1] * link[1]) / LINK;
            motor[0] += step * motor[1];
            link[0] += step * link[1];
        }
    }
    text
}

fn identified(laws: &str, log: &str) -> Identification {
    identified_by(&JOINT.replace("LAWS", laws), log)
}

fn identified_by(text: &str, log: &str) -> Identification {
    let experiment: Experiment =
        description::read("experiment.toml", text, &[], &mut no_files).unwrap();
    let model = Model::new(&experiment).unwrap();
    identify_log(&experiment, &model, log.as_bytes())
        .unwrap()
        .identification
}

/// Returns the error of a value relative to the true one.
fn error(of: &Identification, name: &str, truth: f64) -> f64 {
    let parameter = (of.results[0].parameters.iter()).find(|one| one.name == name);
    parameter.and_then(|one| one.value).unwrap() / truth - 1.0
}

fn used(of: &Identification) -> Vec<&str> {
    (of.unknowns.iter())
        .filter_map(|one| Some(one.used_law()?.law.as_str()))
        .collect()
}

#[test]
fn a_flexible_joint_with_bristles_gets_presliding_friction_and_its_true_rotor() {
    let log = log(Sliding::Bristle(1e-3), Spring::Linear);
    let declared = identified("declared", &log);
    let wrong = error(&declared, "hip.rotor_inertia", ROTOR);
    assert!(wrong.abs() > 0.05, "{wrong}");
    let found = identified("auto", &log);
    assert_eq!(used(&found), ["presliding"]);
    let rotor = error(&found, "hip.rotor_inertia", ROTOR);
    let stiffness = error(&found, "hip.stiffness", STIFFNESS);
    assert!(rotor.abs() < 0.02, "{rotor}");
    // Tables show the six elements in one row, with their sum.
    let shown = found.results[0].shown_parameters();
    let rows = shown.iter().filter(|one| one.name.contains("presliding"));
    let [row] = rows.collect::<Vec<_>>()[..] else {
        panic!("one row of presliding friction")
    };
    let coulomb = shown.iter().find(|one| one.name == "hip.motor_coulomb");
    let sliding = row.value.unwrap() + coulomb.and_then(|one| one.value).unwrap();
    assert!((sliding / COULOMB - 1.0).abs() < 0.05, "{sliding}");
    assert!(stiffness.abs() < 0.005, "{stiffness}");
}

#[test]
fn a_flexible_joint_whose_friction_jumps_gets_none() {
    let found = identified("auto", &log(Sliding::Jump, Spring::Linear));
    assert!(used(&found).is_empty(), "{:?}", used(&found));
}

#[test]
fn hysteresis_of_a_spring_is_found_and_leaves_the_rotor_true() {
    let log = log(Sliding::Jump, Spring::Slips([1e-4, 3e-4]));
    let declared = identified("declared", &log);
    let wrong = error(&declared, "hip.rotor_inertia", ROTOR);
    assert!(wrong.abs() > 0.15, "{wrong}");
    let found = identified("auto", &log);
    assert_eq!(used(&found), ["hysteresis"]);
    let rotor = error(&found, "hip.rotor_inertia", ROTOR);
    let stiffness = error(&found, "hip.stiffness", STIFFNESS);
    assert!(rotor.abs() < 0.06, "{rotor}");
    assert!(stiffness.abs() < 0.02, "{stiffness}");
    let shown = found.results[0].shown_parameters();
    let row = shown.iter().find(|one| one.name == "hip.spring_hysteresis");
    let sum = row.and_then(|one| one.value).unwrap();
    assert!((sum / 4.0 - 1.0).abs() < 0.15, "{sum}");
}

#[test]
fn play_of_a_spring_is_found_with_its_width_and_leaves_the_stiffness_true() {
    let log = log(Sliding::Jump, Spring::Play(2e-4, 1e-4));
    let declared = identified("declared", &log);
    let wrong = error(&declared, "hip.stiffness", STIFFNESS);
    assert!(wrong.abs() > 0.03, "{wrong}");
    let found = identified("auto", &log);
    assert_eq!(used(&found), ["play"]);
    let play = found.results[0].play_half_width.get("hip").unwrap();
    let stiffness = error(&found, "hip.stiffness", STIFFNESS);
    assert!((play / 2e-4 - 1.0).abs() < 0.05, "{play}");
    assert!(stiffness.abs() < 0.02, "{stiffness}");
}

#[test]
fn a_declared_play_that_the_log_does_not_show_is_named_with_a_bound() {
    let with_play = "transmission = \"flexible\"\nspring = [\"linear\", \"play\"]";
    let text = JOINT.replace("LAWS", "declared");
    let text = text.replace("transmission = \"flexible\"", with_play);
    let named = |spring: Spring| {
        let found = identified_by(&text, &log(Sliding::Jump, spring));
        let named = (found.findings.iter()).find(|one| one.code == "play-not-shown");
        named.map(|one| one.text.clone())
    };
    assert_eq!(named(Spring::Play(2e-4, 1e-4)), None);
    let message = named(Spring::Linear).unwrap();
    contains(&message, &["or more would explain it clearly worse"]);
}
