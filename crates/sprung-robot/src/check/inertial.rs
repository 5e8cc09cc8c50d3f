//! Checks of sensors of motion on links.

use sprung_core::friction::Family;

use super::fault::{Fault, fault, refused};
use crate::capabilities::{Feature, Task, refuse_task, together};
use crate::friction::FrictionLaw;
use crate::identify::Identify;
use crate::inertial::{Axis, Inertial};
use crate::instruments::Instrument;
use crate::log::Log;
use crate::numbers::Shown;
use crate::quantities::{Key, Quantity, Signal};
use crate::robot::{Robot, SpringTerm};

/// Checks the sensors on links beside the other sensors of a log.
pub(super) fn check_inertial(log: &Log, path: &[&str], robot: &Robot) -> Result<(), Fault> {
    for sensor in Inertial::ALL {
        if let Some(corner) = sensor.given_corner_hz(log)
            && !(corner.is_finite() && corner > 0.0)
        {
            let key = sensor.corner_key();
            return Err(fault(
                &[path, &[key]].concat(),
                format!("{key} = {} must be positive", Shown(corner)),
            ));
        }
    }
    let mut all = Inertial::ALL.into_iter();
    let Some((sensor, keys)) = all.find_map(|sensor| Some((sensor, keys_of(sensor, log)?))) else {
        return Ok(());
    };
    let a = sensor.a();
    let first = keys[0].name;
    let wrong = |message: String| Err(fault(&[path, &[first]].concat(), message));
    if keys.len() == 2 {
        return wrong(format!(
            "{a} has one axis or three; name the columns of the third axis, or of one axis only"
        ));
    }
    let at = [path, &[first]].concat();
    for other in all.filter(|other| keys_of(*other, log).is_some()) {
        together(
            Feature::of_sensor(sensor),
            "the log",
            Feature::of_sensor(other),
        )
        .map_err(|reason| refused(&at, &reason))?;
    }
    for (i, joint) in robot.joint.iter().enumerate() {
        if Instrument::of(i, log, robot).shows_constant_deflections() {
            continue;
        }
        let gives = |signal| Key::gives(signal, i, log, robot);
        let quantity = |wanted| log.given().any(|(key, _)| key.quantity == wanted);
        let laws = joint.link_laws().iter().chain(joint.motor_laws());
        let has_load = laws
            .into_iter()
            .any(|law| *law == FrictionLaw(Family::Load));
        for (other, has) in [
            (
                Feature::LinkEncoder,
                quantity(Quantity::LinkPosition) && gives(Signal::Link),
            ),
            (
                Feature::DeflectionSensor,
                quantity(Quantity::LinkDeflection) && gives(Signal::Link),
            ),
            (Feature::TorqueSensorAlone, gives(Signal::Spring)),
            (
                Feature::CubicSpring,
                (joint.spring_terms().iter())
                    .any(|term| !matches!(term, SpringTerm::Linear | SpringTerm::Damping)),
            ),
            (Feature::LoadFriction, has_load),
        ] {
            if has {
                together(Feature::of_sensor(sensor), &joint.name, other)
                    .map_err(|reason| refused(&at, &reason))?;
            }
        }
    }
    Ok(())
}

/// Returns the keys of the axes of a sensor in a log; `None` without any.
fn keys_of(sensor: Inertial, log: &Log) -> Option<Vec<&'static Key>> {
    let given = |axis| {
        let mut keys = Key::of(Signal::Inertial(sensor, axis));
        keys.find(|key| key.is_given(log))
    };
    let keys: Vec<&Key> = Axis::ALL.into_iter().filter_map(given).collect();
    (!keys.is_empty()).then_some(keys)
}

/// Checks that the estimators work with the robot and the log.
pub(super) fn check_estimators(
    log: Option<&Log>,
    robot: &Robot,
    settings: &Identify,
) -> Result<(), Fault> {
    let of_links = |log: &Log| {
        Inertial::ALL
            .iter()
            .any(|sensor| keys_of(*sensor, log).is_some())
    };
    let refines = robot.has_springs() && !log.is_some_and(of_links);
    for &estimator in settings.estimators(refines) {
        refuse_task(robot, log, Task::Identify(estimator))
            .map_err(|reason| refused(&["identify", "estimator"], &reason))?;
    }
    Ok(())
}
