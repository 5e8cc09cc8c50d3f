//! A parameter of the robot that is not as it was: friction, a stiffness, a play, or the load of the last link. They are sought where all
//! parameters are known, as in a validation.

use sprung_core::drives::Term;
use sprung_core::friction::Shape;
use sprung_core::parameters::JointParameter;
use sprung_core::spatial::{BODY, BODY_NAMES, BODY_UNITS};

use super::catalogued::Catalogued;
use crate::log::Signal;
use crate::model::play_name;
use crate::unknowns::result::AddedLaw;
use crate::unknowns::unknown::{Effect, Kind, LawColumn, Place, Unknown};

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
        let mut by = single(index);
        // A preload is the stiffness times the difference of the zeros of the encoders, which stays.
        if let (Kind::Stiffness, Some(preload)) =
            (kind, model.index(JointParameter::Preload, joint))
        {
            let known = |index: usize| model.known(index).unwrap_or_default();
            by[preload] = known(preload) / known(index);
        }
        let moves = of.speeds[joint] > 0.0;
        let name = parameter.short();
        moves.then(|| change(kind, Place::Joint(joint), &name, parameter.unit, by))
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
    let plays = (0..of.joints).filter_map(|joint| play(of, joint));
    of_joints.chain(loads).chain(plays).collect()
}

/// Half width of the play whose torque is the column, in root mean squares of the deflection.
const PLAY: f64 = 0.1;

/// Returns the play of a spring without one: a wider one has nearly the same column, in proportion.
fn play(of: &Catalogued<'_>, joint: usize) -> Option<Unknown> {
    let model = of.model;
    if !model.is_flexible(joint) || model.play(joint).is_some() || of.speeds[joint] <= 0.0 {
        return None;
    }
    let stiffness = model.known(model.index(JointParameter::Stiffness, joint)?)?;
    let preload = model.index(JointParameter::Preload, joint);
    let preload = preload
        .and_then(|index| model.known(index))
        .unwrap_or_default();
    let half_width = PLAY * of.deflection(of.channels.telling(Signal::Link, joint)?)?;
    // In the middle of the play the spring has no torque.
    let with = |half_width: f64| Shape {
        play: half_width,
        play_centre: preload / stiffness,
        ..*model.shape(joint)
    };
    let (loose, whole) = (with(half_width), with(f64::MIN_POSITIVE));
    let robot = model.robot();
    let springs = robot
        .terms
        .iter()
        .filter(|term| term.joint == joint && term.what == JointParameter::Stiffness);
    let scaled = |term: &Term, by: f64| Term {
        gain: by * term.gain,
        ..*term
    };
    let factor = stiffness / half_width;
    let terms = springs.flat_map(|term| {
        [
            (scaled(term, factor), loose),
            (scaled(term, -factor), whole),
        ]
    });
    Some(Unknown {
        least: LEAST,
        is_positive: true,
        ..Unknown::new(
            format!("{CHANGE}{}", play_name(&of.names[joint])),
            Kind::Play,
            Place::Joint(joint),
            if of.channels.turns[joint] { "rad" } else { "m" },
            Effect::Law {
                column: LawColumn::Terms(terms.collect()),
                added: Some(AddedLaw {
                    of: "spring".to_owned(),
                    law: "play".to_owned(),
                    ..AddedLaw::default()
                }),
            },
        )
    })
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
