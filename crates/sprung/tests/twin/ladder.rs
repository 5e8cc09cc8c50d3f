//! Every friction law and every part of a spring, found again from exact positions.

use std::collections::BTreeMap;

use sprung_base::progress::Unheard;
use sprung_core::spatial::BODY_NAMES;
use sprung_log::Channels;
use sprung_method::simulate::{TwinSetup, record};
use sprung_model::Model;
use sprung_robot::{self as description, no_files};
use sprung_testing::largest_of_normals;

use crate::logs::identify_log;

/// Two flexible joints against gravity and a rigid one that slides.
const EXPERIMENT: &str = r#"
format = 1
[robot]
dh_modified = [{}, { a_m = 0.4 }, { alpha_deg = 90.0, prismatic = true }]
gravity_m_per_s2 = [0.0, -9.81, 0.0]
[[robot.joint]]
name = "shoulder"
spring = ["linear", "cubic", "damping"]
link_friction = ["viscous", "coulomb", "offset"]
motor_friction = ["viscous-asymmetric", "coulomb-asymmetric", "quadratic", "load"]
[[robot.joint]]
name = "elbow"
spring = ["linear", "damping"]
link_friction = ["viscous-asymmetric", "coulomb"]
motor_friction = ["viscous", "coulomb", "offset", "stribeck"]
stribeck_velocity_rad_per_s = 0.3
[[robot.joint]]
name = "slide"
transmission = "rigid"
motor_friction = ["viscous", "coulomb", "offset", "presliding"]
presliding_width_rad = 0.2
[log]
time_s = "t"
link_position_rad = ["q1", "q2"]
motor_position_rad = ["p1", "p2"]
motor_position_m = ["p3"]
motor_torque_nm = ["t1", "t2"]
motor_force_n = ["f3"]
[identify]
estimator = "least-squares"
constraints = "none"                        # the links of this robot are at the border of what can exist
position_cutoff_hz = 499.0
encoder_offset = "none"                     # acts like an offset of the link's friction
[controller]
kind = "pd"
kp_nm_per_rad = [2000.0, 900.0, 6000.0]
kd_nms_per_rad = [40.0, 15.0, 120.0]
[controller.reference]
sines = [
  { joint = "shoulder", amplitude_deg = 20.0, frequency_hz = 0.9 },
  { joint = "shoulder", amplitude_deg = 15.0, frequency_hz = 0.37, phase_deg = 40.0 },
  { joint = "elbow", amplitude_deg = 25.0, frequency_hz = 1.1, phase_deg = 90.0 },
  { joint = "elbow", amplitude_deg = 20.0, frequency_hz = 0.43 },
  { joint = "slide", amplitude_m = 0.08, frequency_hz = 0.8, phase_deg = 20.0 },
  { joint = "slide", amplitude_m = 0.05, frequency_hz = 1.7 },
]
[simulate]
duration_s = 20.0
"#;

const TRUTH: [(&str, f64); 40] = [
    ("shoulder.rotor_inertia", 0.3),
    ("shoulder.stiffness", 900.0),
    ("shoulder.cubic_stiffness", 3e5),
    ("shoulder.spring_damping", 2.0),
    ("shoulder.link_viscous", 0.6),
    ("shoulder.link_coulomb", 0.8),
    ("shoulder.link_offset", 0.5),
    ("shoulder.motor_viscous_positive", 4.0),
    ("shoulder.motor_viscous_negative", 6.0),
    ("shoulder.motor_coulomb_positive", 2.0),
    ("shoulder.motor_coulomb_negative", 3.0),
    ("elbow.rotor_inertia", 0.1),
    ("elbow.stiffness", 400.0),
    ("elbow.spring_damping", 0.8),
    ("elbow.link_viscous_positive", 0.3),
    ("elbow.link_viscous_negative", 0.5),
    ("elbow.link_coulomb", 0.4),
    ("elbow.motor_viscous", 1.5),
    ("elbow.motor_coulomb", 0.9),
    ("elbow.motor_offset", -0.4),
    ("elbow.motor_stribeck", 0.7),
    ("shoulder.motor_quadratic", -1.0),
    ("shoulder.motor_load", 60.0),
    ("slide.rotor_inertia", 4.0),
    ("slide.motor_viscous", 30.0),
    ("slide.motor_coulomb", 8.0),
    ("slide.motor_offset", 2.0),
    ("slide.motor_presliding_1", 0.0),
    ("slide.motor_presliding_2", 0.0),
    ("slide.motor_presliding_3", 3.0),
    ("slide.motor_presliding_4", 2.0),
    ("slide.motor_presliding_5", 4.0),
    ("slide.motor_presliding_6", 1.0),
    ("link1.m", 4.0),
    ("link1.mx", 0.8),
    ("link1.izz", 0.25),
    ("link2.m", 2.5),
    ("link2.mx", 0.4),
    ("link2.izz", 0.12),
    ("link3.m", 1.5),
];

#[test]
fn every_law_is_found_again() {
    let experiment = description::read("ladder", EXPERIMENT, &[], &mut no_files).unwrap();
    let model = Model::new(&experiment).unwrap();
    let mut values: BTreeMap<String, f64> = (TRUTH.iter())
        .map(|(name, value)| ((*name).to_owned(), *value))
        .collect();
    for link in 1..=3 {
        for name in BODY_NAMES {
            let of_link = values.entry(format!("link{link}.{name}"));
            of_link.or_insert(if name == "ixx" || name == "iyy" {
                0.05
            } else {
                0.0
            });
        }
    }
    let truth = model.theta(&values).unwrap();
    let setup = TwinSetup {
        model: &model,
        theta: &truth,
        controller: experiment.controller.as_ref().unwrap(),
        settings: experiment.simulate.as_ref().unwrap(),
    };
    let channels = Channels::new(&experiment.robot, experiment.log.as_ref().unwrap()).unwrap();
    let mut log = Vec::new();
    record(&setup, &channels, &mut log, &mut Unheard).unwrap();
    let found = identify_log(&experiment, &model, &log).unwrap();
    let result = &found.identification.results[0];
    let limit = largest_of_normals(result.parameters.len());
    for (p, truth) in result.parameters.iter().zip(&truth) {
        let value = p.value.unwrap();
        println!("{}: {value:.5} for {truth:.5}", p.name);
        let error = p.standard_error.unwrap();
        assert!(
            (value - truth).abs() < limit * error,
            "{}: {value} ± {error}, not {truth}",
            p.name
        );
    }
}
