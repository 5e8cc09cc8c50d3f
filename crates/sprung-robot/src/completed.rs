//! Lines of `[log]` that correct a mistake, completed by what the file says of other joints, columns and logs.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;
use toml::Value;

use super::columns::{Column, ColumnName, Columns, PerJoint, StartsAt};
use super::factor::{Delay, Factor};
use super::log::Log;
use super::quantities::{Joints, Key, KeyUnit, Signal};
use super::read::Experiment;
use super::robot::Robot;
use super::template::quoted;
use super::units::Unit;
use super::window::FilePart;

/// Table of the lines that are completed.
const LOG: &str = "[log] ";

/// Returns a product without the digits that rounding adds.
fn short(product: f64) -> f64 {
    format!("{product:.9e}").parse().unwrap_or(product)
}

impl Experiment {
    /// Returns the table and the lines of a correction that can replace the lines of the file with the same keys; `None`
    /// if no such lines are known.
    ///
    /// - `setting`: a table and lines, as in [`Finding::setting`](sprung_base::finding::Finding::setting).
    #[must_use]
    pub fn completed(&self, setting: &str) -> Option<String> {
        let (Some(lines), Some(log)) = (setting.strip_prefix(LOG), &self.log) else {
            return Some(setting.to_owned());
        };
        let lines: Option<Vec<String>> = lines.lines().map(|line| self.line(log, line)).collect();
        Some(format!("{LOG}{}", lines?.join("\n")))
    }

    fn line(&self, log: &Log, line: &str) -> Option<String> {
        let table: toml::Table = toml::from_str(line).ok()?;
        let (key, value) = table.into_iter().next()?;
        let number = |value: &Value| value.as_float().or(value.as_integer().map(|k| k as f64));
        match key.as_str() {
            "sign" | "gain" => {
                let given = if key == "sign" { &log.sign } else { &log.gain };
                let mut all: BTreeMap<String, String> = (given.iter())
                    .map(|(column, factor)| (column.clone(), factor_text(*factor)))
                    .collect();
                for (column, value) in value.as_table()? {
                    // The readings of the log were multiplied by the factor of the file.
                    let before = given.get(column).copied().and_then(Factor::known);
                    let text = match number(value) {
                        Some(factor) => short(factor * before.unwrap_or(1.0)).to_string(),
                        None => value.to_string(),
                    };
                    all.insert(column.clone(), text);
                }
                Some(format!("{key} = {}", table_of(&all)))
            }
            "delay_s" => {
                let mut all: BTreeMap<String, String> = (log.delay_s.iter())
                    .map(|(column, delay)| (column.clone(), delay_text(*delay)))
                    .collect();
                let now = value.as_table()?.iter();
                all.extend(now.map(|(column, value)| (column.clone(), value.to_string())));
                Some(format!("delay_s = {}", table_of(&all)))
            }
            "file" => self.files(&value),
            "time" => {
                let unit = Unit::try_from(value.get("unit")?.as_str()?.to_owned()).ok();
                let time = log.time.clone()?;
                Some(format!("time = {}", Column { unit, ..time }.text()?))
            }
            "time_s" | "time_ms" | "time_us" | "time_ns" => {
                let given = [
                    ("time_s", &log.time_s),
                    ("time_ms", &log.time_ms),
                    ("time_us", &log.time_us),
                    ("time_ns", &log.time_ns),
                ];
                let given = given.into_iter().find(|(_, column)| column.is_some());
                Some(given.map_or(line.to_owned(), |(given, _)| {
                    format!("{line}  # in place of {given}")
                }))
            }
            _ => match log.given().find(|(known, _)| known.name == key) {
                Some((known, _)) => columns(known, value, log, &self.robot),
                None => match Key::named(&key) {
                    Some(known) => columns(known, value, log, &self.robot),
                    None => Some(line.to_owned()),
                },
            },
        }
    }

    /// Returns the line of files for their names with their windows in words, or for parts of one file.
    fn files(&self, value: &Value) -> Option<String> {
        let of_validation = (self.validate.iter()).filter_map(|run| run.log.as_ref());
        let known: Vec<&FilePart> = (self.log.iter().chain(of_validation))
            .flat_map(|log| log.file.iter().flatten())
            .collect();
        let is_named = |part: &FilePart, name: &str| {
            let alone = part.window.without(name);
            part.window.of(&alone) == name && Path::new(&alone).ends_with(&part.path)
        };
        let all = value.as_array()?;
        let whole = |part: &&&FilePart, name: &str| part.window.is_whole() && is_named(part, name);
        let mut lines = Vec::new();
        match all.first()?.get("path").and_then(Value::as_str) {
            None => {
                for name in all {
                    let name = name.as_str()?;
                    lines.push(file_text(known.iter().find(|part| is_named(part, name))?)?);
                }
            }
            // Parts of one file take its place among the files.
            Some(name) => {
                let part = known.iter().find(|part| whole(part, name))?;
                for file in self.log.iter().flat_map(|log| log.file.iter().flatten()) {
                    if file != *part {
                        lines.push(file_text(file)?);
                        continue;
                    }
                    for one in all {
                        let mut table = one.as_table()?.clone();
                        table.insert("path".to_owned(), part.path.to_str()?.into());
                        lines.push(Value::Table(table).to_string());
                    }
                }
            }
        }
        Some(format!("file = [{}]", lines.join(", ")))
    }
}

/// The column of one joint.
#[derive(Clone)]
struct Entry {
    joint: usize,
    label: String,
    column: Column,
    /// The key without its unit.
    stem: &'static str,
}

/// Returns the columns of a signal, one entry for each joint with its unit; `None` if the file names them by a pattern.
fn entries(signal: Signal, log: &Log, robot: &Robot) -> Option<Vec<Entry>> {
    let mut all = Vec::new();
    for (key, columns) in log.given().filter(|(key, _)| key.signal() == signal) {
        for (k, joint) in joints_of(key, log, robot).into_iter().enumerate() {
            let (column, place) = columns.of(k)?;
            let name = &robot.joint[joint].name;
            let (label, _) = columns.labels(k, name, key.default_field());
            let mut column = column.alone(place, name)?;
            column.unit = column.unit.or_else(|| unit_of(key.name));
            all.push(Entry {
                joint,
                label,
                column,
                stem: stem_of(key),
            });
        }
    }
    Some(all)
}

/// Returns the joints with columns of a key.
fn joints_of(key: &Key, log: &Log, robot: &Robot) -> Vec<usize> {
    let joints = key.joints_in(log, Joints::ThatHaveIt, robot);
    if joints.is_empty() {
        return key.joints_in(log, Joints::Rigid, robot);
    }
    joints
}

/// Returns the entry of a column that a line names, unless it comes from another signal with a side of its own: whether the side
/// belongs to the column or to its place is not known.
///
/// - `of_signal`: entries of the signal of the line.
fn source<'e>(known: &'e [Entry], of_signal: &[Entry], name: &str) -> Option<&'e Entry> {
    let source = known.iter().find(|entry| entry.label == name)?;
    let is_moved = of_signal.iter().all(|entry| entry.label != name);
    (!is_moved || source.column.side.is_none()).then_some(source)
}

fn columns(key: &Key, value: Value, log: &Log, robot: &Robot) -> Option<String> {
    let given = Columns::deserialize(value).ok()?;
    let alone = |k: usize| {
        let (column, place) = given.of(k)?;
        column.column.as_ref()?.get(place)?;
        column.alone(place, &robot.joint[k].name)
    };
    let named: Vec<Column> = (0..robot.joint.len()).map_while(alone).collect();
    let rest = given.of(named.len());
    let is_end = |(column, place): (&Column, usize)| {
        (column.column.as_ref()).is_some_and(|names| names.get(place).is_none())
    };
    // Fields of topics and patterns have no columns of their own.
    if named.is_empty() || named.len() < robot.joint.len() && !rest.is_none_or(is_end) {
        return None;
    }
    let signals = [Signal::Link, Signal::Motor, Signal::Torque, Signal::Spring];
    let known: Vec<Entry> = (signals.into_iter())
        .map(|signal| entries(signal, log, robot))
        .collect::<Option<Vec<_>>>()?
        .concat();
    let mut of_signal = entries(key.signal(), log, robot)?;
    let is_given = key.is_given(log);
    let mut joints = joints_of(key, log, robot);
    if joints.is_empty() {
        joints = of_signal.iter().map(|entry| entry.joint).collect();
    }
    for (k, one) in named.iter().enumerate() {
        let name = one.column.as_ref()?.get(0)?.to_string();
        let source = source(&known, &of_signal, &name)?;
        let joint = if named.len() == joints.len() {
            joints[k]
        } else {
            source.joint
        };
        let place = of_signal.iter().position(|entry| entry.joint == joint)?;
        let mut column = source.column.clone();
        if !is_given || one.unit.is_some() {
            column.unit = one.unit.or_else(|| unit_of(key.name)).or(column.unit);
        }
        column.wrap = one.wrap.clone().or(column.wrap);
        of_signal[place].column = column;
        of_signal[place].stem = stem_of(key);
    }
    let of_key: Vec<&Entry> = of_signal
        .iter()
        .filter(|entry| joints.contains(&entry.joint))
        .collect();
    let unit = of_key.first()?.column.unit;
    let stem = of_signal.first()?.stem;
    let is_plain = |entry: &&Entry| entry.column.is_plain() && entry.column.unit == unit;
    let by_name = |entry: &&Entry| {
        entry
            .column
            .column
            .as_ref()?
            .get(0)
            .map(|name| name_text(&name))
    };
    let in_key = || {
        let names: Option<Vec<String>> = of_key.iter().map(by_name).collect();
        let given = Key::of(key.signal())
            .filter(|known| stem_of(known) == stem && known.kind.is_some())
            .find(|known| {
                unit.is_some()
                    && unit_of(known.name) == unit
                    && known.joints(Joints::Rigid, robot).len() >= of_key.len()
            })?;
        // A key that another one keeps away takes its place.
        let own = joints_of(given, log, robot);
        (own.is_empty() || own == joints).then_some(format!(
            "{} = [{}]",
            given.name,
            names?.join(", ")
        ))
    };
    // One table has the columns of all joints.
    let in_table = || {
        let names: Option<Vec<String>> = of_signal.iter().map(|entry| by_name(&entry)).collect();
        let has_all = of_key.len() == of_signal.len() && of_signal.len() > 1;
        let unit = quoted(unit.filter(|_| has_all)?.name());
        let names = names?.join(", ");
        Some(format!("{stem} = {{ column = [{names}], unit = {unit} }}"))
    };
    let is_plain = of_key.iter().all(is_plain);
    let line = is_plain.then(|| in_key().or_else(in_table)).flatten();
    let line = line.or_else(|| {
        let all: Option<Vec<String>> = of_signal.iter().map(|entry| entry.column.text()).collect();
        Some(format!("{stem} = [{}]", all?.join(", ")))
    })?;
    let replaced: Vec<&str> = Key::of(key.signal())
        .filter(|known| known.is_given(log) && !line.starts_with(&format!("{} =", known.name)))
        .filter(|known| {
            let has_all = of_key.len() == of_signal.len();
            has_all || line.starts_with(&format!("{stem} =")) || known.kind == key.kind
        })
        .map(|known| known.name)
        .collect();
    Some(match &replaced[..] {
        [] => line,
        keys => format!("{line}  # in place of {}", keys.join(" and ")),
    })
}

/// Returns the unit in the name of a key.
fn unit_of(key: &str) -> Option<Unit> {
    let name = match key.rsplit_once('_')?.1 {
        "nm" => "N·m",
        "n" => "N",
        "a" => "A",
        "v" => "V",
        other => other,
    };
    Unit::try_from(name.to_owned()).ok()
}

/// Returns the name of the key that has the units in its columns.
fn stem_of(key: &Key) -> &'static str {
    let same = |other: &&Key| other.quantity == key.quantity && other.scaling == key.scaling;
    let is_said = |other: &&Key| matches!(other.unit, KeyUnit::Said { .. });
    Key::of(key.signal())
        .filter(same)
        .find(is_said)
        .map_or(key.name, |key| key.name)
}

fn name_text(name: &ColumnName) -> String {
    match name {
        ColumnName::Name(name) => quoted(name),
        ColumnName::Number(number) => number.to_string(),
    }
}

fn factor_text(factor: Factor) -> String {
    (factor.known()).map_or("\"estimate\"".to_owned(), |value| value.to_string())
}

fn delay_text(delay: Delay) -> String {
    match delay {
        Delay::Known(value) => value.to_string(),
        Delay::Estimate => "\"estimate\"".to_owned(),
    }
}

fn table_of(all: &BTreeMap<String, String>) -> String {
    let parts: Vec<String> = (all.iter())
        .map(|(column, value)| format!("{} = {value}", quoted(column)))
        .collect();
    format!("{{ {} }}", parts.join(", "))
}

fn file_text(part: &FilePart) -> Option<String> {
    let path = quoted(part.path.to_str()?);
    if part.payload.is_some() {
        return None;
    }
    if part.window.is_whole() {
        return Some(path);
    }
    let window = part.window;
    let mut parts = vec![format!("path = {path}")];
    parts.extend(window.from_s.map(|time| format!("from_s = {time:?}")));
    parts.extend(window.to_s.map(|time| format!("to_s = {time:?}")));
    parts.extend(
        window
            .from_index
            .map(|index| format!("from_index = {index}")),
    );
    parts.extend(window.to_index.map(|index| format!("to_index = {index}")));
    Some(format!("{{ {} }}", parts.join(", ")))
}

impl Column {
    /// Returns the entry of one joint of an entry of several; `None` if a pattern names its column.
    ///
    /// - `place`: place of the joint in the entry; `joint`: its name.
    fn alone(&self, place: usize, joint: &str) -> Option<Self> {
        fn at<T: Clone>(of: Option<&PerJoint<T>>, place: usize) -> Option<PerJoint<T>> {
            of?.get(place).map(PerJoint::One)
        }
        let column = at(self.column.as_ref(), place);
        if matches!(&column, Some(PerJoint::One(name)) if name.is_pattern()) {
            return None;
        }
        let in_messages = (self.joint_names.as_ref())
            .and_then(|names| names.get(place))
            .map_or(joint, String::as_str);
        let joint_names = self.topic.is_some().then(|| vec![in_messages.to_owned()]);
        Some(Self {
            column,
            field: at(self.field.as_ref(), place),
            joint_names,
            counts_per_turn: at(self.counts_per_turn.as_ref(), place),
            sign: at(self.sign.as_ref(), place),
            offset: at(self.offset.as_ref(), place),
            gain: at(self.gain.as_ref(), place),
            wrap: at(self.wrap.as_ref(), place),
            starts_at_rad: at(self.starts_at_rad.as_ref(), place),
            ..self.clone()
        })
    }

    /// Returns whether it has a column and a unit alone.
    fn is_plain(&self) -> bool {
        let bare = Self {
            column: self.column.clone(),
            unit: self.unit,
            ..Self::default()
        };
        *self == bare
    }

    /// Returns its table as TOML.
    fn text(&self) -> Option<String> {
        let number = |key: &str, of: &Option<PerJoint<f64>>| {
            let value = of.as_ref()?.get(0)?;
            Some(format!("{key} = {value:?}"))
        };
        let text = |key: &str, value: Option<String>| value.map(|value| format!("{key} = {value}"));
        let file = match &self.file {
            Some(file) => Some(quoted(file.to_str()?)),
            None => None,
        };
        let start = self.starts_at_rad.as_ref().and_then(|start| start.get(0));
        let parts = [
            text("file", file),
            text("topic", self.topic.as_deref().map(quoted)),
            text(
                "field",
                self.field
                    .as_ref()
                    .and_then(|field| field.get(0))
                    .map(|field| quoted(&field)),
            ),
            text(
                "joint_names",
                self.joint_names.as_ref().map(|names| {
                    format!(
                        "[{}]",
                        names
                            .iter()
                            .map(|name| quoted(name))
                            .collect::<Vec<_>>()
                            .join(", ")
                    )
                }),
            ),
            text(
                "column",
                self.column
                    .as_ref()
                    .and_then(|name| name.get(0))
                    .map(|name| name_text(&name)),
            ),
            text("time", self.time.as_ref().map(name_text)),
            text("unit", self.unit.map(|unit| quoted(unit.name()))),
            text("side", self.side.map(|side| quoted(side.word()))),
            number("counts_per_turn", &self.counts_per_turn),
            number("sign", &self.sign),
            number("offset", &self.offset),
            number("gain", &self.gain),
            number("wrap", &self.wrap),
            text(
                "starts_at_rad",
                start.map(|start| match start {
                    StartsAt::Position(position) => format!("{position:?}"),
                    StartsAt::Column(name) => quoted(&name),
                }),
            ),
        ];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        Some(format!("{{ {} }}", parts.join(", ")))
    }
}
