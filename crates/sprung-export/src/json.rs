//! JSON: links and actuators, with ranges for domain randomisation.

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use sprung_core::chain::JointKind;

use super::evidence::{JointEvidence, Known};
use super::exactness::Said;
use super::provenance::Origin;
use super::robot::{StandardJoint, StandardRobot};
use super::standard::Extra;
use crate::finding::GENERATOR;

/// Half the width of a 95 % interval over the standard error.
const HALF_WIDTH: f64 = 1.96;

/// Information of a file beside the robot.
pub(super) struct Contents<'a> {
    pub(super) extras: &'a [Extra],
    pub(super) evidence: &'a [JointEvidence],
    /// Beta of the Coulomb friction of each joint, s/rad (s/m).
    pub(super) sharpness: &'a [f64],
    pub(super) origin: &'a Origin,
    pub(super) said: &'a [Said],
}

#[derive(Serialize)]
struct File<'a> {
    format: u32,
    generator: &'static str,
    seal: String,
    robot: &'a str,
    gravity_m_per_s2: [f64; 3],
    joints: Vec<Joint<'a>>,
    says: &'a [Said],
    origin: &'a Origin,
}

#[derive(Serialize)]
struct Joint<'a> {
    name: &'a str,
    kind: &'static str,
    parent: Option<&'a str>,
    /// Frame of the joint in the frame of its parent.
    origin_m: [f64; 3],
    rotation: [[f64; 3]; 3],
    axis: [f64; 3],
    link: Link<'a>,
    actuator: Ordered,
    mjcf_rigid: Ordered,
}

#[derive(Serialize)]
struct Link<'a> {
    name: &'a str,
    mass_kg: f64,
    center_of_mass_m: [f64; 3],
    inertia_about_center_kgm2: Inertia,
}

#[derive(Serialize)]
struct Inertia {
    ixx: f64,
    ixy: f64,
    iyy: f64,
    ixz: f64,
    iyz: f64,
    izz: f64,
}

/// A value with a range that contains the truth in 95 % of all identifications.
#[derive(Serialize)]
struct Ranged {
    value: f64,
    standard_error: Option<f64>,
    low: f64,
    high: f64,
}

/// A map that keeps its order.
struct Ordered(Vec<(String, Entry)>);

enum Entry {
    Ranged(Option<Ranged>),
    Number(Option<f64>),
    Flag(bool),
    Laws(Vec<(String, f64)>),
}

impl Serialize for Ordered {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (key, entry) in &self.0 {
            match entry {
                Entry::Ranged(ranged) => map.serialize_entry(key, ranged)?,
                Entry::Number(number) => map.serialize_entry(key, number)?,
                Entry::Flag(flag) => map.serialize_entry(key, flag)?,
                Entry::Laws(pairs) => {
                    let laws: std::collections::BTreeMap<_, _> = pairs.iter().cloned().collect();
                    map.serialize_entry(key, &laws)?;
                }
            }
        }
        map.end()
    }
}

/// Returns the file of a robot.
///
/// # Errors
///
/// The error of the serializer: a number is not finite.
pub(super) fn write(robot: &StandardRobot, contents: &Contents<'_>) -> serde_json::Result<String> {
    let joints = robot.joints.iter().enumerate().map(|(i, joint)| {
        let body = joint.inertial();
        let [ixx, ixy, iyy, ixz, iyz, izz] = body.inertia;
        Joint {
            name: &joint.name,
            kind: match joint.place.kind {
                JointKind::Revolute => "revolute",
                JointKind::Prismatic => "prismatic",
            },
            parent: joint.place.parent.map(|at| robot.joints[at].name.as_str()),
            origin_m: joint.place.origin,
            rotation: joint.place.rotation,
            axis: joint.place.axis,
            link: Link {
                name: &joint.link,
                mass_kg: body.mass,
                center_of_mass_m: body.centre,
                inertia_about_center_kgm2: Inertia {
                    ixx,
                    ixy,
                    iyy,
                    ixz,
                    iyz,
                    izz,
                },
            },
            actuator: actuator(joint, i, contents),
            mjcf_rigid: mjcf_rigid(joint, contents.origin),
        }
    });
    let file = File {
        format: 1,
        generator: GENERATOR,
        seal: Origin::mark(),
        robot: &robot.name,
        gravity_m_per_s2: robot.gravity,
        joints: joints.collect(),
        says: contents.said,
        origin: contents.origin,
    };
    Ok(serde_json::to_string_pretty(&file)? + "\n")
}

fn actuator(joint: &StandardJoint, at: usize, contents: &Contents<'_>) -> Ordered {
    let drive = &joint.drive;
    let units = Units::of(joint.place.kind);
    let entry_of = |name: &str, value: f64| {
        let error = error_of(contents.origin, &joint.name, name);
        Entry::Ranged(Some(ranged(value, error)))
    };
    let evidence = contents.evidence.get(at).copied().unwrap_or_default();
    let mut entries = vec![
        ("is_flexible".to_owned(), Entry::Flag(drive.is_flexible)),
        (
            "gear_ratio".to_owned(),
            Entry::Number(Some(drive.gear_ratio)),
        ),
        (
            format!("reflected_inertia_{}", units.inertia),
            entry_of("rotor_inertia", drive.rotor_inertia),
        ),
    ];
    if drive.is_flexible {
        entries.push((
            format!("stiffness_{}", units.stiffness),
            entry_of("stiffness", drive.stiffness),
        ));
        entries.push((
            format!("spring_damping_{}", units.viscous),
            entry_of("spring_damping", drive.damping),
        ));
    }
    for (side, friction) in [("link", drive.link), ("motor", drive.motor)] {
        entries.push((
            format!("{side}_viscous_{}", units.viscous),
            entry_of(&format!("{side}_viscous"), friction.viscous),
        ));
        entries.push((
            format!("{side}_coulomb_{}", units.torque),
            entry_of(&format!("{side}_coulomb"), friction.coulomb),
        ));
    }
    let laws = (contents.extras.iter())
        .filter(|extra| extra.name.starts_with(&format!("{}.", joint.name)))
        .map(|extra| (format!("{} ({})", extra.name, extra.unit), extra.value));
    let delay = evidence.delay.map(
        |Known {
             value,
             standard_error,
         }| {
            let width = HALF_WIDTH * standard_error.unwrap_or(0.0);
            Ranged {
                value,
                standard_error,
                low: value - width,
                high: value + width,
            }
        },
    );
    entries.extend([
        (
            format!("coulomb_sharpness_{}", units.sharpness),
            Entry::Number(contents.sharpness.get(at).copied()),
        ),
        ("other_laws".to_owned(), Entry::Laws(laws.collect())),
        ("torque_delay_s".to_owned(), Entry::Ranged(delay)),
        (
            format!("torque_noise_{}", units.torque),
            Entry::Number(evidence.torque_noise),
        ),
        (
            format!("torque_limit_{}", units.torque),
            Entry::Number(joint.limits.effort),
        ),
    ]);
    Ordered(entries)
}

/// Returns the attributes of one MuJoCo joint for motor and link together.
fn mjcf_rigid(joint: &StandardJoint, origin: &Origin) -> Ordered {
    let drive = &joint.drive;
    let sum = |name: &str, link: f64, motor: f64| {
        let errors = ["link", "motor"]
            .map(|side| error_of(origin, &joint.name, &format!("{side}_{name}")).unwrap_or(0.0));
        ranged(link + motor, Some(errors[0].hypot(errors[1])))
    };
    let armature = ranged(
        drive.rotor_inertia,
        error_of(origin, &joint.name, "rotor_inertia"),
    );
    Ordered(vec![
        ("armature".to_owned(), Entry::Ranged(Some(armature))),
        (
            "damping".to_owned(),
            Entry::Ranged(Some(sum(
                "viscous",
                drive.link.viscous,
                drive.motor.viscous,
            ))),
        ),
        (
            "frictionloss".to_owned(),
            Entry::Ranged(Some(sum(
                "coulomb",
                drive.link.coulomb,
                drive.motor.coulomb,
            ))),
        ),
    ])
}

fn error_of(origin: &Origin, joint: &str, name: &str) -> Option<f64> {
    let name = format!("{joint}.{name}");
    let found = origin.values.iter().find(|value| value.name == name)?;
    found.standard_error
}

/// Returns a range of a value that cannot be negative.
fn ranged(value: f64, standard_error: Option<f64>) -> Ranged {
    let width = HALF_WIDTH * standard_error.unwrap_or(0.0);
    Ranged {
        value,
        standard_error,
        low: (value - width).max(0.0),
        high: value + width,
    }
}

/// Suffixes of keys.
struct Units {
    inertia: &'static str,
    stiffness: &'static str,
    viscous: &'static str,
    torque: &'static str,
    sharpness: &'static str,
}

impl Units {
    const fn of(kind: JointKind) -> Self {
        match kind {
            JointKind::Revolute => Self {
                inertia: "kgm2",
                stiffness: "nm_per_rad",
                viscous: "nms_per_rad",
                torque: "nm",
                sharpness: "s_per_rad",
            },
            JointKind::Prismatic => Self {
                inertia: "kg",
                stiffness: "n_per_m",
                viscous: "ns_per_m",
                torque: "n",
                sharpness: "s_per_m",
            },
        }
    }
}
