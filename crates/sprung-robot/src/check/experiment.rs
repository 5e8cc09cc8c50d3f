//! Checks of an experiment: lengths, signs, names that must exist.

use super::control::check_control;
use super::excite::{check_excite, check_limits};
use super::fault::{Fault, fault};
use super::identify::identify;
use super::inertial::check_estimators;
use super::log::{check_log, check_overlay};
use super::name::check_name;
use super::payload::check_payloads;
use super::robot::robot;
use super::run::{check_controller, check_target, check_twin};
use super::servo::check_servo;
use crate::identify::Identify;
use crate::log::Log;
use crate::robot::Robot;
use crate::types::ExperimentFile;

/// Checks that this version of sprung reads the file format.
pub(crate) fn check_format(file: &ExperimentFile) -> Result<(), Fault> {
    if file.format == 1 {
        return Ok(());
    }
    Err(fault(
        &["format"],
        format!(
            "format {} is not known; this version reads format 1",
            file.format
        ),
    ))
}

/// Checks all parts of an experiment file except its format and its kinematics.
pub(crate) fn check(file: &ExperimentFile) -> Result<(), Fault> {
    robot(file)?;
    identify(file)?;
    let joints: Vec<&str> = file.robot.joint.iter().map(|j| j.name.as_str()).collect();
    if let Some(log) = &file.log {
        check_log(log, &["log"], &file.robot)?;
    }
    check_estimators(file.log.as_ref(), &file.robot, &file.identify)?;
    check_servo(file)?;
    check_payloads(file)?;
    for (i, run) in file.validate.iter().enumerate() {
        check_name(&run.name, &["validate", &i.to_string(), "name"])?;
        if file.validate[..i]
            .iter()
            .any(|other| other.name == run.name)
        {
            return Err(fault(
                &["validate", &i.to_string(), "name"],
                format!("two validation runs are called \"{}\"", run.name),
            ));
        }
    }
    if let Some(controller) = &file.controller {
        check_controller(controller, &["controller"], &file.robot)?;
    }
    for (i, run) in file.validate.iter().enumerate() {
        let i = i.to_string();
        if let Some(over) = &run.log {
            overlaid(
                file.log.as_ref(),
                over,
                &["validate", &i, "log"],
                &file.robot,
            )?;
        }
        if let Some(controller) = &run.controller {
            check_controller(controller, &["validate", &i, "controller"], &file.robot)?;
        }
    }
    check_limits(&file.robot)?;
    check_excite(&file.excite, &file.robot)?;
    check_control(&file.control, &file.robot)?;
    if let Some(twin) = &file.simulate {
        check_twin(twin, &joints)?;
        check_target(twin, &file.robot)?;
    }
    Ok(())
}

/// Returns a log with the columns of another one in place of its own, and checks it.
pub(crate) fn check_log_over(
    log: Option<&Log>,
    over: &Log,
    robot: &Robot,
    settings: &Identify,
) -> Result<Log, Fault> {
    let log = overlaid(log, over, &["log"], robot)?;
    check_estimators(Some(&log), robot, settings)?;
    Ok(log)
}

fn overlaid(log: Option<&Log>, over: &Log, path: &[&str], robot: &Robot) -> Result<Log, Fault> {
    let all = log.map_or_else(|| over.clone(), |log| log.overlaid(over, robot));
    check_overlay(log, over, path, robot)?;
    check_log(&all, path, robot)?;
    Ok(all)
}
