//! Checks of a controller, its reference and a digital twin.

use sprung_core::chain::JointKind;
use sprung_core::covariate::Covariate;

use super::fault::{Fault, fault};
use super::window::check_window;
use crate::known_words::{nearest, quoted};
use crate::numbers::Shown;
use crate::robot::Robot;
use crate::run::{Controller, ControllerKind, Reference, Simulate, TwinList};

/// Longest delay of an input shaper, s.
const LONGEST_SHAPER: f64 = 100.0;

pub(super) fn check_controller(
    controller: &Controller,
    path: &[&str],
    robot: &Robot,
) -> Result<(), Fault> {
    let joints: Vec<&str> = robot.joint.iter().map(|j| j.name.as_str()).collect();
    let at = |key| [path, &[key]].concat();
    let n = joints.len();
    match controller.kind {
        ControllerKind::Pd => {
            for (key, list) in [
                ("kp_nm_per_rad", &controller.kp_nm_per_rad),
                ("kd_nms_per_rad", &controller.kd_nms_per_rad),
            ] {
                if list.len() != n {
                    return Err(fault(
                        &at(key),
                        format!("controller \"pd\" needs {n} numbers in {key}, one per joint"),
                    ));
                }
            }
        }
        ControllerKind::StateFeedback => {
            if controller.gain.len() != n || controller.gain.iter().any(|row| row.len() != 4 * n) {
                return Err(fault(
                    &at("gain"),
                    format!(
                        "controller \"state-feedback\" needs gain with {n} rows of {} numbers: on \
                         the errors of link positions, motor positions, link velocities and motor \
                         velocities",
                        4 * n
                    ),
                ));
            }
        }
    }
    let rows = controller.gain.iter().flatten();
    let gains = [
        (
            "kp_nm_per_rad",
            controller.kp_nm_per_rad.iter().all(|g| g.is_finite()),
        ),
        (
            "kd_nms_per_rad",
            controller.kd_nms_per_rad.iter().all(|g| g.is_finite()),
        ),
        ("gain", rows.copied().all(f64::is_finite)),
    ];
    if let Some((key, _)) = gains.iter().find(|(_, finite)| !finite) {
        return Err(fault(
            &at(key),
            format!("every number of {key} must be finite"),
        ));
    }
    check_compensation(controller, &at("friction_compensation_speed_rad_per_s"))?;
    check_window(controller.velocity_window, &at("velocity_window"))?;
    if let Some(message) = fault_of_shaper(&controller.shaper) {
        return Err(fault(&at("shaper"), message));
    }
    check_reference(&controller.reference, &at("reference"), robot)
}

/// Returns why no filter has the impulses.
fn fault_of_shaper(shaper: &[[f64; 2]]) -> Option<String> {
    let sum: f64 = shaper.iter().map(|[_, part]| part).sum();
    let times = || shaper.iter().map(|[time, _]| *time);
    if !shaper.iter().flatten().all(|x| x.is_finite()) {
        return Some("every number of shaper must be finite".to_owned());
    }
    if times().any(|time| !(0.0..=LONGEST_SHAPER).contains(&time))
        || times().zip(times().skip(1)).any(|(a, b)| b <= a)
    {
        return Some(format!(
            "the times of shaper must rise, from 0 to at most {LONGEST_SHAPER} s"
        ));
    }
    if !shaper.is_empty() && (sum - 1.0).abs() > 1e-6 {
        return Some(format!(
            "the parts of shaper have the sum {}, and it must be 1",
            Shown(sum)
        ));
    }
    None
}

fn check_compensation(controller: &Controller, path: &[&str]) -> Result<(), Fault> {
    let Some(speed) = controller.friction_compensation_speed_rad_per_s else {
        return Ok(());
    };
    let key = "friction_compensation_speed_rad_per_s";
    if controller.kind != ControllerKind::StateFeedback {
        return Err(fault(
            path,
            format!(
                "{key} belongs to controller \"state-feedback\", which has a feedforward; delete it"
            ),
        ));
    }
    if !(speed.is_finite() && speed > 0.0) {
        return Err(fault(
            path,
            format!("{key} = {} must be positive and finite", Shown(speed)),
        ));
    }
    Ok(())
}

pub(crate) fn check_reference(
    reference: &Reference,
    path: &[&str],
    robot: &Robot,
) -> Result<(), Fault> {
    let joints: Vec<&str> = robot.joint.iter().map(|j| j.name.as_str()).collect();
    let n = joints.len();
    let slides = |i: usize| robot.kind(i) == JointKind::Prismatic;
    for (key, centre, other) in [
        ("centre_deg", &reference.centre_deg, "centre_m"),
        ("centre_m", &reference.centre_m, "centre_deg"),
    ] {
        let at = [path, &[key]].concat();
        if !(centre.is_empty() || centre.len() == n) || centre.iter().any(|c| !c.is_finite()) {
            return Err(fault(
                &at,
                format!("{key} needs {n} finite numbers, one per joint"),
            ));
        }
        let is_other = |i: usize| slides(i) == (key == "centre_deg");
        if let Some(i) = (0..centre.len()).find(|&i| is_other(i) && centre[i] != 0.0) {
            let kind = if slides(i) { "prismatic" } else { "revolute" };
            return Err(fault(
                &at,
                format!(
                    "{} is {kind}; its number in {key} must be 0, and {other} has its centre",
                    joints[i]
                ),
            ));
        }
    }
    for (k, sine) in reference.sines.iter().enumerate() {
        let k = k.to_string();
        let at = |key| [path, &["sines", &k, key]].concat();
        let Some(joint) = joints.iter().position(|name| *name == sine.joint) else {
            let hint = nearest(&sine.joint, joints.iter().copied())
                .map_or_else(|| quoted(&joints), |known| format!("\"{known}\""));
            return Err(fault(
                &at("joint"),
                format!(
                    "the robot has no joint \"{}\"; did you mean {hint}?",
                    sine.joint
                ),
            ));
        };
        for (key, value) in [
            ("amplitude_deg", sine.amplitude_deg),
            ("amplitude_m", sine.amplitude_m),
            ("frequency_hz", sine.frequency_hz),
            ("phase_deg", sine.phase_deg),
        ] {
            if !value.is_finite() {
                return Err(fault(&at(key), format!("{key} must be finite")));
            }
        }
        let (kind, wrong, value, right) = if slides(joint) {
            (
                "prismatic",
                "amplitude_deg",
                sine.amplitude_deg,
                "amplitude_m",
            )
        } else {
            ("revolute", "amplitude_m", sine.amplitude_m, "amplitude_deg")
        };
        if value != 0.0 {
            return Err(fault(
                &at(wrong),
                format!("{} is {kind}; give {right} instead of {wrong}", sine.joint),
            ));
        }
    }
    Ok(())
}

pub(super) fn check_twin(twin: &Simulate, joints: &[&str]) -> Result<(), Fault> {
    for (key, value) in [("duration_s", twin.duration_s), ("period_s", twin.period_s)] {
        if !(value.is_finite() && value > 0.0) {
            return Err(fault(
                &["simulate", key],
                format!("{key} = {} must be positive", Shown(value)),
            ));
        }
    }
    if twin.duration_s / twin.period_s > 1e9 {
        return Err(fault(
            &["simulate", "duration_s"],
            "the log would have more than 1e9 samples",
        ));
    }
    for (key, list) in twin.lists() {
        let length = list.len();
        if length != 0 && length != joints.len() {
            let n = joints.len();
            return Err(fault(
                &["simulate", key],
                format!("{key} has {length} numbers, the robot has {n} joints"),
            ));
        }
    }
    for (key, list) in twin.lists() {
        check_list(key, list, joints)?;
    }
    check_covariates(twin)
}

/// Checks the entries of a list with one entry per joint.
fn check_list(key: &str, list: TwinList<'_>, joints: &[&str]) -> Result<(), Fault> {
    let wrong = |rule: String| Err(fault(&["simulate", key], rule));
    let first = |list: &[f64], is_right: fn(f64) -> bool| {
        list.iter()
            .copied()
            .find(|value| !is_right(*value))
            .map(Shown)
    };
    match list {
        TwinList::Numbers(list) => match first(list, f64::is_finite) {
            Some(value) => wrong(format!(
                "{key} contains {value}; every number must be finite"
            )),
            None => Ok(()),
        },
        TwinList::Deviations(list) => match first(list, |v| v.is_finite() && v >= 0.0) {
            Some(value) => wrong(format!(
                "{key} contains {value}; a standard deviation must be zero or positive"
            )),
            None => Ok(()),
        },
        TwinList::Limits(list) => match first(list, |v| v > 0.0) {
            Some(value) => wrong(format!("{key} contains {value}; a limit must be positive")),
            None => Ok(()),
        },
        TwinList::Counts(_) => Ok(()),
        TwinList::Rows(rows) => {
            let is_row =
                |row: &Vec<f64>| row.len() == joints.len() && row.iter().all(|v| v.is_finite());
            match rows.iter().position(|row| !is_row(row)) {
                Some(at) => wrong(format!(
                    "row {} of {key} must have {} finite numbers, one per joint",
                    at + 1,
                    joints.len()
                )),
                None => Ok(()),
            }
        }
    }
}

fn check_covariates(twin: &Simulate) -> Result<(), Fault> {
    for covariate in Covariate::ALL {
        let (key, ends) = (covariate.key(), twin.drifts.of(covariate));
        if let Some(value) = ends.into_iter().flatten().find(|v| !v.is_finite()) {
            return Err(fault(
                &["simulate", key],
                format!(
                    "{key} contains {}; every number must be finite",
                    Shown(value)
                ),
            ));
        }
    }
    Ok(())
}

/// Checks the target and the switch of a servo's twin.
pub(super) fn check_target(twin: &Simulate, robot: &Robot) -> Result<(), Fault> {
    if let Some(target) = &twin.target {
        check_reference(target, &["simulate", "target"], robot)?;
    }
    let is_interval = |[from, to]: &[f64; 2]| from.is_finite() && to.is_finite() && from < to;
    for (key, intervals) in [
        ("drive_off_s", &twin.drive_off_s),
        ("contact_s", &twin.contact_s),
    ] {
        if let Some([from, to]) = intervals.iter().find(|interval| !is_interval(interval)) {
            let message =
                format!("{key} contains [{from}, {to}]; the first time must be before the second");
            return Err(fault(&["simulate", key], message));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use sprung_testing::Messages;

    use crate::{no_files, read};

    const GAIN: &str = "gain = [[1, 0, 1, 0, 1, 0, 1, 0], [0, 1, 0, 1, 0, 1, 0, 1]]";

    #[test]
    fn the_speed_of_the_compensation_is_positive_and_belongs_to_state_feedback() {
        let before = sprung_base::demo::EXPERIMENT.split("[controller]").next();
        let message = |controller: &str, speed: &str| {
            let text = format!(
                "{}\n[controller]\n{controller}\nfriction_compensation_speed_rad_per_s = {speed}\n",
                before.unwrap_or_default()
            );
            let read = read("experiment.toml", &text, &[], &mut no_files);
            read.err().map(|error| error.to_string())
        };
        let state = format!("kind = \"state-feedback\"\n{GAIN}");
        assert_eq!(message(&state, "0.05"), None);
        let pd = "kind = \"pd\"\nkp_nm_per_rad = [1, 1]\nkd_nms_per_rad = [1, 1]";
        let mut messages = Messages::new(concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/tests/messages/speed_of_the_compensation.txt"
        ));
        for speed in ["0", "-0.1", "inf", "nan"] {
            messages.note(speed, &message(&state, speed).unwrap_or_default());
        }
        messages.note("pd", &message(pd, "0.05").unwrap_or_default());
        messages.compare();
    }
}
