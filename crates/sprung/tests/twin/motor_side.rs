//! Springs of the 2-DOF arm from its motors alone.
//!
//! `cargo test --release -p sprung --test twin -- motor_side --nocapture` prints the figures of
//! docs/how-to/no-link-encoder.md.

use std::collections::BTreeMap;
use std::fmt::Write;

use rayon::prelude::*;
use sprung::description::{self, Experiment, no_files};
use sprung::estimate::{Identification, SpringFromMotor, identify};
use sprung::finding::Severity;
use sprung::log::Channels;
use sprung::model::{Model, Theta};
use sprung::progress::Unheard;
use sprung::simulate::{TwinSetup, record};

use crate::in_memory::with_source;

const FLEXIBLE: &str = r#"
[[robot.joint]]
name = "joint1"
[[robot.joint]]
name = "joint2"
"#;

const RIGID: &str = r#"
[[robot.joint]]
name = "joint1"
transmission = "rigid"
[[robot.joint]]
name = "joint2"
transmission = "rigid"
"#;

const SETTINGS: &str = r#"
[log]
time_s = "t"
motor_position_rad = ["phi1", "phi2"]
motor_torque_nm = ["tau1", "tau2"]
link_position_rad = ["q1", "q2"]
[identify]
estimator = "least-squares"
springs_from_motor = true
[controller]
kind = "pd"
kp_nm_per_rad = [50.0, 5.0]
kd_nms_per_rad = [0.5, 0.05]
[simulate]
period_s = 0.001
motor_encoder_counts_per_turn = [16384, 16384]
torque_noise_nm = [0.02, 0.005]
"#;

const TRUTH: &str = r#"
"link1.inertia_total" = 0.207184
"link2.coupling" = 0.017580
"link2.inertia" = 0.013163
"joint1.rotor_inertia" = 0.216776
"joint2.rotor_inertia" = 0.006842
"joint1.link_viscous" = 0.037675
"joint2.link_viscous" = 0.002959
"joint1.motor_viscous" = 0.2
"joint2.motor_viscous" = 0.02
"joint1.stiffness" = 9.358730
"joint2.stiffness" = 4.212811
"joint1.link_coulomb" = 0.015771
"joint2.link_coulomb" = 0.005018
"joint1.motor_coulomb" = 0.136
"joint2.motor_coulomb" = 0.01625
"#;

const STIFFNESS: [f64; 2] = [9.358_730, 4.212_811];
const ROTOR: [f64; 2] = [0.216_776, 0.006_842];

/// Multiples of 0.1 Hz with phases that look random.
fn multisine(highest_hz: f64, amplitude_deg: f64, seed: u64) -> String {
    let mut text = "[controller.reference]\nsines = [\n".to_owned();
    for joint in ["joint1", "joint2"] {
        for k in 1..=(10.0 * highest_hz) as u64 {
            let hz = 0.1 * k as f64;
            let phase = (137.507_764 * (k * (k + 1 + 2 * seed)) as f64
                + 61.8 * joint.len() as f64
                + if joint == "joint2" {
                    97.0 * k as f64
                } else {
                    0.0
                })
                % 360.0;
            let _ = writeln!(
                text,
                "{{ joint = \"{joint}\", amplitude_deg = {amplitude_deg}, frequency_hz = {hz}, phase_deg = {phase} }},"
            );
        }
    }
    text + "]\n"
}

fn experiment(joints: &str, settings: &str, reference: &str) -> (Experiment, Model) {
    let text =
        format!("format = 1\n[robot]\nkinematics = \"planar-2r\"\n{joints}{settings}{reference}");
    let experiment = description::read("experiment.toml", &text, &[], &mut no_files).unwrap();
    let model = Model::new(&experiment).unwrap();
    (experiment, model)
}

/// Identifies a log of the motors.
fn identification(reference: &str, truth: &BTreeMap<String, f64>, seed: u64) -> Identification {
    let of_twin = SETTINGS.replace("springs_from_motor = true\n", "");
    let (twin, model) = experiment(FLEXIBLE, &of_twin, reference);
    let mut settings = twin.simulate.clone().unwrap();
    (settings.seed, settings.duration_s) = (seed, 30.0);
    let theta: Theta = model.theta(truth).unwrap();
    let setup = TwinSetup {
        model: &model,
        theta: &theta,
        controller: twin.controller.as_ref().unwrap(),
        settings: &settings,
    };
    let channels = Channels::new(&twin.robot, twin.log.as_ref().unwrap()).unwrap();
    let mut log = Vec::new();
    record(&setup, &channels, &mut log, &mut Unheard).unwrap();
    let own = SETTINGS.replace("link_position_rad = [\"q1\", \"q2\"]\n", "");
    let (experiment, model) = experiment_of_motors(&own);
    with_source(&log, |source| {
        identify(&experiment, &model, &mut [source], &mut Unheard)
            .unwrap()
            .identification
    })
}

fn experiment_of_motors(settings: &str) -> (Experiment, Model) {
    let before_controller = settings.split("[controller]").next().unwrap();
    experiment(RIGID, before_controller, "")
}

fn truth() -> BTreeMap<String, f64> {
    toml::from_str(TRUTH).unwrap()
}

#[test]
fn vibrations_of_the_motors_give_the_springs() {
    let all: Vec<Vec<SpringFromMotor>> = (0..6_u64)
        .into_par_iter()
        .map(|seed| {
            let found = identification(&multisine(4.0, 0.6, seed), &truth(), seed);
            let codes: Vec<&str> = found.findings.iter().map(|own| own.code.as_str()).collect();
            assert!(codes.contains(&"springs-by-vibration"), "{codes:?}");
            found.springs_from_motor
        })
        .collect();
    let (mut held, mut count) = (0, 0);
    for springs in &all {
        for (joint, own) in springs.iter().enumerate() {
            let stiffness = own.stiffness.unwrap();
            let error = stiffness / STIFFNESS[joint] - 1.0;
            let sigmas = (stiffness - STIFFNESS[joint]) / own.stiffness_standard_error.unwrap();
            let rotor = own.rotor_inertia.unwrap();
            let of_rotor = (rotor - ROTOR[joint]) / own.rotor_inertia_standard_error.unwrap();
            println!(
                "{}: stiffness {:+.2} % ({sigmas:+.1}), rotor {:+.2} % ({of_rotor:+.1})",
                own.joint,
                100.0 * error,
                100.0 * (rotor / ROTOR[joint] - 1.0)
            );
            assert!(error.abs() < 0.03, "{} {error}", own.joint);
            held += usize::from(sigmas.abs() < 1.96) + usize::from(of_rotor.abs() < 1.96);
            count += 2;
        }
    }
    println!("{held} of {count} intervals hold");
    assert!(10 * held >= 9 * count, "{held} of {count}");
}

#[test]
fn a_slow_motion_gives_no_spring() {
    let found = identification(&multisine(0.3, 4.0, 1), &truth(), 1);
    assert!(
        found
            .springs_from_motor
            .iter()
            .all(|own| own.stiffness.is_none())
    );
    let finding = (found.findings.iter()).find(|own| own.code == "resonance-not-excited");
    assert_eq!(finding.unwrap().severity, Severity::Warning);
}

#[test]
fn dry_friction_that_hides_the_vibrations_gives_no_spring() {
    // The friction of the demo: the motors hardly feel the springs.
    let mut truth = truth();
    truth.insert("joint1.motor_viscous".to_owned(), 8.435_283);
    truth.insert("joint2.motor_viscous".to_owned(), 0.135_564);
    truth.insert("joint1.motor_coulomb".to_owned(), 1.360_21);
    truth.insert("joint2.motor_coulomb".to_owned(), 0.162_529);
    let found = identification(&multisine(1.0, 1.0, 1), &truth, 1);
    for (own, stiffness) in found.springs_from_motor.iter().zip(STIFFNESS) {
        let near = own
            .stiffness
            .is_none_or(|value| (value - stiffness).abs() < 0.1 * stiffness);
        assert!(near, "{own:?}");
    }
}
