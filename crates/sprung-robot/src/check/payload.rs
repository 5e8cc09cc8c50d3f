//! Checks of the payloads of logs.

use super::fault::{Fault, fault, refused};
use crate::capabilities::{Feature, Task, payload_feature, refuse, together};
use crate::numbers::Shown;
use crate::payload::Payload;
use crate::types::ExperimentFile;
use crate::window::FilePart;

/// Checks payloads: possible bodies, on a robot for which they are identifiable.
pub(super) fn check_payloads(file: &ExperimentFile) -> Result<(), Fault> {
    let of_robot = |part: &FilePart, path: &[&str], what: String| {
        Err(fault(
            path,
            format!("the payload of {}: {what}", part.path.display()),
        ))
    };
    let parts = || (file.log.iter()).flat_map(|log| log.file.iter().flatten());
    let of_runs = (file.validate.iter().filter_map(|run| run.log.as_ref()))
        .flat_map(|log| log.file.iter().flatten());
    let is_servo = file.robot.joint.iter().any(|joint| joint.servo.is_some());
    let others = [
        (Feature::Servo, is_servo),
        (
            Feature::ClosedForm,
            !is_servo && file.robot.kinematics.is_some(),
        ),
    ];
    let all = (parts().map(|part| (part, &["log", "file"][..])))
        .chain(of_runs.clone().map(|part| (part, &["validate"][..])));
    for (part, path) in all {
        let Some((payload, (feature, name))) = part.payload.as_ref().zip(payload_feature(part))
        else {
            continue;
        };
        if let Err(what) = possible(payload) {
            return of_robot(part, path, what);
        }
        for (other, _) in others.into_iter().filter(|(_, has)| *has) {
            together(feature, &name, other).map_err(|reason| refused(path, &reason))?;
        }
    }
    // The estimator of servos is another one.
    let loaded = parts().filter(|_| !is_servo).filter_map(payload_feature);
    for (feature, name) in loaded {
        for &estimator in file.identify.estimators(file.robot.has_springs()) {
            refuse(feature, &name, Task::Identify(estimator))
                .map_err(|reason| refused(&["identify", "estimator"], &reason))?;
        }
    }
    for (feature, name) in of_runs.filter_map(payload_feature) {
        refuse(feature, &name, Task::Validate).map_err(|reason| refused(&["validate"], &reason))?;
    }
    let is_unknown = |part: &FilePart| {
        part.payload
            .as_ref()
            .is_some_and(|payload| payload.mass_kg.is_none())
    };
    if let Some(part) = parts().next().filter(|_| parts().all(is_unknown)) {
        return of_robot(
            part,
            &["log", "file"],
            "every log has an unknown payload, so nothing separates it from the link; add a log \
             without payload, or give mass_kg and com_m"
                .to_owned(),
        );
    }
    Ok(())
}

/// Checks that a body can have the parameters.
pub(super) fn possible(payload: &Payload) -> Result<(), String> {
    let Some(mass) = payload.mass_kg else {
        return match (payload.com_m, payload.inertia_kg_m2) {
            (None, None) => Ok(()),
            _ => Err(
                "com_m and inertia_kg_m2 need mass_kg; add it, or remove them, and sprung estimates \
                 the payload"
                    .to_owned(),
            ),
        };
    };
    if !(mass.is_finite() && mass > 0.0) {
        return Err(format!("mass_kg = {} must be positive", Shown(mass)));
    }
    let Some(com) = payload.com_m else {
        return Err(
            "mass_kg needs com_m; add the centre of mass in the frame of the joint".to_owned(),
        );
    };
    if let Some(value) = com.iter().find(|value| !value.is_finite()) {
        return Err(format!("com_m contains {value}; it must be finite"));
    }
    let [xx, xy, xz, yy, yz, zz] = payload.inertia_kg_m2.unwrap_or_default();
    let trace = xx + yy + zz;
    let minors = [
        xx,
        yy,
        zz,
        xx * yy - xy * xy,
        xx * zz - xz * xz,
        yy * zz - yz * yz,
    ];
    let triangle = [xx, yy, zz]
        .iter()
        .all(|one| 2.0 * one <= trace * (1.0 + 1e-9));
    if minors.iter().all(|minor| *minor >= 0.0) && triangle {
        Ok(())
    } else {
        Err("no body has inertia_kg_m2; give xx, xy, xz, yy, yz, zz about the centre of mass, in the \
             axes of the joint"
            .to_owned())
    }
}
