//! What types cannot say of a log: one column per joint, nothing said twice.

use sprung_core::chain::JointKind;

use super::check::{Fault, fault};
use super::choice::nearest;
use super::log::{Delay, Log};
use super::robot::{Joint, Robot};

/// Longest delay of a channel, s.
const LONGEST_DELAY: f64 = 60.0;

/// The joints that a list of columns speaks of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Of {
    /// Flexible joints of a kind: only they have a link position of their own.
    Flexible(JointKind),
    /// Joints of a kind.
    Kind(JointKind),
    /// All joints.
    All,
}

type List<'a> = (&'static str, &'a Option<Vec<String>>, Of);

fn lists(log: &Log) -> [List<'_>; 12] {
    use JointKind::{Prismatic, Revolute};
    [
        (
            "link_position_rad",
            &log.link_position_rad,
            Of::Flexible(Revolute),
        ),
        (
            "link_position_deg",
            &log.link_position_deg,
            Of::Flexible(Revolute),
        ),
        (
            "link_deflection_rad",
            &log.link_deflection_rad,
            Of::Flexible(Revolute),
        ),
        (
            "link_deflection_deg",
            &log.link_deflection_deg,
            Of::Flexible(Revolute),
        ),
        (
            "link_position_m",
            &log.link_position_m,
            Of::Flexible(Prismatic),
        ),
        (
            "motor_position_rad",
            &log.motor_position_rad,
            Of::Kind(Revolute),
        ),
        (
            "motor_position_deg",
            &log.motor_position_deg,
            Of::Kind(Revolute),
        ),
        (
            "motor_position_m",
            &log.motor_position_m,
            Of::Kind(Prismatic),
        ),
        ("motor_torque_nm", &log.motor_torque_nm, Of::Kind(Revolute)),
        ("motor_force_n", &log.motor_force_n, Of::Kind(Prismatic)),
        ("motor_current_a", &log.motor_current_a, Of::All),
        ("drive_voltage_v", &log.drive_voltage_v, Of::All),
    ]
}

/// Checks that a list has a column for each of its joints.
///
/// - `lone`: whether these are the only positions of a rigid robot, which may
///   call them those of its links.
fn check_length(
    key: &str,
    list: &[String],
    of: Of,
    lone: bool,
    path: &[&str],
    robot: &Robot,
) -> Result<(), Fault> {
    let pick = |wanted: &dyn Fn(usize, &Joint) -> bool| -> Vec<&str> {
        let all = robot.joint.iter().enumerate();
        (all.filter(|(i, joint)| wanted(*i, joint)))
            .map(|(_, joint)| joint.name.as_str())
            .collect()
    };
    let (joints, what) = match of {
        Of::All => (pick(&|_, _| true), ""),
        Of::Kind(kind) => (pick(&|i, _| robot.kind(i) == kind), turning(robot, kind)),
        Of::Flexible(kind) if lone => (pick(&|i, _| robot.kind(i) == kind), turning(robot, kind)),
        Of::Flexible(kind) => {
            let all = pick(&|i, _| robot.kind(i) == kind);
            let flexible = pick(&|i, joint| robot.kind(i) == kind && joint.is_flexible());
            if flexible.len() < all.len() && list.len() == all.len() {
                let rigid = all.iter().find(|name| !flexible.contains(name));
                return Err(fault(
                    path,
                    format!(
                        "{} is rigid, so motor and link have one position; {key} gives it a second \
                         column. Leave it out of {key}, or set transmission = \"flexible\"",
                        rigid.copied().unwrap_or_default()
                    ),
                ));
            }
            if flexible.len() < robot.joint.len() {
                (flexible, "flexible ")
            } else {
                (flexible, "")
            }
        }
    };
    if list.len() == joints.len() {
        return Ok(());
    }
    let has = match &joints[..] {
        [] => format!("no {what}joints"),
        joints => format!("{} {what}joints ({})", joints.len(), joints.join(", ")),
    };
    Err(fault(
        path,
        format!("{key} names {} columns, the robot has {has}", list.len()),
    ))
}

/// Returns a word for the joints of a kind if there are others.
fn turning(robot: &Robot, kind: JointKind) -> &'static str {
    let mixed = (0..robot.joint.len()).any(|i| robot.kind(i) != kind);
    match kind {
        _ if !mixed => "",
        JointKind::Revolute => "revolute ",
        JointKind::Prismatic => "prismatic ",
    }
}

pub(super) fn check_log(log: &Log, path: &[&str], robot: &Robot) -> Result<(), Fault> {
    let lists = lists(log);
    let at = |key| [path, &[key]].concat();
    let rigid = !robot.joint.iter().any(Joint::is_flexible);
    let lone = rigid && lists[5..8].iter().all(|(_, list, _)| list.is_none());
    for (key, list, of) in &lists {
        if let Some(list) = list {
            let lone = lone && key.starts_with("link_position");
            check_length(key, list, *of, lone, &at(key), robot)?;
        }
    }
    if let Some(files) = &log.file
        && let Some(twice) = (1..files.len()).find(|&i| files[..i].contains(&files[i]))
    {
        return Err(fault(
            &at("file"),
            format!(
                "{} is listed twice; its samples would count as if they were others",
                files[twice].display()
            ),
        ));
    }
    if log.time_s.is_some() && log.time_ms.is_some() {
        return Err(fault(
            &at("time_ms"),
            "time_s and time_ms say the same thing twice; keep one",
        ));
    }
    // A quantity is said once for the joints that turn and once for those
    // that slide; what a list says of all joints stands alone.
    for group in [
        &lists[0..4],
        &lists[4..5],
        &lists[5..7],
        &lists[7..8],
        &lists[8..12],
    ] {
        let given: Vec<(&str, Of)> = (group.iter())
            .filter(|(_, list, _)| list.is_some())
            .map(|&(key, _, of)| (key, of))
            .collect();
        if let [(first, a), (second, b), ..] = given[..]
            && (a == b || a == Of::All || b == Of::All)
        {
            return Err(fault(
                &at(second),
                format!("{first} and {second} say the same thing twice; keep one"),
            ));
        }
    }
    let columns: Vec<&str> = lists
        .iter()
        .filter_map(|(_, list, _)| list.as_ref())
        .flatten()
        .map(String::as_str)
        .collect();
    if let Some(twice) = (1..columns.len()).find(|&i| columns[..i].contains(&columns[i])) {
        return Err(fault(
            path,
            format!(
                "the column \"{}\" is named twice; each holds one quantity",
                columns[twice]
            ),
        ));
    }
    for (key, name) in (log.delay_s.keys().map(|name| ("delay_s", name)))
        .chain(log.sign.keys().map(|name| ("sign", name)))
    {
        if !columns.contains(&name.as_str()) {
            let hint = nearest(name, columns.iter().copied())
                .map_or_else(String::new, |known| format!("; did you mean \"{known}\"?"));
            return Err(fault(
                &[path, &[key, name]].concat(),
                format!("{key} speaks of \"{name}\", which is not a column of this log{hint}"),
            ));
        }
    }
    for (name, delay) in &log.delay_s {
        if let Delay::Known(value) = delay
            && (value.is_nan() || value.abs() > LONGEST_DELAY)
        {
            return Err(fault(
                &[path, &["delay_s", name]].concat(),
                format!(
                    "the delay of \"{name}\" is {value} s; it must be within ±{LONGEST_DELAY} s"
                ),
            ));
        }
    }
    for (name, sign) in &log.sign {
        if sign.abs().to_bits() != 1.0_f64.to_bits() {
            return Err(fault(
                &[path, &["sign", name]].concat(),
                format!("the sign of \"{name}\" is {sign}; it must be 1 or -1"),
            ));
        }
    }
    Ok(())
}
