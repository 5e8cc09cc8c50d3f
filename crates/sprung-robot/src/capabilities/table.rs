//! The table of what works with what.

use super::feature::Feature;
use super::task::Task;
use super::{NotSupported, Refusal};

/// The answer of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Answer {
    /// It works.
    Works,
    /// It is refused.
    Refused(Reason),
}

/// Why something does not work, and the remedy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Reason {
    pub(super) code: &'static str,
    pub(super) why: &'static str,
    pub(super) instead: &'static str,
}

use Answer::{Refused, Works};

const fn reason(code: &'static str, why: &'static str, instead: &'static str) -> Reason {
    Reason { code, why, instead }
}

/// Returns a feature's row of the table, in the order of [`Task::ALL`].
#[rustfmt::skip]
pub(super) const fn row(feature: Feature) -> [Answer; Task::COUNT] {
    const GYROSCOPE: Answer = Refused(reason(
        "gyroscope-needs-least-squares",
        "only least squares filters the constant deflection away that a gyroscope does not show",
        "set estimator = \"least-squares\", or use a link encoder",
    ));
    const ACCELEROMETER: Answer = Refused(reason(
        "accelerometer-needs-least-squares",
        "only least squares filters the constant deflection away that an accelerometer does not show",
        "set estimator = \"least-squares\", or use a link encoder",
    ));
    const SERVO: Answer = Refused(reason(
        "servo-without-torque",
        "its log has targets and no torque",
        "use check, identify and simulate",
    ));
    const VALIDATED: Answer = Refused(reason(
        "payload-not-validated",
        "a prediction needs the mass of the payload",
        "give mass_kg and com_m of the payload, or use a log without it",
    ));
    const LOADED: Answer = Refused(reason(
        "payload-not-subtracted",
        "it takes the load of the log for a part of the robot",
        "set estimator = \"prediction-error\" or \"least-squares\", or leave the log out",
    ));
    const COUPLED: Answer = Refused(reason(
        "coupling-not-exported",
        "no format of export can say a transmission_matrix",
        "export the robot without it only if the coupling does not matter",
    ));
    const ALL: [Answer; Task::COUNT] = [Works; Task::COUNT];
    match feature {
        //                        check  least   lsff       prediction   validate   simulate compare export   code     dynamics
        //                               squares            error
        Feature::Gyroscope     => [Works, Works, GYROSCOPE, GYROSCOPE,   Works,     Works,   Works,  Works,   Works,   Works],
        Feature::Accelerometer => [Works, Works, ACCELEROMETER, ACCELEROMETER, Works, Works, Works,  Works,   Works,   Works],
        Feature::Servo         => [Works, Works, Works,     Works,       SERVO,     Works,   SERVO,  SERVO,   SERVO,   SERVO],
        Feature::KnownPayload  => [Works, Works, LOADED,    Works,       Works,     Works,   Works,  Works,   Works,   Works],
        Feature::UnknownPayload => [Works, Works, Works,    Works,       VALIDATED, Works,   Works,  Works,   Works,   Works],
        Feature::CoupledTransmission
                               => [Works, Works, Works,     Works,       Works,     Works,   Works,  COUPLED, COUPLED, Works],
        Feature::LinkEncoder
        | Feature::DeflectionSensor
        | Feature::TorqueSensor
        | Feature::TorqueSensorAlone
        | Feature::MotorOnly
        | Feature::ClosedForm
        | Feature::SpringsFromMotor
        | Feature::SeveralJoints
        | Feature::FlexibleJoint
        | Feature::SlidingJoint
        | Feature::OpenColumns
        | Feature::Covariates
        | Feature::CubicSpring
        | Feature::LoadFriction => ALL,
    }
}

/// Two features that do not go together.
pub(super) struct Pair {
    pub(super) one: Feature,
    pub(super) other: Feature,
    pub(super) reason: Reason,
}

const fn pair(
    one: Feature,
    other: Feature,
    code: &'static str,
    why: &'static str,
    instead: &'static str,
) -> Pair {
    let reason = reason(code, why, instead);
    Pair { one, other, reason }
}

/// All pairs of features that do not go together.
pub(super) const PAIRS: [Pair; 21] = [
    pair(
        Feature::Gyroscope,
        Feature::LinkEncoder,
        "gyroscope-and-link-position",
        "both tell the motion of the link beside its motor",
        "keep the gyroscopes or the link positions",
    ),
    pair(
        Feature::Gyroscope,
        Feature::DeflectionSensor,
        "gyroscope-and-link-position",
        "both tell the motion of the link beside its motor",
        "keep the gyroscopes or the link deflections",
    ),
    pair(
        Feature::Gyroscope,
        Feature::TorqueSensorAlone,
        "gyroscope-and-torque-sensor",
        "both tell the motion of the link beside its motor",
        "keep the gyroscopes or the joint torques",
    ),
    pair(
        Feature::Gyroscope,
        Feature::CubicSpring,
        "gyroscope-and-deflection",
        "a gyroscope shows only changes of the deflection, so it cannot be estimated",
        "remove it, or use a link encoder",
    ),
    pair(
        Feature::Gyroscope,
        Feature::LoadFriction,
        "gyroscope-and-deflection",
        "a gyroscope shows only changes of the deflection, so it cannot be estimated",
        "remove it, or use a link encoder",
    ),
    pair(
        Feature::Accelerometer,
        Feature::LinkEncoder,
        "accelerometer-and-link-position",
        "both tell the motion of the link beside its motor",
        "keep the accelerometers or the link positions",
    ),
    pair(
        Feature::Accelerometer,
        Feature::DeflectionSensor,
        "accelerometer-and-link-position",
        "both tell the motion of the link beside its motor",
        "keep the accelerometers or the link deflections",
    ),
    pair(
        Feature::Accelerometer,
        Feature::TorqueSensorAlone,
        "accelerometer-and-torque-sensor",
        "both tell the motion of the link beside its motor",
        "keep the accelerometers or the joint torques",
    ),
    pair(
        Feature::Accelerometer,
        Feature::CubicSpring,
        "accelerometer-and-deflection",
        "an accelerometer shows only changes of the deflection, so it cannot be estimated",
        "remove it, or use a link encoder",
    ),
    pair(
        Feature::Accelerometer,
        Feature::LoadFriction,
        "accelerometer-and-deflection",
        "an accelerometer shows only changes of the deflection, so it cannot be estimated",
        "remove it, or use a link encoder",
    ),
    pair(
        Feature::Gyroscope,
        Feature::Accelerometer,
        "gyroscope-and-accelerometer",
        "both tell the motion of the link beside its motor",
        "keep the gyroscopes or the accelerometers",
    ),
    pair(
        Feature::Servo,
        Feature::SeveralJoints,
        "servo-of-several-joints",
        "sprung identifies one servo at a time",
        "write an experiment file for each servo, with a pendulum on it",
    ),
    pair(
        Feature::Servo,
        Feature::FlexibleJoint,
        "servo-rigid-revolute",
        "a servo is a rigid revolute joint",
        "add transmission = \"rigid\"",
    ),
    pair(
        Feature::Servo,
        Feature::SlidingJoint,
        "servo-rigid-revolute",
        "a servo is a rigid revolute joint",
        "describe a joint that turns",
    ),
    pair(
        Feature::Servo,
        Feature::Covariates,
        "servo-and-covariates",
        "the friction of a servo has no covariates",
        "remove friction_covariates",
    ),
    pair(
        Feature::Servo,
        Feature::OpenColumns,
        "servo-and-open-columns",
        "sprung estimates no signs and gains of a servo's columns, and its logs have no delays",
        "give a known sign or gain, and target and position of the same instant",
    ),
    pair(
        Feature::UnknownPayload,
        Feature::Servo,
        "servo-needs-known-mass",
        "the masses give the scale of a servo's torques",
        "add mass_kg and com_m",
    ),
    pair(
        Feature::KnownPayload,
        Feature::ClosedForm,
        "payload-needs-bodies",
        "a robot in closed form has no bodies that carry a payload",
        "describe it by urdf or dh_modified",
    ),
    pair(
        Feature::UnknownPayload,
        Feature::ClosedForm,
        "payload-needs-bodies",
        "a robot in closed form has no bodies that carry a payload",
        "describe it by urdf or dh_modified",
    ),
    pair(
        Feature::FlexibleJoint,
        Feature::SpringsFromMotor,
        "springs-from-motor-alone",
        "it finds springs of robots whose motors alone are measured",
        "write transmission = \"rigid\" in its block if it has no link encoder, or remove springs_from_motor",
    ),
    pair(
        Feature::CoupledTransmission,
        Feature::SpringsFromMotor,
        "springs-from-motor-coupled",
        "a vibration of one motor then moves several joints",
        "remove springs_from_motor",
    ),
];

/// Refuses a task that does not work with a feature.
///
/// - `of`: the joint, the log or the robot that has the feature.
///
/// # Errors
///
/// [`NotSupported`] if the table refuses it.
pub fn refuse(feature: Feature, of: &str, task: Task) -> Result<(), NotSupported> {
    match row(feature)[task.place()] {
        Works => Ok(()),
        Refused(reason) => Err(refusal(
            feature,
            of,
            format!(", and {} does not work with it", task.name()),
            reason,
        )),
    }
}

/// Refuses two features that do not go together.
///
/// - `of`: the joint, the log or the robot that has both.
///
/// # Errors
///
/// [`NotSupported`] if the table refuses them.
pub(crate) fn together(one: Feature, of: &str, other: Feature) -> Result<(), NotSupported> {
    let is_pair = |pair: &&Pair| pair.one == one && pair.other == other;
    match PAIRS.iter().find(is_pair) {
        None => Ok(()),
        Some(pair) => Err(refusal(
            one,
            of,
            format!(", which excludes {}", other.noun()),
            pair.reason,
        )),
    }
}

fn refusal(feature: Feature, of: &str, with: String, reason: Reason) -> NotSupported {
    NotSupported(Box::new(Refusal {
        code: reason.code,
        of: of.to_owned(),
        has: feature.has(),
        with,
        why: reason.why,
        instead: reason.instead,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_task_and_every_feature_stands_in_its_list() {
        for (i, task) in Task::ALL.into_iter().enumerate() {
            assert_eq!(task.place(), i);
        }
        for (i, feature) in Feature::ALL.into_iter().enumerate() {
            assert_eq!(feature as usize, i);
        }
    }

    #[test]
    fn refusals_name_the_feature_the_task_and_the_remedy() {
        for feature in Feature::ALL {
            for task in Task::ALL {
                let Err(error) = refuse(feature, "it", task) else {
                    continue;
                };
                let text = error.to_string();
                assert!(text.starts_with(&format!("it {}", feature.has())), "{text}");
                assert!(text.contains(&task.name()), "{text}");
                assert!(text.ends_with(&format!("; {}", error.instead())), "{text}");
            }
        }
        for pair in &PAIRS {
            let error = together(pair.one, "it", pair.other).unwrap_err();
            let text = error.to_string();
            assert!(
                text.contains(pair.one.has()) && text.contains(pair.other.noun()),
                "{text}"
            );
            assert!(!error.code().is_empty());
            // The text before the first semicolon is the fault, the rest is the remedy.
            assert!(!pair.reason.why.contains(';'), "{text}");
        }
        assert_eq!(together(Feature::Servo, "it", Feature::CubicSpring), Ok(()));
    }
}
