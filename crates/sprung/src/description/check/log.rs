//! What types cannot say of a log: one column per joint, nothing said twice.

use std::path::PathBuf;

use sprung_core::chain::JointKind;

use super::columns::check_columns;
use super::fault::{Fault, fault};
use crate::description::choice::{nearest, quoted};
use crate::description::columns::{Columns, PerJoint};
use crate::description::factor::{Delay, Factor};
use crate::description::log::Log;
use crate::description::robot::{Joint, Robot};
use crate::description::units::{Dimension, Unit};

/// Longest delay of a channel, s.
const LONGEST_DELAY: f64 = 60.0;

/// The joints that a list of columns speaks of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::description) enum Of {
    /// Flexible joints of a kind: only they have a link position of their own.
    Flexible(JointKind),
    /// Flexible joints.
    AnyFlexible,
    /// Joints of a kind.
    Kind(JointKind),
    /// All joints.
    All,
}

pub(in crate::description) type List<'a> = (&'static str, &'a Option<Columns>, Of);

fn lists(log: &Log) -> [List<'_>; 18] {
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
        ("link_position", &log.link_position, Of::AnyFlexible),
        ("link_deflection", &log.link_deflection, Of::AnyFlexible),
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
        ("motor_position", &log.motor_position, Of::All),
        ("motor_torque_nm", &log.motor_torque_nm, Of::Kind(Revolute)),
        ("motor_force_n", &log.motor_force_n, Of::Kind(Prismatic)),
        ("motor_torque", &log.motor_torque, Of::All),
        ("motor_current_a", &log.motor_current_a, Of::All),
        ("motor_current", &log.motor_current, Of::All),
        ("drive_voltage_v", &log.drive_voltage_v, Of::All),
        ("drive_voltage", &log.drive_voltage, Of::All),
    ]
}

/// Returns the joints of which a list speaks, from 0.
fn joints_of(of: Of, lone: bool, robot: &Robot) -> Vec<usize> {
    let wanted = |i: usize| {
        let flexible = lone || robot.joint[i].is_flexible();
        match of {
            Of::All => true,
            Of::Kind(kind) => robot.kind(i) == kind,
            Of::Flexible(kind) => flexible && robot.kind(i) == kind,
            Of::AnyFlexible => flexible,
        }
    };
    (0..robot.joint.len()).filter(|&i| wanted(i)).collect()
}

/// Checks that a list has a column for each of its joints.
///
/// - `lone`: whether these are the only positions of a rigid robot, which may
///   call them those of its links.
fn check_length(
    (key, list, of): (&str, &Columns, Of),
    lone: bool,
    path: &[&str],
    robot: &Robot,
) -> Result<Vec<usize>, Fault> {
    let joints = joints_of(of, lone, robot);
    if list.spread().is_some() && !joints.is_empty() {
        return Ok(joints);
    }
    let count = list.0.len();
    let name = |i: &usize| robot.joint[*i].name.as_str();
    let flexible_only = matches!(of, Of::Flexible(_) | Of::AnyFlexible) && !lone;
    let with_rigid: Vec<usize> = match of {
        Of::Flexible(kind) => joints_of(Of::Kind(kind), lone, robot),
        _ => joints_of(Of::All, lone, robot),
    };
    if flexible_only && joints.len() < with_rigid.len() && count == with_rigid.len() {
        let rigid = with_rigid.iter().find(|i| !joints.contains(i));
        return Err(fault(
            path,
            format!(
                "{} is rigid, so motor and link have one position; {key} gives it a second \
                 column. Leave it out of {key}, or set transmission = \"flexible\"",
                rigid.map(name).unwrap_or_default()
            ),
        ));
    }
    if count == joints.len() {
        return Ok(joints);
    }
    let what = match of {
        _ if flexible_only && joints.len() < robot.joint.len() => "flexible ",
        Of::Kind(kind) | Of::Flexible(kind) if !flexible_only => turning(robot, kind),
        _ => "",
    };
    let names: Vec<&str> = joints.iter().map(name).collect();
    let has = match &names[..] {
        [] => format!("no {what}joints"),
        names => format!("{} {what}joints ({})", names.len(), names.join(", ")),
    };
    Err(fault(
        path,
        format!("{key} names {count} columns, the robot has {has}"),
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

pub(in crate::description) fn check_log(
    log: &Log,
    path: &[&str],
    robot: &Robot,
) -> Result<(), Fault> {
    let lists = lists(log);
    let at = |key| [path, &[key]].concat();
    let rigid = !robot.joint.iter().any(Joint::is_flexible);
    let lone = rigid && lists[7..11].iter().all(|(_, list, _)| list.is_none());
    for (key, list, of) in &lists {
        if let Some(list) = list {
            let lone = lone && key.starts_with("link_position");
            let joints = check_length((key, list, *of), lone, &at(key), robot)?;
            check_columns((key, list, &joints), &at(key), robot)?;
        }
    }
    check_sides(log, path)?;
    check_files(log, path)?;
    check_time(log, path)?;
    check_csv(log, path)?;
    // A quantity is said once for the joints that turn and once for those
    // that slide; what a list says of all joints stands alone.
    for group in [&lists[0..7], &lists[7..11], &lists[11..18]] {
        let given: Vec<(&str, Of)> = (group.iter())
            .filter(|(_, list, _)| list.is_some())
            .map(|&(key, _, of)| (key, of))
            .collect();
        if let [(first, a), (second, b), ..] = given[..]
            && overlap(a, b)
        {
            return Err(fault(
                &at(second),
                format!("{first} and {second} say the same thing twice; keep one"),
            ));
        }
    }
    let mut labels: Vec<String> = Vec::new();
    let mut columns: Vec<(&Option<PathBuf>, String)> = Vec::new();
    for (key, list, _) in &lists {
        let Some(list) = list else { continue };
        let entries = match list.spread() {
            Some(one) => one.entries(),
            None => list.0.len(),
        };
        for i in 0..entries {
            let label = list.label(i, default_field(key));
            let file = list.of(i).map_or(&None, |(column, _)| &column.file);
            // A field of a topic says its joints by their names.
            let topic = list.of(i).is_some_and(|(column, _)| column.topic.is_some());
            if !topic && columns.iter().any(|known| *known == (file, label.clone())) {
                return Err(fault(
                    path,
                    format!("the column \"{label}\" is named twice; each holds one quantity"),
                ));
            }
            columns.push((file, label.clone()));
            labels.push(label);
        }
    }
    check_by_column(log, path, &labels)
}

/// Checks what is said by the names of columns.
fn check_by_column(log: &Log, path: &[&str], labels: &[String]) -> Result<(), Fault> {
    let columns: Vec<&str> = labels.iter().map(String::as_str).collect();
    for (key, name) in (log.delay_s.keys().map(|name| ("delay_s", name)))
        .chain(log.sign.keys().map(|name| ("sign", name)))
        .chain(log.gain.keys().map(|name| ("gain", name)))
    {
        // "q*[joint2]" speaks of one of those that are named together.
        let common = name
            .split_once('[')
            .map_or(name.as_str(), |(common, _)| common);
        if !columns.contains(&name.as_str()) && !columns.contains(&common) {
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
        if let Factor::Known(sign) = sign
            && sign.abs().to_bits() != 1.0_f64.to_bits()
        {
            return Err(fault(
                &[path, &["sign", name]].concat(),
                format!("the sign of \"{name}\" is {sign}; it must be 1 or -1, or \"estimate\""),
            ));
        }
    }
    for (name, gain) in &log.gain {
        if let Factor::Known(gain) = gain
            && !(gain.is_finite() && *gain > 0.0)
        {
            return Err(fault(
                &[path, &["gain", name]].concat(),
                format!(
                    "the gain of \"{name}\" is {gain}; it must be positive, or \"estimate\"; what \
                     counts the other way has a sign"
                ),
            ));
        }
    }
    Ok(())
}

/// Returns whether two lists speak of the same joints.
fn overlap(a: Of, b: Of) -> bool {
    let kind = |of| match of {
        Of::Flexible(kind) | Of::Kind(kind) => Some(kind),
        Of::AnyFlexible | Of::All => None,
    };
    match (kind(a), kind(b)) {
        (Some(a), Some(b)) => a == b,
        _ => true,
    }
}

/// Returns the field of a message that holds a quantity, unless it is said.
pub(crate) fn default_field(key: &str) -> &'static str {
    if key.contains("position") || key.contains("deflection") {
        "position"
    } else {
        "effort"
    }
}

fn check_sides(log: &Log, path: &[&str]) -> Result<(), Fault> {
    for (key, columns, side_key, side) in [
        (
            "motor_position",
            &log.motor_position,
            "motor_position_side",
            log.position_side(),
        ),
        (
            "motor_torque",
            &log.motor_torque,
            "motor_torque_side",
            log.torque_side(),
        ),
    ] {
        let said = columns.iter().flat_map(|columns| &columns.0);
        if said
            .map(|column| column.side)
            .any(|own| own.is_some() && own != side)
        {
            return Err(fault(
                &[path, &[key]].concat(),
                format!("{key} says two sides of the gearbox; say it once, as {side_key}"),
            ));
        }
    }
    Ok(())
}

fn check_files(log: &Log, path: &[&str]) -> Result<(), Fault> {
    let at = [path, &["file"]].concat();
    let files = log.file.as_deref().unwrap_or_default();
    if let Some(twice) = (1..files.len()).find(|&i| files[..i].contains(&files[i])) {
        return Err(fault(
            &at,
            format!(
                "{} is listed twice; its samples would count as if they were others",
                files[twice].display()
            ),
        ));
    }
    if files.len() > 1
        && let Some(other) = log.files().nth(files.len())
    {
        return Err(fault(
            &at,
            format!(
                "{} belongs to one log, file names {}; identify from one of them, or put the \
                 columns of each log into one file",
                other.display(),
                files.len()
            ),
        ));
    }
    Ok(())
}

/// Checks that a log of its own does not borrow columns from another recording.
pub(in crate::description) fn check_overlay(
    log: Option<&Log>,
    over: &Log,
    path: &[&str],
) -> Result<(), Fault> {
    let own = over.columns().iter().any(|(_, columns)| columns.is_some());
    let of_columns = |log: &Log| {
        let listed = log.file.as_ref().map_or(0, Vec::len);
        log.files().nth(listed).cloned()
    };
    match log.and_then(of_columns) {
        Some(other) if over.file.is_some() && !own => Err(fault(
            &[path, &["file"]].concat(),
            format!(
                "{} holds columns of [log] and belongs to its recording; name the columns of this log \
                 as well",
                other.display()
            ),
        )),
        _ => Ok(()),
    }
}

fn check_time(log: &Log, path: &[&str]) -> Result<(), Fault> {
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
            format!("{first} and {second} say the same thing twice; keep one"),
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
                "period_s = {period} says when samples were taken: at whole multiples of it; keep it or \
                 sampling"
            ),
        ));
    }
    let Some(time) = &log.time else { return Ok(()) };
    let at = [path, &["time"]].concat();
    let dimension = time.unit.map(Unit::dimension);
    if time.topic.is_none() && dimension.is_none() {
        let units = Unit::names_of(&[Dimension::Time]);
        return Err(fault(
            &at,
            format!(
                "time does not say its unit; write time_s, time_ms, time_us or time_ns, or give a \
                 unit: {}",
                quoted(&units)
            ),
        ));
    }
    if dimension.is_some_and(|dimension| dimension != Dimension::Time) {
        let units = Unit::names_of(&[Dimension::Time]);
        return Err(fault(
            &at,
            format!("time is measured in {}", quoted(&units)),
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

fn check_csv(log: &Log, path: &[&str]) -> Result<(), Fault> {
    let Some(form) = &log.csv else { return Ok(()) };
    let one = |text: &String| text.len() == 1 && text.is_ascii();
    let words = ["space", "tab"];
    let wrong = |key: &str, value: &str, what: &str| {
        fault(
            &[path, &["csv", key]].concat(),
            format!("{key} = {value:?} is not understood; write {what}"),
        )
    };
    if let Some(text) =
        (form.delimiter.as_ref()).filter(|t| !one(t) && !words.contains(&t.as_str()))
    {
        let what = "one character, \"tab\", or \"space\" for any number of blanks";
        return Err(wrong("delimiter", text, what));
    }
    if let Some(text) = (form.decimal.as_ref()).filter(|t| ![".", ","].contains(&t.as_str())) {
        return Err(wrong("decimal", text, "\".\" or \",\""));
    }
    if let Some(text) = form.comment.as_ref().filter(|text| !one(text)) {
        return Err(wrong("comment", text, "one character"));
    }
    if let (Some(delimiter), Some(decimal)) = (&form.delimiter, &form.decimal)
        && delimiter == decimal
    {
        return Err(wrong(
            "decimal",
            decimal,
            "another character than that between cells",
        ));
    }
    Ok(())
}
