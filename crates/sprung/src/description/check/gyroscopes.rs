//! Checks of gyroscopes on links.

use sprung_core::friction::Family;

use super::fault::{Fault, fault};
use crate::description::friction::FrictionLaw;
use crate::description::identify::{Estimator, Identify, Instruments};
use crate::description::log::Log;
use crate::description::quantities::{Axis, Key, Signal};
use crate::description::robot::{Robot, SpringTerm};
use crate::numbers::Shown;

/// Checks the gyroscopes of a log beside its other sensors.
pub(super) fn check_gyroscopes(log: &Log, path: &[&str], robot: &Robot) -> Result<(), Fault> {
    if let Some(corner) = log.gyroscope_corner_hz
        && !(corner.is_finite() && corner > 0.0)
    {
        return Err(fault(
            &[path, &["gyroscope_corner_hz"]].concat(),
            format!("gyroscope_corner_hz = {} must be positive", Shown(corner)),
        ));
    }
    let given = |axis| {
        let mut keys = Key::of(Signal::Gyroscope(axis));
        keys.find(|key| key.is_given(log))
    };
    let keys: Vec<&Key> = Axis::ALL.into_iter().filter_map(given).collect();
    let Some(first) = keys.first() else {
        return Ok(());
    };
    let wrong = |message: String| Err(fault(&[path, &[first.name]].concat(), message));
    if keys.len() == 2 {
        return wrong(
            "a gyroscope has one axis or three; name the columns of the third axis, or of one axis only"
                .to_owned(),
        );
    }
    for (signal, what) in [
        (Signal::Link, "link positions"),
        (Signal::Spring, "joint torques"),
    ] {
        if let Some(other) = Key::of(signal).find(|key| key.is_given(log)) {
            return wrong(format!(
                "{} and {} both tell the motion of the links beside their motors; keep the gyroscopes or the \
                 {what}",
                first.name, other.name
            ));
        }
    }
    for (i, joint) in robot.joint.iter().enumerate() {
        if !log.has_gyroscope(robot, i) {
            continue;
        }
        let name = &joint.name;
        if joint.spring_terms().contains(&SpringTerm::Cubic) {
            return wrong(format!(
                "{name}: a gyroscope shows only changes of the deflection, so \"cubic\" in spring cannot be \
                 estimated; remove it, or use a link encoder"
            ));
        }
        let laws = joint.link_laws().iter().chain(joint.motor_laws());
        if laws
            .into_iter()
            .any(|law| *law == FrictionLaw(Family::Load))
        {
            return wrong(format!(
                "{name}: a gyroscope shows only changes of the deflection, so the friction law \"load\" \
                 cannot be estimated; remove it, or use a link encoder"
            ));
        }
    }
    Ok(())
}

/// Checks that the estimators know gyroscopes.
pub(super) fn check_estimators(log: &Log, robot: &Robot, settings: &Identify) -> Result<(), Fault> {
    if !(0..robot.joint.len()).any(|joint| log.has_gyroscope(robot, joint)) {
        return Ok(());
    }
    let other = (settings.estimator.iter()).find(|one| **one != Estimator::LeastSquares);
    if let Some(other) = other {
        return Err(fault(
            &["identify", "estimator"],
            format!(
                "the log has gyroscopes on the links, which \"{}\" does not know; set estimator = \
                 [\"least-squares\"]",
                other.name()
            ),
        ));
    }
    if settings.instruments != Instruments::None {
        return Err(fault(
            &["identify", "instruments"],
            "instruments do not know gyroscopes on the links; set instruments = \"none\""
                .to_owned(),
        ));
    }
    Ok(())
}
