//! What a design takes from the experiment, and what it assumes where the experiment says nothing.

use std::collections::BTreeMap;

use sprung_core::chain::JointKind;
use sprung_core::parameters::JointParameter;
use sprung_core::robot::Values;
use sprung_method::estimate::KnownNoise;
use sprung_method::excite::{Bounds, Errors, Kinematics, Limited, Loop, growth};
use sprung_model::{Model, ModelError, Scratch};
use sprung_robot::{Controller, ControllerKind, Experiment, Feedforward, Log, Reference, Simulate};

use crate::session::error::SessionError;
use crate::session::excite_error::ExciteError;
use crate::session::parameters::Parameters;

/// Damping of the assumed position control.
const DAMPING: f64 = 0.7;

/// Counts per turn of assumed encoders.
const COUNTS: u32 = 65_536;

/// Assumed noise of the logged torque, part of the largest torque.
const NOISE: f64 = 0.01;

/// Assumed values of an unknown drive: the part of the link's inertia that the rotor has, and the resonance, Hz.
const ROTOR_PART: f64 = 0.3;
const RESONANCE_HZ: f64 = 8.0;

/// Parts of the limits that a first motion of an unknown robot uses; gravity needs its torque in a small motion, too.
const WARM_UP: f64 = 0.3;
const WARM_UP_POSITION: f64 = 0.5;
const WARM_UP_TORQUE: f64 = 0.6;

/// The experiment of a design, complete.
pub(super) struct Setup {
    /// The experiment with log, twin and controller.
    pub(super) experiment: Experiment,
    pub(super) model: Model,
    pub(super) theta: Vec<f64>,
    pub(super) bounds: Bounds,
    pub(super) errors: Errors,
    pub(super) runs: Loop,
    /// Whether a PD controller of the motors closes the loop.
    pub(super) is_pd: bool,
    pub(super) kinematics: Option<Kinematics>,
    pub(super) assumed: Vec<String>,
}

impl Setup {
    pub(super) fn new(
        experiment: Experiment,
        model: Model,
        parameters: Option<&Parameters>,
        is_warm_up: bool,
    ) -> Result<Self, SessionError> {
        let mut assumed = Vec::new();
        let (model, theta) = values(model, parameters, is_warm_up, &mut assumed)?;
        (model.check_inertias(&theta))
            .and_then(|()| model.check_stiffness(&theta))
            .map_err(|error| ExciteError::Impossible(error.to_string()))?;
        let bounds = bounds(&experiment, is_warm_up, &mut assumed);
        let kinematics = kinematics(&experiment)?;
        let mut experiment = experiment;
        let declared = experiment.controller.clone();
        let is_pd = (declared.as_ref()).is_some_and(|own| own.kind == ControllerKind::Pd);
        let controller = match declared {
            Some(own) => own,
            None => assumed_controller(&experiment, &model, &theta, &mut assumed),
        };
        if is_pd
            && let Some(rate) = growth(&model, &theta, &controller, &vec![0.0; model.joint_count()])
        {
            return Err(ExciteError::Unstable {
                time_s: 1.0 / rate,
                runs_away: false,
            }
            .into());
        }
        let twin = match experiment.simulate.take() {
            Some(own) => own,
            None => assumed_twin(&experiment, &mut assumed)?,
        };
        let twin = completed(twin, &experiment, &model, &bounds, &mut assumed);
        let errors = errors(&twin, &model);
        let runs = Loop {
            controller: controller.clone(),
            period: experiment.excite.period_s,
        };
        if experiment.log.is_none() {
            experiment.log = Some(assumed_log(&model, &mut assumed)?);
        }
        experiment.controller = Some(controller);
        experiment.simulate = Some(twin);
        assumed.push(
            "collisions of links with each other and with obstacles were not looked at".to_owned(),
        );
        Ok(Self {
            experiment,
            model,
            theta,
            bounds,
            errors,
            runs,
            is_pd,
            kinematics,
            assumed,
        })
    }

    /// Returns the values by name.
    pub(super) fn named(&self) -> BTreeMap<String, f64> {
        (self.model.parameters().iter().zip(&self.theta))
            .map(|(own, value)| (own.name.clone(), *value))
            .collect()
    }

    /// Returns the experiment whose twin makes a motion of some length.
    pub(super) fn with_motion(&self, reference: Reference, duration: f64) -> Experiment {
        let mut own = self.experiment.clone();
        if let Some(controller) = &mut own.controller {
            controller.reference = reference;
        }
        if let Some(twin) = &mut own.simulate {
            twin.duration_s = duration;
        }
        own
    }

    /// Returns the noise of the log and the disturbances.
    pub(super) fn noise(&self) -> KnownNoise {
        KnownNoise {
            torque: self.errors.torque.clone(),
            motor: self.errors.disturbances[1].clone(),
            link: self.errors.disturbances[0].clone(),
            corner: self.errors.corner,
        }
    }
}

/// Returns the values of a design and the model with the friction laws of an identification.
fn values(
    model: Model,
    parameters: Option<&Parameters>,
    is_warm_up: bool,
    assumed: &mut Vec<String>,
) -> Result<(Model, Vec<f64>), SessionError> {
    if let Some(set) = parameters.and_then(|own| own.sets.first()) {
        let theta = model.theta(&set.values)?;
        return Ok((model.shaped(&set.values), theta));
    }
    match model.nominal() {
        Ok(theta) => Ok((model, theta)),
        Err(ModelError::Missing { .. }) if is_warm_up => {
            let theta = with_assumed_drives(&model, assumed)?;
            Ok((model, theta))
        }
        Err(ModelError::Missing { names }) => Err(ExciteError::Missing {
            names: names.join(", "),
        }
        .into()),
        Err(other) => Err(other.into()),
    }
}

/// Returns the nominal values, with rotors and springs that a usual drive has where none are given.
fn with_assumed_drives(model: &Model, assumed: &mut Vec<String>) -> Result<Vec<f64>, SessionError> {
    let parameters = model.parameters();
    let known = |own: &sprung_model::Parameter| (own.nominal).or(own.may_be_zero().then_some(0.0));
    let masses: Vec<String> = (parameters.iter())
        .filter(|own| own.joint.is_none() && known(own).is_none())
        .map(|own| own.short().into_owned())
        .collect();
    if !masses.is_empty() {
        return Err(ExciteError::NoMasses {
            names: masses.join(", "),
        }
        .into());
    }
    let mut theta: Vec<f64> = parameters
        .iter()
        .map(|own| known(own).unwrap_or(0.0))
        .collect();
    let inertias = inertias(model, &theta);
    let mut filled = Vec::new();
    for (index, own) in parameters.iter().enumerate() {
        let (None, Some((kind, joint))) = (known(own), own.joint) else {
            continue;
        };
        let rotor = model
            .index(JointParameter::RotorInertia, joint)
            .map(|index| theta[index]);
        let rotor = rotor
            .filter(|own| *own > 0.0)
            .unwrap_or(ROTOR_PART * inertias[joint]);
        theta[index] = if kind == JointParameter::Stiffness {
            let angular = std::f64::consts::TAU * RESONANCE_HZ;
            angular * angular * rotor * inertias[joint] / (rotor + inertias[joint])
        } else {
            rotor
        };
        filled.push(own.name.clone());
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
    all.map(|(joint, own)| rotor(joint).unwrap_or(own))
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
            let own = matrix[joint * (rows + 1)];
            if motor == joint {
                own
            } else {
                own + matrix[motor * (rows + 1)]
            }
        })
        .collect()
}

/// Returns the limits; a first motion of an unknown robot uses a part of them.
fn bounds(experiment: &Experiment, is_warm_up: bool, assumed: &mut Vec<String>) -> Bounds {
    let own = Bounds::new(experiment);
    if !is_warm_up {
        return own;
    }
    assumed.push(format!(
        "the first motion uses {} % of the ranges of positions, {} % of the limits of torques and deflections, and {} % of those \
         of velocities, accelerations, jerks, rates of torques and the speed of the tool",
        100.0 * WARM_UP_POSITION,
        100.0 * WARM_UP_TORQUE,
        100.0 * WARM_UP
    ));
    let part = |what| match what {
        Limited::Position => WARM_UP_POSITION,
        Limited::Torque | Limited::Deflection => WARM_UP_TORQUE,
        Limited::Height => 1.0,
        Limited::Velocity
        | Limited::Acceleration
        | Limited::Jerk
        | Limited::TorqueRate
        | Limited::ToolSpeed => WARM_UP,
    };
    let parts = Limited::ALL.map(part);
    own.narrowed(&parts)
}

fn kinematics(experiment: &Experiment) -> Result<Option<Kinematics>, SessionError> {
    let settings = &experiment.excite;
    let tree = experiment.robot.tree.as_ref();
    let limited = [
        ("tool_speed_m_per_s", settings.tool_speed_m_per_s.is_some()),
        ("floor_m", settings.floor_m.is_some()),
    ];
    match (tree, limited.iter().find(|(_, is_limited)| *is_limited)) {
        (None, Some((key, _))) => Err(ExciteError::NoLengths { key }.into()),
        (None, None) => Ok(None),
        (Some(tree), _) => Ok(Some(Kinematics::new(
            tree,
            settings.tool_xyz_m,
            experiment.robot.gravity(),
        ))),
    }
}

/// Returns a controller with which the links follow the reference.
fn assumed_controller(
    experiment: &Experiment,
    model: &Model,
    theta: &[f64],
    assumed: &mut Vec<String>,
) -> Controller {
    let n = model.joint_count();
    let hz = experiment.excite.bandwidth_hz;
    let angular = std::f64::consts::TAU * hz;
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
        "the links follow the trajectory: position control of the motors with a bandwidth of {hz} Hz and the torques of the \
         model without friction, because the file has no [controller]"
    ));
    Controller {
        kind: ControllerKind::StateFeedback,
        kp_nm_per_rad: Vec::new(),
        kd_nms_per_rad: Vec::new(),
        gain,
        feedforward: Feedforward::Identified,
        velocity_window: [1, 1],
        reference: Reference::default(),
    }
}

fn assumed_twin(
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

/// Returns the twin with usual sensors where the file gives none.
fn completed(
    mut twin: Simulate,
    experiment: &Experiment,
    model: &Model,
    bounds: &Bounds,
    assumed: &mut Vec<String>,
) -> Simulate {
    let n = model.joint_count();
    // The values of the design stand for the robot.
    twin.parameters = None;
    twin.torque_disturbance_nm.resize(n, 0.0);
    twin.link_torque_disturbance_nm.resize(n, 0.0);
    let is_given = |counts: &[u32]| counts.iter().any(|own| *own > 0);
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
    if noise.len() != n || noise.iter().any(|own| *own <= 0.0) {
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

/// Returns the errors that a design weights with.
fn errors(twin: &Simulate, model: &Model) -> Errors {
    let n = model.joint_count();
    let steps = |counts: &[u32]| -> Vec<f64> {
        (0..n)
            .map(|joint| {
                let turn = match model.kind(joint) {
                    JointKind::Revolute => std::f64::consts::TAU,
                    JointKind::Prismatic => 1.0,
                };
                turn / f64::from(counts.get(joint).copied().unwrap_or(COUNTS).max(1))
            })
            .collect()
    };
    let level = |list: &[f64]| -> Vec<f64> {
        (0..n)
            .map(|joint| list.get(joint).copied().unwrap_or(0.0))
            .collect()
    };
    Errors {
        period: twin.period_s,
        steps: [
            steps(&twin.link_encoder_counts_per_turn),
            steps(&twin.motor_encoder_counts_per_turn),
        ],
        torque: level(&twin.torque_noise_nm),
        disturbances: [
            level(&twin.link_torque_disturbance_nm),
            level(&twin.torque_disturbance_nm),
        ],
        corner: twin.torque_disturbance_hz,
    }
}

/// Returns a log with the positions and torques of all joints.
fn assumed_log(model: &Model, assumed: &mut Vec<String>) -> Result<Log, SessionError> {
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
