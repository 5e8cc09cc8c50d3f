//! Laws with one coefficient that a joint may have beyond those of its description. They compete with the other causes.

use super::catalogued::Catalogued;
use super::words::{falls, or_else};
use crate::finding::{Finding, Severity};
use crate::unknowns::found::Telling;
use crate::unknowns::unknown::{Effect, JointSample, JointScales, Kind, Law, Place, Unknown};

/// Code of the finding that laws would predict the log better.
pub(crate) const LAWS_MISSING: &str = "laws-missing";

/// Part of a joint's torque below which a constant torque matters to nobody.
const LEAST_SHARE: f64 = 0.02;

/// Velocity of the slow curve, in root mean squares of the velocity.
const SLOW: f64 = 0.2;

fn coulomb(at: &JointSample, of: &JointScales) -> f64 {
    (of.sharpness * at.velocities[0]).tanh()
}

fn damping(at: &JointSample, _: &JointScales) -> f64 {
    at.velocities[0] - at.velocities[1]
}

fn cubic(at: &JointSample, of: &JointScales) -> f64 {
    at.deflection.powi(3) / of.deflection.powi(2)
}

fn quadratic(at: &JointSample, of: &JointScales) -> f64 {
    at.velocities[0] * at.velocities[0].abs() / of.velocity
}

fn slow(at: &JointSample, of: &JointScales) -> f64 {
    (at.velocities[0] / (SLOW * of.velocity)).tanh()
}

fn stribeck(at: &JointSample, of: &JointScales) -> f64 {
    let x = at.velocities[0] / (SLOW * of.velocity);
    coulomb(at, of) * (-x * x).exp()
}

fn load(at: &JointSample, of: &JointScales) -> f64 {
    at.load.abs() * coulomb(at, of)
}

fn motor_offset(_: &JointSample, _: &JointScales) -> f64 {
    1.0
}

fn link_coulomb(at: &JointSample, of: &JointScales) -> f64 {
    (of.sharpness * at.velocities[1]).tanh()
}

/// A law with one coefficient.
struct OneLaw {
    name: &'static str,
    torque: Law,
    /// Whether the torque acts between motor and link.
    is_of_spring: bool,
    /// Usual coefficient; infinite if it has a unit.
    scale: f64,
    is_positive: bool,
    /// Whether the torque is constant, as that of one count of an encoder.
    is_constant: bool,
    /// Units of the coefficient of a joint that turns and of one that slides.
    units: [&'static str; 2],
}

impl OneLaw {
    const fn of_friction(name: &'static str, torque: Law, units: [&'static str; 2]) -> Self {
        Self {
            name,
            torque,
            is_of_spring: false,
            scale: f64::INFINITY,
            is_positive: true,
            is_constant: false,
            units,
        }
    }

    const fn of_spring(
        name: &'static str,
        torque: Law,
        is_positive: bool,
        units: [&'static str; 2],
    ) -> Self {
        Self {
            is_of_spring: true,
            is_positive,
            ..Self::of_friction(name, torque, units)
        }
    }
}

const TORQUE: [&str; 2] = ["N·m", "N"];
const OVER_VELOCITY: [&str; 2] = ["N·m·s/rad", "N·s/m"];
const OVER_ANGLE: [&str; 2] = ["N·m/rad", "N/m"];

const LAWS: [OneLaw; 9] = [
    OneLaw::of_spring("spring damping", damping, true, OVER_VELOCITY),
    OneLaw::of_spring("cubic spring", cubic, false, OVER_ANGLE),
    OneLaw::of_friction("quadratic friction", quadratic, OVER_VELOCITY),
    OneLaw::of_friction("slow friction", slow, TORQUE),
    OneLaw::of_friction("Stribeck friction", stribeck, TORQUE),
    OneLaw {
        scale: 0.05,
        ..OneLaw::of_friction("load friction", load, ["", ""])
    },
    OneLaw {
        is_positive: false,
        is_constant: true,
        ..OneLaw::of_friction("friction offset", motor_offset, TORQUE)
    },
    OneLaw::of_friction("motor Coulomb friction", coulomb, TORQUE),
    OneLaw::of_friction("link Coulomb friction", link_coulomb, TORQUE),
];

pub(super) fn list(of: &Catalogued<'_>) -> Vec<Unknown> {
    let of_joint = |(joint, name): (usize, &String)| {
        let laws = LAWS
            .iter()
            .filter(move |law| !law.is_of_spring || of.is_flexible(joint));
        let unknown = |law: &OneLaw| Unknown {
            id: format!("{} {name}", law.name),
            kind: Kind::Law,
            place: Place::Joint(joint),
            scale: law.scale,
            expected: 0.0,
            least: if law.is_constant {
                LEAST_SHARE.max(of.count_share(joint))
            } else {
                0.0
            },
            is_rare: false,
            is_positive: law.is_positive,
            unit: law.units[usize::from(!of.channels.turns[joint])],
            effect: Effect::Law {
                torque: law.torque,
                is_of_spring: law.is_of_spring,
            },
        };
        laws.map(unknown).collect::<Vec<Unknown>>()
    };
    of.names.iter().enumerate().flat_map(of_joint).collect()
}

/// Finding: the description lacks a law.
pub(super) fn finding(of: &Telling<'_>) -> Finding {
    let law = of.found.id.strip_suffix(of.joint).unwrap_or(&of.found.id);
    Finding::new(
        Severity::Info,
        LAWS_MISSING,
        format!(
            "{}: the description lacks a law that looks like {}: with it {}{}",
            of.joint,
            law.trim_end(),
            falls(of),
            or_else(of)
        ),
        "nothing: sprung identify adds laws that predict better (laws = \"auto\" in [identify]); a law in the joint keeps it",
    )
    .seen(of.file, of.columns.first().copied().unwrap_or_default(), of.found.value, of.found.unit)
}
