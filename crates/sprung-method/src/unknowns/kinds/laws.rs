//! Laws with one coefficient that a joint may have beyond those of its description. They compete with the other causes.

use super::catalogued::Catalogued;
use crate::unknowns::unknown::{Effect, JointSample, JointScales, Kind, Law, Place, Unknown};

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

fn saturation(at: &JointSample, of: &JointScales) -> f64 {
    at.torque.powi(3) / of.torque.powi(2)
}

fn motor_offset(_: &JointSample, of: &JointScales) -> f64 {
    of.torque
}

fn link_coulomb(at: &JointSample, of: &JointScales) -> f64 {
    (of.sharpness * at.velocities[1]).tanh()
}

/// A law: its name, its torque, whether the torque acts between motor and link, its usual coefficient (infinite if it has a
/// unit), and whether only positive coefficients exist.
const LAWS: [(&str, Law, bool, f64, bool); 10] = [
    ("spring damping", damping, true, f64::INFINITY, true),
    ("cubic spring", cubic, true, f64::INFINITY, false),
    ("quadratic friction", quadratic, false, f64::INFINITY, true),
    ("slow friction", slow, false, f64::INFINITY, true),
    ("Stribeck friction", stribeck, false, f64::INFINITY, true),
    ("load friction", load, false, 0.05, true),
    ("saturation", saturation, false, 0.05, true),
    ("friction offset", motor_offset, false, f64::INFINITY, false),
    (
        "motor Coulomb friction",
        coulomb,
        false,
        f64::INFINITY,
        true,
    ),
    (
        "link Coulomb friction",
        link_coulomb,
        false,
        f64::INFINITY,
        true,
    ),
];

pub(super) fn list(of: &Catalogued<'_>) -> Vec<Unknown> {
    let mut all = Vec::new();
    for (joint, name) in of.names.iter().enumerate() {
        for (law, torque, is_of_spring, scale, is_positive) in LAWS {
            if is_of_spring && !of.is_flexible(joint) {
                continue;
            }
            all.push(Unknown {
                id: format!("{law} {name}"),
                kind: Kind::Law,
                place: Place::Joint(joint),
                scale,
                expected: 0.0,
                is_rare: false,
                is_positive,
                unit: "",
                effect: Effect::Law {
                    torque,
                    is_of_spring,
                },
            });
        }
    }
    all
}
