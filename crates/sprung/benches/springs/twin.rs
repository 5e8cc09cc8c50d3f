//! A log of the motors of the 2-DOF arm, and the springs by this log. The tests of the twin identify some of them.

use std::collections::BTreeMap;
use std::fmt::Write;

use sprung_base::progress::Unheard;
use sprung_log::Channels;
use sprung_method::estimate::{Identification, identify};
use sprung_method::simulate::{TwinSetup, record};
use sprung_model::{Model, Theta};
use sprung_robot::{self as description, Experiment, no_files};

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

/// True values of both joints.
pub(crate) const STIFFNESS: [f64; 2] = [9.358_730, 4.212_811];
const ROTOR: [f64; 2] = [0.216_776, 0.006_842];

/// Errors of a spring and of its rotor: relative, and in standard errors.
pub(crate) struct Errors {
    pub(crate) joint: String,
    pub(crate) stiffness: [f64; 2],
    pub(crate) rotor: [f64; 2],
}

impl Errors {
    /// Number of the two 95 % intervals that contain the truth.
    pub(crate) fn held(&self) -> usize {
        [self.stiffness, self.rotor]
            .iter()
            .filter(|[_, sigmas]| sigmas.abs() < 1.96)
            .count()
    }
}

/// Returns the errors of both springs in a log with vibrations up to 4 Hz, and the codes of its findings.
///
/// # Panics
///
/// If a spring is not found.
pub(crate) fn vibrations(seed: u64) -> (Vec<Errors>, Vec<String>) {
    let found = identification(&multisine(4.0, 0.6, seed), &truth(), seed);
    let of = |value: Option<f64>, error: Option<f64>, truth: f64| {
        let (value, error) = (value.expect("found"), error.expect("found"));
        [value / truth - 1.0, (value - truth) / error]
    };
    let springs = found.springs_from_motor.iter().enumerate();
    let errors = springs.map(|(joint, spring)| Errors {
        joint: spring.joint.clone(),
        stiffness: of(
            spring.stiffness,
            spring.stiffness_standard_error,
            STIFFNESS[joint],
        ),
        rotor: of(
            spring.rotor_inertia,
            spring.rotor_inertia_standard_error,
            ROTOR[joint],
        ),
    });
    let codes = found.findings.iter().map(|finding| finding.code.clone());
    (errors.collect(), codes.collect())
}

/// Multiples of 0.1 Hz with phases that look random.
pub(crate) fn multisine(highest_hz: f64, amplitude_deg: f64, seed: u64) -> String {
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
    let experiment = description::read("experiment.toml", &text, &[], &mut no_files)
        .expect("the experiment is right");
    let model = Model::new(&experiment).expect("the experiment has a model");
    (experiment, model)
}

/// Identifies a log of the motors.
///
/// # Panics
///
/// If the experiment is wrong.
pub(crate) fn identification(
    reference: &str,
    truth: &BTreeMap<String, f64>,
    seed: u64,
) -> Identification {
    let of_twin = SETTINGS.replace("springs_from_motor = true\n", "");
    let (twin, model) = experiment(FLEXIBLE, &of_twin, reference);
    let mut settings = twin.simulate.clone().expect("it has a twin");
    (settings.seed, settings.duration_s) = (seed, 30.0);
    let theta: Theta = model.theta(truth).expect("all parameters are given");
    let setup = TwinSetup {
        model: &model,
        theta: &theta,
        controller: twin.controller.as_ref().expect("it has one"),
        settings: &settings,
    };
    let channels = Channels::new(&twin.robot, twin.log.as_ref().expect("it has a log"))
        .expect("the columns are right");
    let mut log = Vec::new();
    record(&setup, &channels, &mut log, &mut Unheard).expect("the twin runs");
    let settings = SETTINGS.replace("link_position_rad = [\"q1\", \"q2\"]\n", "");
    let (experiment, model) = experiment_of_motors(&settings);
    with_source(&log, |source| {
        identify(&experiment, &model, &mut [source], &mut Unheard)
            .expect("the log is right")
            .identification
    })
}

fn experiment_of_motors(settings: &str) -> (Experiment, Model) {
    let before_controller = settings.split("[controller]").next().unwrap_or_default();
    experiment(RIGID, before_controller, "")
}

/// True values by name.
///
/// # Panics
///
/// Never.
pub(crate) fn truth() -> BTreeMap<String, f64> {
    toml::from_str(TRUTH).expect("values by name")
}
