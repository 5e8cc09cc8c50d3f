//! A start that can be simulated.

use sprung_core::parameters::JointParameter;

use crate::model::{Model, ModelError, Parameter, Theta};

/// Part of the nominal value that stands for an impossible one.
const NOMINAL_SHARE: f64 = 0.2;

/// Inertia and stiffness where nothing is known of them, kg·m² (kg) and N·m/rad
/// (N/m).
const UNKNOWN_INERTIA: f64 = 1e-3;
const UNKNOWN_STIFFNESS: f64 = 10.0;

/// How many times the links' parameters are moved towards those of a body.
const MOVES: usize = 12;

/// Returns parameters near the linear ones with which a robot can move, and
/// the indices of those that were changed.
///
/// Rotor inertias and stiffnesses below zero become a fifth of the nominal
/// ones, friction below zero becomes zero, link parameters are moved towards
/// the nominal ones until the mass matrix is positive.
///
/// # Errors
///
/// [`ModelError::MassMatrix`] if none is found.
pub(in crate::estimate) fn feasible(
    model: &Model,
    linear: &[f64],
) -> Result<(Theta, Vec<usize>), ModelError> {
    let mut theta = linear.to_vec();
    for (value, parameter) in theta.iter_mut().zip(model.parameters()) {
        if parameter.fixed.is_some() {
            continue;
        }
        if let Some(other) = instead(model, parameter, *value) {
            *value = other;
        }
    }
    let from = theta.clone();
    for _ in 0..MOVES {
        if model.check_inertias(&theta).is_ok() {
            break;
        }
        for (i, parameter) in model.parameters().iter().enumerate() {
            if parameter.joint.is_none() && parameter.fixed.is_none() {
                theta[i] = towards(parameter, from[i], theta[i]);
            }
        }
    }
    model.check_inertias(&theta)?;
    let changed = (0..theta.len())
        .filter(|&i| (theta[i] - linear[i]).abs() > 0.0)
        .collect();
    Ok((theta, changed))
}

/// Returns what stands for the value of a joint's parameter that no robot has.
fn instead(model: &Model, parameter: &Parameter, value: f64) -> Option<f64> {
    let (kind, joint) = parameter.joint?;
    let nominal = |some: f64| {
        let known = parameter.nominal.filter(|v| *v > 0.0);
        known.map_or(some, |v| NOMINAL_SHARE * v)
    };
    match kind {
        _ if value > 0.0 => None,
        JointParameter::RotorInertia if model.is_flexible(joint) => Some(nominal(UNKNOWN_INERTIA)),
        JointParameter::Stiffness => Some(nominal(UNKNOWN_STIFFNESS)),
        // Friction that feeds energy in.
        _ if value < 0.0 && parameter.is_friction() => Some(0.0),
        _ => None,
    }
}

/// Returns a link parameter nearer to its nominal value, or smaller if it is
/// the coupling of two links, which only must not be too large.
fn towards(parameter: &Parameter, from: f64, now: f64) -> f64 {
    match parameter.nominal {
        Some(nominal) => now + (nominal - from) / MOVES as f64,
        None if parameter.name.ends_with(".coupling") => 0.8 * now,
        None => now,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::{no_files, read};

    const ROBOT: &str = r#"
        format = 1
        [robot]
        name = "arm"
        kinematics = "planar-2r"
        [robot.nominal]
        "link1.inertia_total" = 0.19
        "link2.coupling" = 0.016
        "link2.inertia" = 0.011
        [[robot.joint]]
        name = "a"
        nominal = { stiffness = 9.0, rotor_inertia = 0.06 }
        [[robot.joint]]
        name = "b"
    "#;

    #[test]
    fn impossible_values_are_replaced() {
        let experiment = read("arm", ROBOT, &[], &mut no_files).unwrap();
        let model = Model::new(&experiment).unwrap();
        let at = |name: &str| model.index_of(name).unwrap();
        let mut theta = vec![1.0; model.parameters().len()];
        for (name, value) in [
            ("link1.inertia_total", 0.2),
            ("link2.coupling", 0.017),
            ("link2.inertia", 0.013),
        ] {
            theta[at(name)] = value;
        }
        let (same, changed) = feasible(&model, &theta).unwrap();
        assert_eq!((&same, changed), (&theta, vec![]));

        for (name, value) in [
            ("a.stiffness", -4.6),
            ("b.stiffness", -1.0),
            ("a.rotor_inertia", 0.0),
            ("b.link_viscous", -0.1),
            // No bodies are coupled that much.
            ("link2.coupling", 0.4),
        ] {
            theta[at(name)] = value;
        }
        assert!(model.check_inertias(&theta).is_err());
        let (found, changed) = feasible(&model, &theta).unwrap();
        let value = |name: &str| found[at(name)];
        assert!((value("a.stiffness") - 1.8).abs() < 1e-12);
        assert!(value("b.stiffness") > 0.0);
        assert!((value("a.rotor_inertia") - 0.012).abs() < 1e-12);
        assert!(value("b.link_viscous").abs() < 1e-15);
        assert!(model.check_inertias(&found).is_ok());
        assert!(
            changed.contains(&at("link2.coupling")) && !changed.contains(&at("a.link_coulomb"))
        );
    }
}
