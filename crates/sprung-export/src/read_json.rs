//! Reads an exported JSON again.

use serde_json::Value;

use super::mechanism::{Mechanism, MechanismJoint, Spring};

/// Returns the mechanism of a JSON file. The motor of a flexible joint is a separate joint on the base.
///
/// # Errors
///
/// The reason why the file cannot be read.
pub(super) fn read(text: &str) -> Result<Mechanism, String> {
    let file: Value = serde_json::from_str(text).map_err(|error| error.to_string())?;
    let mut mechanism = Mechanism {
        gravity: Some(vector(&file["gravity_m_per_s2"])?),
        ..Mechanism::default()
    };
    let joints = file["joints"].as_array().ok_or("it has no joints")?;
    for joint in joints {
        let name = joint["name"].as_str().ok_or("a joint has no name")?;
        let parent = match joint["parent"].as_str() {
            Some(parent) => {
                let at = mechanism.joint(parent);
                Some(at.ok_or_else(|| format!("{name} comes before its parent"))?)
            }
            None => None,
        };
        let rows = joint["rotation"]
            .as_array()
            .ok_or("a joint has no rotation")?;
        let [x, y, z] = rows.as_slice() else {
            return Err("a rotation does not have three rows".to_owned());
        };
        let body = &joint["link"];
        let about = &body["inertia_about_center_kgm2"];
        let of = |key: &str| number(&about[key]);
        let (xy, xz, yz) = (of("ixy")?, of("ixz")?, of("iyz")?);
        let actuator = &joint["actuator"];
        let flexible = actuator["is_flexible"] == true;
        let slides = joint["kind"] == "prismatic";
        let of = |start: &str| value_of(actuator, start);
        let (rotor, link, motor) = (
            of("reflected_inertia_")?,
            [of("link_viscous_")?, of("link_coulomb_")?],
            [of("motor_viscous_")?, of("motor_coulomb_")?],
        );
        let mut mechanism_joint = MechanismJoint {
            name: name.to_owned(),
            parent,
            rotation: [vector(x)?, vector(y)?, vector(z)?],
            origin: vector(&joint["origin_m"])?,
            axis: vector(&joint["axis"])?,
            slides,
            mass: number(&body["mass_kg"])?,
            centre: vector(&body["center_of_mass_m"])?,
            inertia: [
                [number(&about["ixx"])?, xy, xz],
                [xy, number(&about["iyy"])?, yz],
                [xz, yz, number(&about["izz"])?],
            ],
            armature: 0.0,
            damping: link[0],
            coulomb: link[1],
        };
        if !flexible {
            mechanism_joint.armature = rotor;
            mechanism_joint.damping += motor[0];
            mechanism_joint.coulomb += motor[1];
        }
        mechanism.joints.push(mechanism_joint);
    }
    for joint in joints {
        let actuator = &joint["actuator"];
        if actuator["is_flexible"] != true {
            continue;
        }
        let name = joint["name"].as_str().unwrap_or_default();
        let link = mechanism.joint(name).ok_or("a joint has no name")?;
        let motor = mechanism.joints.len();
        mechanism.springs.push(Spring {
            coefficients: vec![(motor, 1.0), (link, -1.0)],
            stiffness: value_of(actuator, "stiffness_")?,
            damping: value_of(actuator, "spring_damping_")?,
        });
        mechanism.joints.push(MechanismJoint {
            name: format!("{name}_motor"),
            armature: value_of(actuator, "reflected_inertia_")?,
            damping: value_of(actuator, "motor_viscous_")?,
            coulomb: value_of(actuator, "motor_coulomb_")?,
            ..MechanismJoint::default()
        });
    }
    Ok(mechanism)
}

/// Returns the value of the key that begins so; its end is the unit.
fn value_of(actuator: &Value, start: &str) -> Result<f64, String> {
    let mut entries = actuator.as_object().into_iter().flatten();
    let found = entries.find(|(key, _)| key.starts_with(start));
    let (_, entry) = found.ok_or_else(|| format!("an actuator has no {start}"))?;
    number(&entry["value"])
}

fn number(value: &Value) -> Result<f64, String> {
    value
        .as_f64()
        .ok_or_else(|| format!("{value} is not a number"))
}

fn vector(value: &Value) -> Result<[f64; 3], String> {
    let parts = value.as_array().map(Vec::as_slice);
    match parts {
        Some([x, y, z]) => Ok([number(x)?, number(y)?, number(z)?]),
        _ => Err(format!("{value} is not three numbers")),
    }
}
