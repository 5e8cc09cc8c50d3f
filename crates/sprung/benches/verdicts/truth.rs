//! The laws of the robot that makes the logs, and the true values of its parameters and of the user's
//! model.

use std::collections::BTreeMap;

use sprung_model::{Model, Theta};

use crate::arm::Arm;
use crate::kind::{Fault, Misfit};

/// Velocity at which Stribeck friction has fallen to 1/e, rad/s.
const STRIBECK_RAD_PER_S: f64 = 0.05;

/// Returns the further keys of the joints of the robot that makes the logs.
pub(crate) fn plant_laws(arm: &Arm, fault: Fault) -> Vec<String> {
    let keys = match fault {
        Fault::Misfit(Misfit::Stribeck(_)) => format!(
            "motor_friction = [\"viscous\", \"coulomb\", \"stribeck\"]\n\
             stribeck_velocity_rad_per_s = {STRIBECK_RAD_PER_S}\n"
        ),
        Fault::Misfit(Misfit::Cubic(_)) => "spring = [\"linear\", \"cubic\"]\n".to_owned(),
        _ => String::new(),
    };
    vec![keys; arm.joints()]
}

/// Returns the true values of the robot that makes the logs.
///
/// - `preloads`: torque of each spring at equal readings of its encoders, N·m.
pub(crate) fn plant_truth(arm: &Arm, fault: Fault, preloads: &[f64]) -> BTreeMap<String, f64> {
    let mut values = arm.truth();
    for (i, preload) in preloads.iter().enumerate() {
        values.insert(format!("joint{}.spring_preload", i + 1), *preload);
    }
    for (i, drive) in arm.drives.iter().enumerate() {
        let joint = i + 1;
        if let Fault::Misfit(Misfit::Stribeck(part)) = fault {
            values.insert(
                format!("joint{joint}.motor_stribeck"),
                part * drive.motor_coulomb,
            );
        }
        if let Fault::Misfit(Misfit::Cubic(part)) = fault {
            let cubic = part * drive.stiffness.powi(3) / drive.effort.powi(2);
            values.insert(format!("joint{joint}.cubic_stiffness"), cubic);
        }
    }
    values
}

/// Returns the true values of the parameters that the user's model has, too. Friction that changes
/// has its mean.
pub(crate) fn model_truth(arm: &Arm, fault: Fault, preloads: &[f64]) -> BTreeMap<String, f64> {
    let mut values = plant_truth(arm, Fault::None, preloads);
    if let Fault::Misfit(Misfit::Warming(change)) = fault {
        for (name, value) in &mut values {
            if name.ends_with(".motor_coulomb") {
                *value *= 1.0 + 0.5 * change;
            }
        }
    }
    values
}

/// Returns a parameter vector. Parameters of joints without a value are zero.
pub(crate) fn theta(model: &Model, values: &BTreeMap<String, f64>) -> Theta {
    let mut values = values.clone();
    for parameter in model.parameters().iter().filter(|p| p.joint.is_some()) {
        values.entry(parameter.name.clone()).or_insert(0.0);
    }
    model.theta(&values).expect("the arm has its parameters")
}
