//! Assumptions of a design about values that the experiment does not give.

use sprung_core::parameters::JointParameter;
use sprung_core::robot::Values;
use sprung_method::excite::Bounds;
use sprung_model::{Model, Scratch};
use sprung_robot::{Controller, ControllerKind, Experiment, Feedforward, Log, Reference, Simulate};

use crate::session::error::SessionError;
use crate::session::excite_error::ExciteError;

/// Damping of the assumed position control.
const DAMPING: f64 = 0.7;

/// Bandwidth of the assumed position control, Hz.
const BANDWIDTH_HZ: f64 = 10.0;

/// Counts per turn of assumed encoders.
pub(super) const COUNTS: u32 = 65_536;

/// Assumed noise of the logged torque, part of the largest torque.
const NOISE: f64 = 0.01;

/// Assumed values of an unknown drive: the part of the link's inertia that the rotor has, and the resonance, Hz.
const ROTOR_PART: f64 = 0.3;
const RESONANCE_HZ: f64 = 8.0;

/// Returns the nominal values, with rotors and springs of a typical drive where none are given.
pub(super) fn with_assumed_drives(
    model: &Model,
    assumed: &mut Vec<String>,
) -> Result<Vec<f64>, SessionError> {
    let parameters = model.parameters();
    let known = |parameter: &sprung_model::Parameter| {
        (parameter.nominal).or(parameter.may_be_zero().then_some(0.0))
    };
    let masses: Vec<String> = (parameters.iter())
        .filter(|parameter| parameter.joint.is_none() && known(parameter).is_none())
        .map(|parameter| parameter.short().into_owned())
        .collect();
    if !masses.is_empty() {
        return Err(ExciteError::NoMasses {
            names: masses.join(", "),
        }
        .into());
    }
    let mut theta: Vec<f64> = parameters
        .iter()
        .map(|parameter| known(parameter).unwrap_or(0.0))
        .collect();
    let inertias = inertias(model, &theta);
    let mut filled = Vec::new();
    for (index, parameter) in parameters.iter().enumerate() {
        let (None, Some((kind, joint))) = (known(parameter), parameter.joint) else {
            continue;
        };
        let rotor = model
            .index(JointParameter::RotorInertia, joint)
            .map(|index| theta[index]);
        let rotor = rotor
            .filter(|inertia| *inertia > 0.0)
            .unwrap_or(ROTOR_PART * inertias[joint]);
        theta[index] = if kind == JointParameter::Stiffness {
            let angular = std::f64::consts::TAU * RESONANCE_HZ;
            angular * angular * rotor * inertias[joint] / (rotor + inertias[joint])
        } else {
            rotor
        };
        filled.push(parameter.name.clone());
    }
    assumed.push(format!(
        "values of usual drives for {}, which the file does not give: rotors with {ROTOR_PART} of the link's inertia, \
         springs with a resonance at {RESONANCE_HZ} Hz",
        filled.join(", ")
    ));
    Ok(theta)
}

/// Returns the inertia that each motor moves fast: that of its rotor, and without spring also the links, kg·m² (kg).
fn fast_inertias(model: &Model, theta: &[f64]) -> Vec<f64> {
    let rotor = |joint: usize| {
        let index = model.index(JointParameter::RotorInertia, joint)?;
        model.is_flexible(joint).then(|| theta[index])
    };
    let all = inertias(model, theta).into_iter().enumerate();
    all.map(|(joint, inertia)| rotor(joint).unwrap_or(inertia))
        .collect()
}

/// Returns the inertia of each joint at zero, with the links that it carries and its rotor, kg·m² (kg).
fn inertias(model: &Model, theta: &[f64]) -> Vec<f64> {
    let (n, rows) = (model.joint_count(), model.coordinates());
    let mut scratch = Scratch::new(n);
    let mut matrix = vec![0.0; rows * rows];
    let bodies = model.bodies(theta);
    let values = Values {
        theta,
        bodies: &bodies,
    };
    let computed = (model.robot()).mass_matrix(
        &values,
        &vec![0.0; n],
        &mut scratch.workspace(),
        &mut matrix,
    );
    if computed.is_err() {
        matrix.fill(0.0);
    }
    (0..n)
        .map(|joint| {
            let motor = model.torque_row(joint);
            let diagonal = matrix[joint * (rows + 1)];
            if motor == joint {
                diagonal
            } else {
                diagonal + matrix[motor * (rows + 1)]
            }
        })
        .collect()
}

/// Returns a controller with which the links follow the reference.
pub(super) fn assumed_controller(
    model: &Model,
    theta: &[f64],
    assumed: &mut Vec<String>,
) -> Controller {
    let n = model.joint_count();
    let angular = std::f64::consts::TAU * BANDWIDTH_HZ;
    let gain = fast_inertias(model, theta)
        .into_iter()
        .enumerate()
        .map(|(joint, inertia)| {
            let mut row = vec![0.0; 4 * n];
            row[n + joint] = inertia * angular * angular;
            row[3 * n + joint] = 2.0 * DAMPING * inertia * angular;
            row
        })
        .collect();
    assumed.push(format!(
        "the links follow the trajectory: position control of the motors with a bandwidth of {BANDWIDTH_HZ} Hz and the torques of the \
         model without friction, because the file has no [controller]"
    ));
    Controller {
        kind: ControllerKind::StateFeedback,
        kp_nm_per_rad: Vec::new(),
        kd_nms_per_rad: Vec::new(),
        gain,
        feedforward: Feedforward::Identified,
        friction_compensation_speed_rad_per_s: None,
        velocity_window: [1, 1],
        shaper: Vec::new(),
        reference: Reference::default(),
    }
}

pub(in crate::session) fn assumed_twin(
    experiment: &Experiment,
    assumed: &mut Vec<String>,
) -> Result<Simulate, SessionError> {
    let period = experiment.excite.period_s;
    assumed.push(format!(
        "the log has the period of the controller, {period} s, because the file has no [simulate]"
    ));
    parsed("[simulate]", &format!("period_s = {period}"))
}

/// Reads a part of an experiment.
fn parsed<T: serde::de::DeserializeOwned>(part: &str, text: &str) -> Result<T, SessionError> {
    toml::from_str(text).map_err(|error| SessionError::NotParameters {
        file: part.to_owned(),
        why: error.to_string(),
    })
}

/// Returns the twin with typical sensors where the file gives none.
pub(in crate::session) fn completed(
    mut twin: Simulate,
    experiment: &Experiment,
    model: &Model,
    bounds: &Bounds,
    assumed: &mut Vec<String>,
) -> Simulate {
    let n = model.joint_count();
    // The values of the design represent the robot.
    twin.parameters = None;
    twin.torque_disturbance_nm.resize(n, 0.0);
    twin.link_torque_disturbance_nm.resize(n, 0.0);
    let is_given = |counts: &[u32]| counts.iter().any(|count| *count > 0);
    if !is_given(&twin.motor_encoder_counts_per_turn) {
        twin.motor_encoder_counts_per_turn = vec![COUNTS; n];
        assumed.push(format!(
            "motor encoders with {COUNTS} counts per turn of the output (motor_encoder_counts_per_turn of [simulate] changes it)"
        ));
    }
    let has_springs = (0..n).any(|joint| model.is_flexible(joint));
    if !is_given(&twin.link_encoder_counts_per_turn) {
        twin.link_encoder_counts_per_turn = twin.motor_encoder_counts_per_turn.clone();
        if has_springs {
            assumed.push(
                "link encoders like those of the motors (link_encoder_counts_per_turn of [simulate] changes it)".to_owned(),
            );
        }
    }
    let noise = &twin.torque_noise_nm;
    if noise.len() != n || noise.iter().any(|level| *level <= 0.0) {
        twin.torque_noise_nm = (0..n)
            .map(|joint| {
                let torque = bounds.joints[joint].torque;
                let limit = experiment.robot.limits(joint).torque_nm.unwrap_or(1.0);
                NOISE
                    * if torque.is_limited() {
                        torque.half
                    } else {
                        limit
                    }
            })
            .collect();
        assumed.push(format!(
            "white noise of the logged torque of {} % of its limit, 1 N·m without a limit (torque_noise_nm of [simulate] changes it)",
            100.0 * NOISE
        ));
    }
    twin
}

/// Returns a log with the positions and torques of all joints.
pub(super) fn assumed_log(model: &Model, assumed: &mut Vec<String>) -> Result<Log, SessionError> {
    let n = model.joint_count();
    let list = |prefix: &str| -> String {
        let names: Vec<String> = (1..=n).map(|k| format!("\"{prefix}{k}\"")).collect();
        names.join(", ")
    };
    let mut text = format!(
        "file = \"excitation.csv\"\ntime_s = \"t_s\"\nmotor_position_rad = [{}]\nmotor_torque_nm = [{}]\n",
        list("phi"),
        list("tau")
    );
    let mut positions = "motor positions";
    if (0..n).any(|joint| model.is_flexible(joint)) {
        text += "link_position_rad = [";
        text += &list("q");
        text += "]\n";
        positions = "motor and link positions";
    }
    assumed.push(format!(
        "the log has {positions} and motor torques of all joints, because the file has no [log]"
    ));
    parsed("[log]", &text)
}
