//! Checks of a log: one column per joint, and one source for each signal.

use std::path::PathBuf;

use sprung_core::chain::JointKind;

use super::columns::check_columns;
use super::fault::{Fault, fault};
use super::inertial::check_inertial;
use super::time::check_time;
use crate::columns::Columns;
use crate::factor::{Delay, Factor};
use crate::instruments::{Instrument, LinkPosition};
use crate::known_words::nearest;
use crate::log::Log;
use crate::numbers::Shown;
use crate::quantities::{Joints, Key, Quantity, Scaling, Signal};
use crate::robot::{Joint, Robot, SpringTerm};
use crate::window::FilePart;

/// Longest delay of a channel, s.
const MAX_DELAY_S: f64 = 60.0;

/// Checks that a key has a column for each of its joints, and returns their indices.
///
/// - `which`: whether rigid joints have a column as well; the log of a rigid robot may call its only
///   positions link positions.
fn check_length(
    (key, list): (&Key, &Columns),
    which: Joints,
    path: &[&str],
    (robot, log): (&Robot, &Log),
) -> Result<Vec<usize>, Fault> {
    let joints = key.joints_in(log, which, robot);
    if list.spread().is_some() && !joints.is_empty() {
        return Ok(joints);
    }
    let count = list.0.len();
    // One column of a covariate holds for all joints.
    if count == 1 && matches!(key.signal(), Signal::Covariate(_)) && !joints.is_empty() {
        return Ok(joints[..1].to_vec());
    }
    let name = |i: &usize| robot.joint[*i].name.as_str();
    let flexible_only = key.signal().is_of_flexible_joints() && which == Joints::ThatHaveIt;
    let with_rigid = key.joints_in(log, Joints::Rigid, robot);
    if flexible_only && joints.len() < with_rigid.len() && count == with_rigid.len() {
        let rigid = with_rigid.iter().find(|i| !joints.contains(i));
        let key = key.name;
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
    let what = match key.kind {
        _ if flexible_only && joints.len() < robot.joint.len() => "flexible ",
        Some(kind) if !flexible_only => turning(robot, kind),
        _ => "",
    };
    let names: Vec<&str> = joints.iter().map(name).collect();
    let has = match &names[..] {
        [] => format!("no {what}joints"),
        names => format!("{} {what}joints ({})", names.len(), names.join(", ")),
    };
    Err(fault(
        path,
        format!("{} names {count} columns, the robot has {has}", key.name),
    ))
}

/// Returns the word for a kind of joints if the robot has joints of another kind; otherwise nothing.
fn turning(robot: &Robot, kind: JointKind) -> &'static str {
    let mixed = (0..robot.joint.len()).any(|i| robot.kind(i) != kind);
    match kind {
        _ if !mixed => "",
        JointKind::Revolute => "revolute ",
        JointKind::Prismatic => "prismatic ",
    }
}

pub(crate) fn check_log(log: &Log, path: &[&str], robot: &Robot) -> Result<(), Fault> {
    let at = |key| [path, &[key]].concat();
    let rigid = !robot.has_springs();
    let lone = rigid && !Key::of(Signal::Motor).any(|key| key.is_given(log));
    check_twice(log, path, robot)?;
    for (key, list) in log.given() {
        let which = if lone && key.quantity == Quantity::LinkPosition {
            Joints::Rigid
        } else {
            Joints::ThatHaveIt
        };
        let joints = check_length((key, list), which, &at(key.name), (robot, log))?;
        check_columns(key, list, &joints, &at(key.name), robot)?;
    }
    check_inertial(log, path, robot)?;
    check_springs(log, robot)?;
    check_voltages(log, path, robot)?;
    check_sides(log, path)?;
    check_files(log, path)?;
    check_time(log, path)?;
    check_csv(log, path)?;
    let labels = check_labels(log, path)?;
    check_by_column(log, path, &labels)
}

/// Checks that positions show the deflection of each spring with hysteresis or play.
fn check_springs(log: &Log, robot: &Robot) -> Result<(), Fault> {
    for (i, joint) in robot.joint.iter().enumerate() {
        let is_shown = Instrument::of(i, log, robot).link_position() == LinkPosition::Column;
        let hidden = (joint.spring_terms().iter())
            .find(|term| matches!(term, SpringTerm::Hysteresis | SpringTerm::Play));
        if let Some(term) = hidden.filter(|_| !is_shown) {
            let (name, law) = (&joint.name, term.word());
            return Err(fault(
                &["robot", "joint", &i.to_string(), "spring"],
                format!(
                    "{name}: no position of its link shows the {law} of its spring; give [log] a column of the link position or \
                     of the deflection, or leave \"{law}\" out of spring"
                ),
            ));
        }
    }
    Ok(())
}

/// Checks that each signal has at most one key for revolute and one for prismatic joints, or one key
/// for all joints or for those of the other kind.
fn check_twice(log: &Log, path: &[&str], robot: &Robot) -> Result<(), Fault> {
    for signal in Signal::all().chain([Signal::Target, Signal::Switch]) {
        let given: Vec<&Key> = Key::of(signal).filter(|key| key.is_given(log)).collect();
        if let [first, second, ..] = given[..]
            && overlap(first.kind, second.kind)
            && !shares_joints([first, second], log, robot)
        {
            return Err(fault(
                &[path, &[second.name]].concat(),
                format!(
                    "{} and {} both give {}; keep one",
                    first.name,
                    second.name,
                    signal.words()
                ),
            ));
        }
    }
    Ok(())
}

/// Checks that no column is named twice, and returns the names of all columns for messages.
fn check_labels(log: &Log, path: &[&str]) -> Result<Vec<String>, Fault> {
    let mut labels: Vec<String> = Vec::new();
    let mut columns: Vec<(&Option<PathBuf>, String)> = Vec::new();
    for (key, list) in log.given() {
        let entries = match list.spread() {
            Some(one) => one.entries(),
            None => list.0.len(),
        };
        for i in 0..entries {
            let label = list.label(i, key.default_field());
            let file = list.of(i).map_or(&None, |(column, _)| &column.file);
            // The messages of a topic name their joints, so several joints share one field.
            let topic = list.of(i).is_some_and(|(column, _)| column.topic.is_some());
            if !topic && columns.iter().any(|known| *known == (file, label.clone())) {
                return Err(fault(
                    path,
                    format!(
                        "the column \"{label}\" is named twice; each column contains one quantity"
                    ),
                ));
            }
            columns.push((file, label.clone()));
            labels.push(label);
        }
    }
    Ok(labels)
}

/// Checks `delay_s`, `sign` and `gain`, whose keys are names of columns.
fn check_by_column(log: &Log, path: &[&str], labels: &[String]) -> Result<(), Fault> {
    let columns: Vec<&str> = labels.iter().map(String::as_str).collect();
    for (key, name) in (log.delay_s.keys().map(|name| ("delay_s", name)))
        .chain(log.sign.keys().map(|name| ("sign", name)))
        .chain(log.gain.keys().map(|name| ("gain", name)))
    {
        // "q*[joint2]" selects one column of a pattern.
        let common = name
            .split_once('[')
            .map_or(name.as_str(), |(common, _)| common);
        if !columns.contains(&name.as_str()) && !columns.contains(&common) {
            let hint = nearest(name, columns.iter().copied())
                .map_or_else(String::new, |known| format!("; did you mean \"{known}\"?"));
            return Err(fault(
                &[path, &[key, name]].concat(),
                format!("{key} names \"{name}\", which is not a column of this log{hint}"),
            ));
        }
    }
    for (name, delay) in log.delay_s.iter() {
        if let Delay::Known(value) = delay
            && (value.is_nan() || value.abs() > MAX_DELAY_S)
        {
            return Err(fault(
                &[path, &["delay_s", name]].concat(),
                format!(
                    "the delay of \"{name}\" is {} s; it must be within ±{MAX_DELAY_S} s",
                    Shown(*value)
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
                format!(
                    "the sign of \"{name}\" is {}; it must be 1 or -1, or \"estimate\"",
                    Shown(*sign)
                ),
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
                    "the gain of \"{name}\" is {gain}; it must be positive, or \"estimate\"; use sign \
                     for a reversed column"
                ),
            ));
        }
    }
    Ok(())
}

/// Returns whether a key for all joints leaves its own joints to another key for joints of one kind.
fn shares_joints(keys: [&Key; 2], log: &Log, robot: &Robot) -> bool {
    let has_joints = |key: &Key| !key.joints_in(log, Joints::Rigid, robot).is_empty();
    keys[0].kind != keys[1].kind && keys.into_iter().all(has_joints)
}

/// Returns whether two keys have joints of the same kind.
///
/// - `a`, `b`: their kinds of joints; `None` for all kinds.
fn overlap(a: Option<JointKind>, b: Option<JointKind>) -> bool {
    a.zip(b).is_none_or(|(a, b)| a == b)
}

/// Checks that a log contains the voltage of each voltage drive: a torque or a current already lacks
/// the part of the back-EMF.
fn check_voltages(log: &Log, path: &[&str], robot: &Robot) -> Result<(), Fault> {
    let driven = |joint: &&Joint| joint.back_emf_vs_per_rad.is_some();
    let Some(joint) = robot.joint.iter().find(driven) else {
        return Ok(());
    };
    let given = (Key::of(Signal::Torque)).find(|key| key.is_given(log));
    let Some(key) = given.filter(|key| key.scaling != Scaling::AmplifierGain) else {
        return Ok(());
    };
    let (name, key) = (&joint.name, key.name);
    Err(fault(
        &[path, &[key]].concat(),
        format!(
            "{name} has a back-EMF, which lowers the torque of a voltage, but {key} is no voltage; give \
             drive_voltage_v, or remove back_emf_vs_per_rad and winding_resistance_ohm"
        ),
    ))
}

fn check_sides(log: &Log, path: &[&str]) -> Result<(), Fault> {
    for (key, list) in log.given() {
        let Some(side_key) = key.side_key() else {
            continue;
        };
        let side = log.side(key.scaling);
        if (list.0.iter()).any(|column| column.side.is_some() && column.side != side) {
            let key = key.name;
            return Err(fault(
                &[path, &[key]].concat(),
                format!("{key} gives two sides of the gearbox; give one side, as {side_key}"),
            ));
        }
    }
    Ok(())
}

fn check_files(log: &Log, path: &[&str]) -> Result<(), Fault> {
    let at = [path, &["file"]].concat();
    let files = log.file.as_deref().unwrap_or_default();
    for (i, file) in files.iter().enumerate() {
        if file.path.as_os_str().is_empty() {
            let message = "file in [log] is an empty name; give the path of the log";
            return Err(fault(&at, message.to_owned()));
        }
        check_file(file, &at)?;
        let again =
            |other: &&FilePart| other.path == file.path && other.window.overlaps(&file.window);
        let Some(other) = files[..i].iter().find(again) else {
            continue;
        };
        let path = file.path.display();
        let message = if other.window == file.window {
            format!("{path} is listed twice; its samples would count twice")
        } else {
            format!(
                "{path} is listed with two windows that overlap, {other} and {file}; samples in both \
                 would count twice"
            )
        };
        return Err(fault(&at, message));
    }
    if files.len() > 1
        && let Some(other) = log.files().nth(files.len())
    {
        return Err(fault(
            &at,
            format!(
                "{} contains columns of one log, but file names {} logs; identify from one log, or \
                 put all columns of a log into one file",
                other.display(),
                files.len()
            ),
        ));
    }
    Ok(())
}

/// Checks the window of a file.
fn check_file(file: &FilePart, at: &[&str]) -> Result<(), Fault> {
    let (path, window) = (file.path.display(), file.window);
    let times = [("from_s", window.from_s), ("to_s", window.to_s)];
    let wrong = |key: &str, message: String| Err(fault(&[at, &[key]].concat(), message));
    if let Some((key, Some(time))) =
        (times.into_iter()).find(|(_, time)| time.is_some_and(|time| !time.is_finite()))
    {
        return wrong(
            key,
            format!("{key} = {time} of {path} must be a finite time in s"),
        );
    }
    for (by_time, by_index, keys) in [
        (window.from_s, window.from_index, ["from_s", "from_index"]),
        (window.to_s, window.to_index, ["to_s", "to_index"]),
    ] {
        if by_time.is_some() && by_index.is_some() {
            let [time, index] = keys;
            return wrong(
                index,
                format!("{time} and {index} of {path} both bound the window; keep one"),
            );
        }
    }
    if window.is_empty() {
        let key = if window.to_s.is_some() {
            "to_s"
        } else {
            "to_index"
        };
        return wrong(
            key,
            format!(
                "the window of {path}, {window}, is empty; its end must lie after its beginning, and \
                 the sample at its end does not belong to it"
            ),
        );
    }
    Ok(())
}

/// Checks that a validation log with its own file does not take columns from the recording of
/// `[log]`, and that delays, signs and gains of `[log]` apply to its columns.
pub(crate) fn check_overlay(
    log: Option<&Log>,
    over: &Log,
    path: &[&str],
    robot: &Robot,
) -> Result<(), Fault> {
    if let Some(open) = log.and_then(|log| log.ambiguous(over, robot)) {
        let (table, name, label) = (open.table, open.name, open.label);
        return Err(fault(
            path,
            format!(
                "{table} of \"{name}\" in [log] has no clear meaning for \"{label}\": {}; give \
                 {table} = {{ \"{label}\" = … }} for this log",
                open.reason
            ),
        ));
    }
    let has_columns = over.given().next().is_some();
    let of_columns = |log: &Log| {
        let listed = log.file.as_ref().map_or(0, Vec::len);
        log.files().nth(listed).cloned()
    };
    match log.and_then(of_columns) {
        Some(other) if over.file.is_some() && !has_columns => Err(fault(
            &[path, &["file"]].concat(),
            format!(
                "{} holds columns of [log], which belong to its recording; name the columns of this log \
                 as well",
                other.display()
            ),
        )),
        _ => Ok(()),
    }
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
            "a character other than the delimiter",
        ));
    }
    Ok(())
}
