//! Turns named values into a robot of single links.

use std::collections::BTreeMap;

use sprung_core::friction::Law;
use sprung_core::parameters::{JointParameter, Side};
use sprung_core::spatial::{BODY, BODY_NAMES};

use super::error::ExportError;
use super::robot::{DriveValues, Friction, JointLimits, StandardJoint, StandardRobot};
use crate::description::Experiment;
use crate::model::{Model, Theta, is_possible};
use crate::numbers::Shown;

/// Missing names in a message.
const NAMES_SHOWN: usize = 3;

/// Least eigenvalue of the second moments of a possible body, relative to their trace.
const LEAST_MOMENT: f64 = 1e-15;

/// A robot of single links, and the parameters that it does not contain.
#[derive(Clone, Debug)]
pub(super) struct Standard {
    pub(super) robot: StandardRobot,
    /// Parameters with laws that no file can represent, with their values other than zero.
    pub(super) extras: Vec<Extra>,
    /// Parameters without a value, which are zero in the file.
    pub(super) unknown: Vec<String>,
    /// Theta of the robot with the parameters that a file can represent, except Coulomb friction.
    pub(super) theta: Theta,
}

/// A parameter that no format can represent exactly.
#[derive(Clone, Debug)]
pub(super) struct Extra {
    pub(super) name: String,
    pub(super) kind: JointParameter,
    pub(super) value: f64,
    pub(super) unit: &'static str,
}

/// Returns the robot of single links with these values.
///
/// - `values`: values of standard parameters of links, and of the parameters of joints, by name. For
///   the paper's arm the values of theta.
///
/// # Errors
///
/// [`ExportError`] if a value is missing or not physical.
pub(super) fn standard(
    experiment: &Experiment,
    model: &Model,
    values: &BTreeMap<String, f64>,
) -> Result<Standard, ExportError> {
    let n = model.joint_count();
    let links = links_of(model);
    let bodies = match model.tree() {
        Some(_) => bodies_of_tree(model, &links, values)?,
        None => bodies_of_planar(values)?,
    };
    let mut extras = Vec::new();
    let mut drives = vec![DriveValues::default(); n];
    let (mut missing, mut unknown) = (Vec::new(), Vec::new());
    for (joint, drive) in drives.iter_mut().enumerate() {
        drive.is_flexible = model.is_flexible(joint);
        drive.gear_ratio = experiment.robot.joint[joint].ratio();
        let name = format!("{}.rotor_inertia", model.joints()[joint]);
        let given = || given(model, n * BODY + joint);
        drive.rotor_inertia = (values.get(&name).copied()).or_else(given).unwrap_or(0.0);
    }
    for parameter in model.parameters() {
        let Some((kind, joint)) = parameter.joint else {
            continue;
        };
        let known = values.get(&parameter.name).copied().or(parameter.fixed);
        match (known, kind.is_vital()) {
            (None, true) if model.is_flexible(joint) => missing.push(parameter.name.clone()),
            (None, false) if kind != JointParameter::TorqueOffset => {
                unknown.push(parameter.name.clone());
            }
            _ => {}
        }
        let value = known.unwrap_or(0.0);
        if !take(&mut drives[joint], kind, value) && value != 0.0 {
            extras.push(Extra {
                name: parameter.name.clone(),
                kind,
                value,
                unit: parameter.unit,
            });
        }
    }
    if !missing.is_empty() {
        return Err(ExportError::NotDetermined { names: missing });
    }
    let places = model.robot().links.chain.joints();
    let joints: Vec<StandardJoint> = (0..n)
        .map(|i| StandardJoint {
            name: model.joints()[i].clone(),
            link: links[i].clone(),
            place: places[i],
            body: bodies[i],
            drive: drives[i],
            limits: JointLimits {
                effort: experiment.robot.joint[i].torque_limit(),
                ..JointLimits::default()
            },
        })
        .collect();
    physical(&joints)?;
    let theta = theta(model, values, &joints)?;
    Ok(Standard {
        robot: StandardRobot {
            name: experiment.robot.name.clone(),
            // The paper's arm moves in a horizontal plane.
            gravity: model
                .links()
                .map_or([0.0, 0.0, -9.81], |links| links.gravity),
            joints,
        },
        extras,
        unknown,
        theta,
    })
}

fn links_of(model: &Model) -> Vec<String> {
    match model.tree() {
        Some(tree) => tree.links.clone(),
        None => (1..=model.joint_count())
            .map(|i| format!("link{i}"))
            .collect(),
    }
}

fn bodies_of_tree(
    model: &Model,
    links: &[String],
    values: &BTreeMap<String, f64>,
) -> Result<Vec<[f64; BODY]>, ExportError> {
    let mut missing = Vec::new();
    let mut bodies = Vec::with_capacity(links.len());
    for (at, link) in links.iter().enumerate() {
        let body = std::array::from_fn(|k| {
            let name = format!("{link}.{}", BODY_NAMES[k]);
            let given = || given(model, at * BODY + k);
            (values.get(&name).copied())
                .or_else(given)
                .unwrap_or_else(|| {
                    missing.push(name);
                    f64::NAN
                })
        });
        bodies.push(body);
    }
    if missing.is_empty() {
        return Ok(bodies);
    }
    Err(lacking(
        missing,
        "sprung identify writes them as standard_parameters, and its findings \
         no-possible-bodies and impossible-robot name what prevents them: correct the nominal bodies or the \
         limits in [identify.physical]",
    ))
}

/// Returns the value of a standard parameter that the experiment gives.
fn given(model: &Model, standard: usize) -> Option<f64> {
    model.links()?.known.get(&standard).copied()
}

fn lacking(mut missing: Vec<String>, remedy: &'static str) -> ExportError {
    let more = missing.len().saturating_sub(NAMES_SHOWN);
    missing.truncate(NAMES_SHOWN);
    ExportError::NoBodies {
        names: missing,
        more,
        remedy,
    }
}

/// Returns two possible bodies of the paper's arm with its three parameters; link 1 has the length 1 m.
///
/// The mass of link 2 is between the least one that keeps link 2 possible, and the largest one that
/// keeps link 1 possible.
fn bodies_of_planar(values: &BTreeMap<String, f64>) -> Result<Vec<[f64; BODY]>, ExportError> {
    let names = ["link1.inertia_total", "link2.coupling", "link2.inertia"];
    let missing = names.iter().filter(|name| !values.contains_key(**name));
    let missing: Vec<String> = missing.map(|name| (*name).to_owned()).collect();
    if !missing.is_empty() {
        return Err(lacking(missing, "run sprung identify first"));
    }
    let [total, coupling, second] = names.map(|name| values[name]);
    let first = total - second;
    if !(second > 0.0 && first * second > coupling * coupling) {
        return Err(ExportError::NotPhysical {
            reasons: vec![format!(
                "the mass matrix of link1 and link2 is not positive ({} = {}, {} = {}, {} = {})",
                names[0],
                Shown(total),
                names[1],
                Shown(coupling),
                names[2],
                Shown(second)
            )],
        });
    }
    let mass = 0.5 * (coupling * coupling / second + first);
    let centre = coupling / mass;
    let about_centre = second - mass * centre * centre;
    let inertia = first - mass;
    // Thick bodies: the inertia about the other axes has no effect on the motion.
    let other = about_centre + mass * centre * centre;
    Ok(vec![
        [
            mass, 0.0, 0.0, 0.0, inertia, 0.0, inertia, 0.0, 0.0, inertia,
        ],
        [
            mass,
            coupling,
            0.0,
            0.0,
            about_centre,
            0.0,
            other,
            0.0,
            0.0,
            second,
        ],
    ])
}

/// Adds a parameter to a drive. Returns whether a file can represent the parameter exactly.
fn take(drive: &mut DriveValues, kind: JointParameter, value: f64) -> bool {
    let of = |drive: &mut DriveValues, side: Side, viscous: f64, coulomb: f64| {
        let friction: &mut Friction = match side {
            Side::Link => &mut drive.link,
            Side::Motor => &mut drive.motor,
        };
        friction.viscous += viscous;
        friction.coulomb += coulomb;
    };
    match kind {
        // Standard parameters give the rotor inertia.
        JointParameter::RotorInertia | JointParameter::TorqueOffset => true,
        JointParameter::Stiffness => {
            drive.stiffness = value;
            true
        }
        JointParameter::Damping => {
            drive.damping = value;
            true
        }
        JointParameter::BackEmf => {
            drive.motor.viscous += value;
            true
        }
        JointParameter::Friction(side, law) => match law {
            Law::Viscous => {
                of(drive, side, value, 0.0);
                true
            }
            Law::Coulomb => {
                of(drive, side, 0.0, value);
                true
            }
            Law::ViscousPositive | Law::ViscousNegative => {
                of(drive, side, 0.5 * value, 0.0);
                false
            }
            Law::CoulombPositive | Law::CoulombNegative => {
                of(drive, side, 0.0, 0.5 * value);
                false
            }
            Law::Offset
            | Law::Stribeck
            | Law::Quadratic
            | Law::Load
            | Law::Presliding1
            | Law::Presliding2
            | Law::Presliding3
            | Law::Presliding4
            | Law::Presliding5
            | Law::Presliding6 => false,
        },
        JointParameter::CubicStiffness
        | JointParameter::Hysteresis(_)
        | JointParameter::Preload
        | JointParameter::Change(..) => false,
    }
}

/// Checks that bodies and drives can exist.
fn physical(joints: &[StandardJoint]) -> Result<(), ExportError> {
    let mut reasons = Vec::new();
    for joint in joints {
        let body = &joint.body;
        if body[0].is_nan() || body[0] <= 0.0 {
            let mass = Shown(body[0]);
            reasons.push(format!("{} has the mass {mass} kg", joint.link));
        } else if !is_possible(body, LEAST_MOMENT) {
            reasons.push(format!(
                "no body with a density that is nowhere negative has the inertia of {}",
                joint.link
            ));
        }
        let drive = &joint.drive;
        let flexible = drive.is_flexible;
        for (what, value, must_be_positive) in [
            ("rotor inertia", drive.rotor_inertia, flexible),
            ("stiffness", drive.stiffness, flexible),
            ("spring damping", drive.damping, false),
            ("link viscous friction", drive.link.viscous, false),
            ("motor viscous friction", drive.motor.viscous, false),
            ("link Coulomb friction", drive.link.coulomb, false),
            ("motor Coulomb friction", drive.motor.coulomb, false),
        ] {
            if value.is_nan() || value < 0.0 || must_be_positive && value <= 0.0 {
                let value = Shown(value);
                reasons.push(format!("the {what} of {} is {value}", joint.name));
            }
        }
    }
    if reasons.is_empty() {
        return Ok(());
    }
    Err(ExportError::NotPhysical { reasons })
}

/// Returns theta with the parameters that a file can represent, without Coulomb friction.
fn theta(
    model: &Model,
    values: &BTreeMap<String, f64>,
    joints: &[StandardJoint],
) -> Result<Theta, ExportError> {
    let mut said = values.clone();
    for parameter in model.parameters() {
        let Some((kind, joint)) = parameter.joint else {
            continue;
        };
        let drive = &joints[joint].drive;
        let value_of = |kind: JointParameter| {
            let index = model.index(kind, joint)?;
            let parameter = &model.parameters()[index];
            values.get(&parameter.name).copied().or(parameter.fixed)
        };
        // The mean of both directions.
        let mean = |side: Side| {
            let of = |law: Law| value_of(JointParameter::Friction(side, law)).unwrap_or(0.0);
            0.5 * (of(Law::ViscousPositive) + of(Law::ViscousNegative))
        };
        let value = match kind {
            JointParameter::RotorInertia => continue,
            JointParameter::Stiffness => drive.stiffness,
            JointParameter::Damping => drive.damping,
            JointParameter::BackEmf | JointParameter::Friction(_, Law::Viscous) => {
                value_of(kind).unwrap_or(0.0)
            }
            JointParameter::Friction(side, Law::ViscousPositive | Law::ViscousNegative) => {
                mean(side)
            }
            JointParameter::CubicStiffness
            | JointParameter::Hysteresis(_)
            | JointParameter::Preload
            | JointParameter::Friction(..)
            | JointParameter::Change(..)
            | JointParameter::TorqueOffset => 0.0,
        };
        said.insert(parameter.name.clone(), value);
    }
    Ok(model.theta(&said)?)
}
