//! Exact, approximated and dropped properties of a file.

use std::borrow::Cow;

use serde::Serialize;
use sprung_core::friction::Law;
use sprung_core::parameters::{JointParameter, Side};

use super::format::Format;
use super::robot::{Form, StandardJoint, StandardRobot};
use super::standard::Extra;
use crate::numbers::Shown;

/// How a file contains a property of the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum How {
    /// As identified.
    Exact,
    /// By the nearest thing that the format has.
    Approximated,
    /// Not at all.
    Dropped,
}

impl How {
    /// Returns the word for tables.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Approximated => "approximated",
            Self::Dropped => "dropped",
        }
    }
}

/// One property of the robot in a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Said {
    /// The property.
    pub what: String,
    /// How the file says it.
    pub how: How,
    /// Place in the file, or the reason for its absence.
    pub note: String,
}

pub(super) fn row(what: &str, how: How, note: impl Into<String>) -> Said {
    Said {
        what: what.to_owned(),
        how,
        note: note.into(),
    }
}

/// Returns the rows of all drives and links.
pub(super) fn said(
    format: Format,
    form: Form,
    robot: &StandardRobot,
    extras: &[Extra],
) -> Vec<Said> {
    let any = |has: fn(&StandardJoint) -> bool| robot.joints.iter().any(has);
    let springs = any(|joint| joint.drive.is_flexible);
    let mut rows = vec![row(
        "links",
        How::Exact,
        "mass, centre of mass and inertia of each moving link",
    )];
    rows.push(rotors(format, form, robot));
    if springs {
        rows.push(stiffness(format, form));
        if any(|joint| joint.drive.damping > 0.0) {
            let of_stiffness = stiffness(format, form);
            rows.push(Said {
                what: "damping of springs".to_owned(),
                ..of_stiffness
            });
        }
    }
    rows.extend(viscous(format, form, robot));
    rows.extend(coulomb(format, robot));
    rows.extend(others(format, extras));
    let usual = [0.0, 0.0, -9.81];
    let is_other =
        (robot.gravity.iter().zip(usual)).any(|(component, usual)| (component - usual).abs() > 0.0);
    if matches!(format, Format::Urdf | Format::Sdf) && is_other {
        let [x, y, z] = robot.gravity.map(Shown);
        let note = format!("the format has no gravity: set ({x}, {y}, {z}) m/s² in the simulator");
        rows.push(row("gravity", How::Dropped, note));
    }
    rows
}

fn rotors(format: Format, form: Form, robot: &StandardRobot) -> Said {
    let one_joint = |joint: &StandardJoint| !joint.has_spring(form);
    let in_joints = robot.joints.iter().any(one_joint);
    let what = "rotor inertias";
    let (how, note) = match format {
        Format::Urdf if in_joints => (
            How::Approximated,
            "drake:rotor_inertia of the <transmission>, which only Drake reads; elsewhere set the armature \
             of the joint",
        ),
        Format::Urdf => (
            How::Exact,
            "rotor links that turn on the root link, so they have no gyroscopic coupling",
        ),
        Format::Mjcf if in_joints => (How::Exact, "armature of the joint"),
        Format::Mjcf => (
            How::Exact,
            "bodies that turn beside the base, so they have no gyroscopic coupling",
        ),
        Format::Sdf => (
            How::Exact,
            "drake:rotor_inertia of the joint; Gazebo has no rotor inertia and ignores it",
        ),
        Format::Json | Format::C | Format::Rust => (How::Exact, "reflected inertia of each joint"),
    };
    row(what, how, note)
}

fn stiffness(format: Format, form: Form) -> Said {
    let what = "springs";
    let (how, note) = match (format, form) {
        (Format::Json | Format::C | Format::Rust, _) => {
            (How::Exact, "stiffness and damping of each joint")
        }
        (_, Form::Rigid) => (
            How::Dropped,
            "--rigid: motor and link move together, which hides resonances",
        ),
        (Format::Urdf, _) => (
            How::Dropped,
            "URDF has no spring between two joints: a <transmission> of type sprung/Spring holds the \
             values, and no simulator reads it",
        ),
        (Format::Mjcf, _) => (
            How::Exact,
            "stiffness and damping of a fixed tendon from the motor's joint to the link's joint",
        ),
        (Format::Sdf, _) => (
            How::Exact,
            "spring_stiffness and damping of the joint between rotor and link",
        ),
    };
    row(what, how, note)
}

fn viscous(format: Format, form: Form, robot: &StandardRobot) -> Option<Said> {
    let drives = robot.joints.iter().map(|joint| joint.drive);
    if !drives
        .clone()
        .any(|drive| drive.link.viscous > 0.0 || drive.motor.viscous > 0.0)
    {
        return None;
    }
    let moved =
        (robot.joints.iter()).any(|joint| joint.has_spring(form) && joint.drive.link.viscous > 0.0);
    let what = "viscous friction";
    Some(match format {
        Format::Sdf if moved => row(
            what,
            How::Approximated,
            "friction of a link's bearing is added to that of its motor: the joint between rotor and \
             link has only the velocity of the spring",
        ),
        Format::Urdf if drives.clone().any(|drive| drive.is_flexible) && form == Form::Rigid => {
            row(what, How::Exact, "the sum of motor and link, in <dynamics>")
        }
        Format::Urdf | Format::Mjcf | Format::Sdf | Format::Json | Format::C | Format::Rust => {
            row(what, How::Exact, "damping of the joints")
        }
    })
}

fn coulomb(format: Format, robot: &StandardRobot) -> Option<Said> {
    let any =
        |joint: &StandardJoint| joint.drive.link.coulomb > 0.0 || joint.drive.motor.coulomb > 0.0;
    if !robot.joints.iter().any(any) {
        return None;
    }
    let what = "Coulomb friction";
    Some(match format {
        Format::Json | Format::C | Format::Rust => row(what, How::Exact, "magnitude of each joint"),
        Format::Mjcf => row(
            what,
            How::Approximated,
            "frictionloss, a dry friction constraint, in place of the identified tanh(beta v)",
        ),
        Format::Urdf => row(
            what,
            How::Approximated,
            "friction of <dynamics>: dry friction in simulators that support it",
        ),
        Format::Sdf => row(
            what,
            How::Approximated,
            "friction of <dynamics>: dry friction in Gazebo; Drake ignores it",
        ),
    })
}

/// Returns one row for each law that the format does not have, with the values of all joints.
fn others(format: Format, extras: &[Extra]) -> Vec<Said> {
    let mut kinds: Vec<JointParameter> = Vec::new();
    for extra in extras {
        if !kinds.contains(&extra.kind) {
            kinds.push(extra.kind);
        }
    }
    let of = |kind: JointParameter| {
        let of_kind: Vec<&Extra> = extras.iter().filter(|extra| extra.kind == kind).collect();
        let values = of_kind.iter().map(|extra| {
            let value = format!("{} {}", short(extra.value), extra.unit);
            match (of_kind.len(), extra.name.split_once('.')) {
                (2.., Some((joint, _))) => format!("{joint} {value}"),
                _ => value,
            }
        });
        let values = values.collect::<Vec<_>>().join(", ");
        let what = match of_kind.as_slice() {
            [only] => only.name.as_str(),
            _ => kind.name(),
        };
        let (how, why) = reason(kind);
        if format == Format::Json && how == How::Dropped {
            row(what, How::Exact, format!("{values}, under other_laws"))
        } else {
            row(what, how, format!("{values}: {why}"))
        }
    };
    kinds.into_iter().map(of).collect()
}

/// Returns a value with four significant digits.
fn short(value: f64) -> String {
    let size = value.abs();
    if !(1e-4..1e6).contains(&size) {
        return format!("{value:.3e}");
    }
    let digits = (3.0 - size.log10().floor()).max(0.0) as usize;
    format!("{value:.digits$}")
}

fn reason(kind: JointParameter) -> (How, Cow<'static, str>) {
    match kind {
        JointParameter::CubicStiffness => {
            (How::Dropped, "the format has only linear springs".into())
        }
        JointParameter::Hysteresis(_) => (
            How::Dropped,
            "the format has no spring with hysteresis; after a reversal the robot is stiffer"
                .into(),
        ),
        JointParameter::Preload => (
            How::Dropped,
            "it is the zero of the link's encoder, not a property of the robot".into(),
        ),
        JointParameter::Change(..) => (
            How::Dropped,
            "the file holds the friction at the references of the covariates".into(),
        ),
        JointParameter::Friction(side, law) => of_law(side, law),
        JointParameter::RotorInertia
        | JointParameter::Stiffness
        | JointParameter::Damping
        | JointParameter::BackEmf
        | JointParameter::TorqueOffset => (How::Dropped, "the format has no such law".into()),
    }
}

fn of_law(side: Side, law: Law) -> (How, Cow<'static, str>) {
    let side = side.name();
    match law {
        Law::ViscousPositive
        | Law::ViscousNegative
        | Law::CoulombPositive
        | Law::CoulombNegative => (
            How::Approximated,
            "the file holds the mean of both directions".into(),
        ),
        Law::Offset => (
            How::Dropped,
            "a constant torque; subtract it from the command if it is real".into(),
        ),
        Law::Stribeck => (
            How::Dropped,
            format!("the {side} has more friction than the file says at low velocity").into(),
        ),
        Law::Load => (
            How::Dropped,
            format!("the {side} has more friction than the file says under load").into(),
        ),
        Law::Viscous
        | Law::Coulomb
        | Law::Quadratic
        | Law::Presliding1
        | Law::Presliding2
        | Law::Presliding3
        | Law::Presliding4
        | Law::Presliding5
        | Law::Presliding6 => (How::Dropped, "the format has no such law".into()),
    }
}
