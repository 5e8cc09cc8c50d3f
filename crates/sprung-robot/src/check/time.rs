//! Checks of the time of a log.

use super::fault::{Fault, fault};
use crate::columns::PerJoint;
use crate::known_words::quoted;
use crate::log::Log;
use crate::units::{Dimension, Unit};

pub(super) fn check_time(log: &Log, path: &[&str]) -> Result<(), Fault> {
    let given: Vec<&str> = [
        ("time_s", log.time_s.is_some()),
        ("time_ms", log.time_ms.is_some()),
        ("time_us", log.time_us.is_some()),
        ("time_ns", log.time_ns.is_some()),
        ("time", log.time.is_some()),
    ]
    .into_iter()
    .filter_map(|(key, given)| given.then_some(key))
    .collect();
    if let [first, second, ..] = given[..] {
        return Err(fault(
            &[path, &[second]].concat(),
            format!("{first} and {second} both give the time; keep one"),
        ));
    }
    if let Some(period) = log.period_s
        && !(period.is_finite() && period > 0.0)
    {
        return Err(fault(
            &[path, &["period_s"]].concat(),
            format!("period_s = {period} must be positive"),
        ));
    }
    if let (Some(period), Some(_)) = (log.period_s, log.sampling) {
        return Err(fault(
            &[path, &["sampling"]].concat(),
            format!(
                "period_s = {period} states that samples were taken at its multiples; remove period_s \
                 or sampling"
            ),
        ));
    }
    check_controller_period(log, path)?;
    let Some(time) = &log.time else { return Ok(()) };
    let at = [path, &["time"]].concat();
    let dimension = time.unit.map(Unit::dimension);
    if time.topic.is_none() && dimension.is_none() {
        let units = Unit::names_of(Dimension::Time);
        return Err(fault(
            &at,
            format!(
                "time has no unit; write time_s, time_ms, time_us or time_ns, or give a \
                 unit: {}",
                quoted(&units)
            ),
        ));
    }
    if dimension.is_some_and(|dimension| dimension != Dimension::Time) {
        let units = Unit::names_of(Dimension::Time);
        return Err(fault(
            &at,
            format!("the unit of time is one of {}", quoted(&units)),
        ));
    }
    let one = matches!(time.column, Some(PerJoint::One(_))) || time.topic.is_some();
    if !one
        || time
            .column
            .iter()
            .any(|column| matches!(column, PerJoint::One(name) if name.is_pattern()))
    {
        return Err(fault(&at, "time is one column; name it"));
    }
    Ok(())
}

/// Checks the period of the controller. Each log is compared with it when it is read.
fn check_controller_period(log: &Log, path: &[&str]) -> Result<(), Fault> {
    let Some(period) = log.controller_period_s else {
        return Ok(());
    };
    let at = [path, &["controller_period_s"]].concat();
    if !(period.is_finite() && period > 0.0) {
        return Err(fault(
            &at,
            format!(
                "controller_period_s = {period} must be positive; give the time for which the controller holds a torque, s"
            ),
        ));
    }
    if log.torque.is_none() {
        return Err(fault(
            &at,
            format!(
                "controller_period_s = {period} says how long a torque is held, but not what the log has; add torque = \
                 \"held\", \"mean\" or \"instantaneous\""
            ),
        ));
    }
    Ok(())
}
