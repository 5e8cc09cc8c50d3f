//! Checks of limits and of the experiment that is to be designed.

use super::fault::{Fault, fault};
use crate::excite::{Excite, MOST_SAMPLES};
use crate::limits::Limits;
use crate::numbers::Shown;
use crate::robot::Robot;

/// Most steps of a search.
const MAX_STEPS: usize = 100_000;

/// Checks the limits of the joints.
pub(super) fn check_limits(robot: &Robot) -> Result<(), Fault> {
    for (i, joint) in robot.joint.iter().enumerate() {
        let Some(limits) = &joint.limits else {
            continue;
        };
        let i = i.to_string();
        let at = |key| ["robot", "joint", &i, "limits", key];
        check_of_joint(&joint.name, limits).map_err(|(key, message)| fault(&at(key), message))?;
    }
    Ok(())
}

/// Returns the key and the message of a faulty limit.
fn check_of_joint(name: &str, limits: &Limits) -> Result<(), (&'static str, String)> {
    if let Some([low, high]) = limits.position_rad
        && !(low.is_finite() && high.is_finite() && low < high)
    {
        return Err((
            "position_rad",
            format!(
                "{name}: position_rad = [{}, {}] contains no position; write the lowest position first",
                Shown(low),
                Shown(high)
            ),
        ));
    }
    let magnitudes = limits.magnitudes().into_iter();
    let mut given = magnitudes.filter_map(|(key, value)| Some((key, value?)));
    match given.find(|(_, value)| !(value.is_finite() && *value > 0.0)) {
        None => Ok(()),
        Some((key, value)) => Err((
            key,
            format!("{name}: {key} = {} must be positive", Shown(value)),
        )),
    }
}

pub(super) fn check_excite(excite: &Excite, robot: &Robot) -> Result<(), Fault> {
    let wrong = |key: &str, message: String| Err(fault(&["excite", key], message));
    for (key, value) in [
        ("duration_s", Some(excite.duration_s)),
        ("period_s", Some(excite.period_s)),
        ("base_frequency_hz", excite.base_frequency_hz),
        ("slow_sweep_s", excite.slow_sweep_s),
        ("tool_speed_m_per_s", excite.tool_speed_m_per_s),
    ] {
        if let Some(value) = value
            && !(value.is_finite() && value > 0.0)
        {
            return wrong(key, format!("{key} = {} must be positive", Shown(value)));
        }
    }
    for (key, duration) in [
        ("duration_s", excite.duration_s),
        ("slow_sweep_s", excite.slow_sweep_s.unwrap_or(0.0)),
    ] {
        if duration / excite.period_s > MOST_SAMPLES {
            return wrong(
                key,
                format!("the trajectory would have more than {MOST_SAMPLES:e} samples"),
            );
        }
    }
    if let Some(base) = excite.base_frequency_hz
        && excite.duration_s * base < 1.0 - 1e-9
    {
        return wrong(
            "duration_s",
            format!(
                "duration_s = {} is shorter than one period of the lowest frequency, {} s; give at least that, or a \
                 higher base_frequency_hz",
                Shown(excite.duration_s),
                Shown(1.0 / base)
            ),
        );
    }
    for (key, value, least, most) in [
        ("margin", excite.margin, 0.0, 0.9),
        ("value_error", excite.value_error, 0.0, 3.0),
    ] {
        if !(least..=most).contains(&value) {
            return wrong(
                key,
                format!(
                    "{key} = {} must be between {least} and {most}",
                    Shown(value)
                ),
            );
        }
    }
    for (key, value, least, most) in [
        ("steps", excite.steps, 0, MAX_STEPS),
        ("starts", excite.starts, 1, 1000),
        ("draws", excite.draws, 1, 1000),
        ("harmonics", excite.harmonics.unwrap_or(3), 3, 200),
    ] {
        if !(least..=most).contains(&value) {
            return wrong(
                key,
                format!("{key} = {value} must be between {least} and {most}"),
            );
        }
    }
    let n = robot.joint.len();
    let start = &excite.start_rad;
    if !(start.is_empty() || start.len() == n) || start.iter().any(|x| !x.is_finite()) {
        return wrong(
            "start_rad",
            format!("start_rad needs {n} finite numbers, one per joint"),
        );
    }
    if let Some(x) = (excite.tool_xyz_m.iter().chain(&excite.floor_m)).find(|x| !x.is_finite()) {
        let key = if excite.floor_m.is_some_and(|x| !x.is_finite()) {
            "floor_m"
        } else {
            "tool_xyz_m"
        };
        return wrong(
            key,
            format!("{key} contains {}, which is not finite", Shown(*x)),
        );
    }
    Ok(())
}
