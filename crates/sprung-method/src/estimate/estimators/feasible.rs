//! Start values with which a robot can be simulated.

use sprung_core::parameters::JointParameter;

use crate::model::{Model, ModelError, Parameter, Theta};

/// Fraction of the nominal value that replaces an impossible value.
const NOMINAL_SHARE: f64 = 0.2;

/// Inertia and stiffness without a nominal value, kg·m² (kg) and N·m/rad (N/m).
const UNKNOWN_INERTIA: f64 = 1e-3;

/// Stiffness without a nominal value, N·m/rad (N/m); the search moves it by decades.
const UNKNOWN_STIFFNESS: f64 = 10.0;

/// Maximum number of steps by which the link parameters move towards feasible ones.
const MAX_MOVES: usize = 12;

/// Returns parameters near the linear ones with which a robot can be simulated.
///
/// Rotor inertias and stiffnesses that are not positive become a fifth of the nominal ones.
/// Negative friction becomes zero. Link parameters move towards the nominal ones until the mass
/// matrix is positive definite.
///
/// # Errors
///
/// [`ModelError::MassMatrix`] if the search finds no such parameters.
pub(in crate::estimate) fn feasible(model: &Model, linear: &[f64]) -> Result<Theta, ModelError> {
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
    for _ in 0..MAX_MOVES {
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
    Ok(theta)
}

/// Returns the replacement for an impossible value of a joint's parameter.
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
        // Negative friction would feed energy in.
        _ if value < 0.0 && parameter.is_friction() => Some(0.0),
        JointParameter::RotorInertia
        | JointParameter::CubicStiffness
        | JointParameter::Damping
        | JointParameter::Hysteresis(_)
        | JointParameter::Preload
        | JointParameter::Friction(..)
        | JointParameter::Change(..)
        | JointParameter::BackEmf
        | JointParameter::TorqueOffset => None,
    }
}

/// Returns a link parameter nearer to its nominal value. Without a nominal value, the coupling of
/// two links becomes smaller, because only a large coupling is impossible.
fn towards(parameter: &Parameter, from: f64, now: f64) -> f64 {
    match parameter.nominal {
        Some(nominal) => now + (nominal - from) / MAX_MOVES as f64,
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
        assert_eq!(feasible(&model, &theta).unwrap(), theta);

        for (name, value) in [
            ("a.stiffness", -4.6),
            ("b.stiffness", -1.0),
            ("a.rotor_inertia", 0.0),
            ("b.link_viscous", -0.1),
            // A coupling this large is impossible for two bodies.
            ("link2.coupling", 0.4),
        ] {
            theta[at(name)] = value;
        }
        assert!(model.check_inertias(&theta).is_err());
        let found = feasible(&model, &theta).unwrap();
        let value = |name: &str| found[at(name)];
        assert!((value("a.stiffness") - 1.8).abs() < 1e-12);
        assert!(value("b.stiffness") > 0.0);
        assert!((value("a.rotor_inertia") - 0.012).abs() < 1e-12);
        assert!(value("b.link_viscous").abs() < 1e-15);
        assert!(model.check_inertias(&found).is_ok());
        assert!(value("link2.coupling") < 0.4);
        assert_eq!(
            value("a.link_coulomb").to_bits(),
            theta[at("a.link_coulomb")].to_bits()
        );
    }
}
