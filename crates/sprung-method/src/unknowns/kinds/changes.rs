//! A parameter of the robot that is not as it was: friction, a stiffness, or the load of the last link. They are sought where all
//! parameters are known, as in a validation.

use sprung_core::parameters::JointParameter;
use sprung_core::spatial::{BODY, BODY_NAMES, BODY_UNITS};

use super::catalogued::Catalogued;
use crate::unknowns::unknown::{Effect, Kind, Place, Unknown};

/// Start of the id of a change; the name of the parameter follows.
pub(in crate::unknowns) const CHANGE: &str = "change ";

/// Least torque of a change, relative to that of the joint.
const LEAST: f64 = 0.005;

pub(super) fn list(of: &Catalogued<'_>) -> Vec<Unknown> {
    if !of.is_known {
        return Vec::new();
    }
    let model = of.model;
    let single = |index: usize| {
        let mut by = vec![0.0; model.parameters().len()];
        by[index] = 1.0;
        by
    };
    let of_joints = (model.parameters().iter().enumerate()).filter_map(|(index, parameter)| {
        let (kind, joint) = match parameter.joint? {
            (JointParameter::Friction(..) | JointParameter::TorqueOffset, joint) => {
                (Kind::Friction, joint)
            }
            (JointParameter::Stiffness, joint) => (Kind::Stiffness, joint),
            _ => return None,
        };
        let moves = of.speeds[joint] > 0.0;
        let name = parameter.short();
        moves.then(|| {
            change(
                kind,
                Place::Joint(joint),
                &name,
                parameter.unit,
                single(index),
            )
        })
    });
    let loads: Vec<Unknown> = match model.tree() {
        None => (model.parameters().iter().enumerate())
            .filter(|(_, parameter)| parameter.joint.is_none())
            .map(|(index, parameter)| {
                let name = parameter.short();
                change(
                    Kind::Load,
                    Place::Robot,
                    &name,
                    parameter.unit,
                    single(index),
                )
            })
            .collect(),
        Some(tree) => {
            let carries = |joint: usize| tree.joints.iter().any(|j| j.parent == Some(joint));
            (0..of.joints)
                .filter(|&joint| !carries(joint))
                .flat_map(|joint| (0..BODY).map(move |k| (joint, k)))
                .map(|(joint, k)| {
                    let name = format!("{}.{}", tree.links[joint], BODY_NAMES[k]);
                    let by = model.change_by_standard(joint * BODY + k);
                    change(Kind::Load, Place::Robot, &name, BODY_UNITS[k], by)
                })
                .collect()
        }
    };
    of_joints.chain(loads).collect()
}

fn change(kind: Kind, place: Place, name: &str, unit: &'static str, by: Vec<f64>) -> Unknown {
    Unknown {
        least: LEAST,
        ..Unknown::new(
            format!("{CHANGE}{name}"),
            kind,
            place,
            unit,
            Effect::Parameters(by),
        )
    }
}
