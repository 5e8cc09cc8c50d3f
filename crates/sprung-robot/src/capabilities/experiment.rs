//! The features of an experiment.

use super::NotSupported;
use super::feature::Feature;
use super::table::refuse;
use super::task::Task;
use crate::instruments::Instrument;
use crate::log::Log;
use crate::robot::Robot;
use crate::window::FilePart;

/// Refuses a task that does not work with the robot or its log.
///
/// # Errors
///
/// [`NotSupported`] with the first feature that refuses the task.
pub fn refuse_task(robot: &Robot, log: Option<&Log>, task: Task) -> Result<(), NotSupported> {
    for (feature, of) in features(robot, log) {
        refuse(feature, &of, task)?;
    }
    Ok(())
}

/// Returns the kind of payload of a file, with the name of the file; `None` without payload.
pub(crate) fn payload_feature(file: &FilePart) -> Option<(Feature, String)> {
    let payload = file.payload.as_ref()?;
    let feature = match payload.mass_kg {
        Some(_) => Feature::KnownPayload,
        None => Feature::UnknownPayload,
    };
    Some((feature, file.path.display().to_string()))
}

/// Returns the features of a robot and its log, each with the name of the joint or robot that has it.
fn features(robot: &Robot, log: Option<&Log>) -> Vec<(Feature, String)> {
    let mut all = Vec::new();
    for (i, joint) in robot.joint.iter().enumerate() {
        let mut add = |feature: Feature| all.push((feature, joint.name.clone()));
        if joint.servo.is_some() {
            add(Feature::Servo);
        }
        if let Some(log) = log {
            add(of_instrument(Instrument::of(i, log, robot)));
        }
        if joint.friction_covariates.is_some() {
            add(Feature::Covariates);
        }
    }
    if robot.transmission_matrix.is_some() {
        all.push((Feature::CoupledTransmission, "the robot".to_owned()));
    }
    all
}

/// Returns the feature of an instrument.
fn of_instrument(instrument: Instrument) -> Feature {
    match instrument {
        Instrument::Motor | Instrument::Servo => Feature::MotorOnly,
        Instrument::Link => Feature::LinkEncoder,
        Instrument::Deflection => Feature::DeflectionSensor,
        Instrument::TorqueAndLink => Feature::TorqueSensor,
        Instrument::Torque => Feature::TorqueSensorAlone,
        Instrument::Inertial(sensor) => Feature::of_sensor(sensor),
    }
}
