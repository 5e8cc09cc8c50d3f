//! Topics of bags: each message becomes a row.

use std::collections::VecDeque;

use super::cdr::{Found, Step, decode};
use super::definition::{Base, Count, Definition};
use super::number::Reading;
use super::table::{Element, ElementPlace, NAMES, Opened, Readings, Request, Table};
use crate::columns::names::listed;
use crate::columns::origin::Pick;
use crate::error::{LogError, Place};
use crate::named::edits;

/// A message of a topic.
#[derive(Clone, Debug)]
pub(super) struct Message {
    /// Time of reception, ns.
    pub(super) time: i64,
    pub(super) data: Vec<u8>,
}

/// The messages of one topic, in the order of the file.
pub(super) trait Messages: Send {
    /// Returns the next message, `None` at the end.
    fn next(&mut self) -> Result<Option<Message>, LogError>;
}

/// An open topic.
pub(super) struct Topic {
    pub(super) kind: String,
    pub(super) definition: Definition,
    pub(super) messages: Box<dyn Messages>,
}

/// Source of the time of a message.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Clock {
    Received,
    /// The field at the first path.
    Stamp,
}

struct BagTable {
    file: String,
    topic: Topic,
    clock: Clock,
    // Whether the experiment names no time. The table then uses the stamp if the recorder set it.
    usual: bool,
    paths: Vec<Vec<Step>>,
    found: Vec<Found>,
    // Messages that `settle_clock` took from the topic before the first row.
    ahead: VecDeque<Message>,
    // Number of the message of each row of the last block, counted from 1 in the topic.
    places: Vec<u64>,
    number: u64,
    any: bool,
    strangers: Vec<String>,
}

/// Returns the error for a bag if the experiment names no topic.
pub(super) fn no_topic(file: &str, topics: &[&str]) -> LogError {
    LogError::format(
        file,
        format!(
            " is a bag; say which topic contains each quantity, as link_position = {{ topic = \"{}\", unit = \
             \"rad\" }}, and remove time_s, because messages contain their time; it has {}",
            topics.first().unwrap_or(&"/joint_states"),
            listed(topics)
        ),
    )
}

/// Returns the error for a topic that the bag does not contain.
pub(super) fn absent(file: &str, topic: &str, topics: &[&str]) -> LogError {
    let distance = |name: &&str| edits(topic, name);
    let nearest = (topics.iter().copied())
        .min_by_key(distance)
        .filter(|name| distance(name) <= 1 + name.chars().count() / 2);
    let hint = match nearest {
        _ if topics.is_empty() => "it has no topics at all".to_owned(),
        Some(name) => format!("did you mean \"{name}\"?"),
        None => format!("it has {}", listed(topics)),
    };
    LogError::format(file, format!(" has no topic \"{topic}\"; {hint}"))
}

/// Opens a topic as a table.
pub(super) fn table(request: &Request<'_>, topic: Topic) -> Result<Opened, LogError> {
    let wrong = |message: String| {
        LogError::format(
            request.file,
            format!(": {} ({}) {message}", "its messages", topic.kind),
        )
    };
    let mut paths = Vec::new();
    let mut names = Vec::new();
    let mut clock = Clock::Received;
    let mut usual = false;
    for (i, pick) in request.picks.iter().enumerate() {
        if request.time == Some(i) {
            let time = time_path(&topic.definition, pick).map_err(wrong)?;
            (clock, usual) = (time.clock, time.is_usual);
            paths.push(time.path);
            names.push("time".to_owned());
        } else {
            let (path, name) = path_of(&topic.definition, pick).map_err(wrong)?;
            paths.push(path);
            names.push(name);
        }
    }
    let table = BagTable {
        file: request.file.to_owned(),
        topic,
        clock,
        usual,
        found: vec![None; paths.len()],
        paths,
        ahead: VecDeque::new(),
        places: Vec::new(),
        number: 0,
        any: false,
        strangers: Vec::new(),
    };
    Ok(Opened {
        table: Box::new(table),
        names,
        time_unit: Some(1e-9),
        all: Vec::new(),
        has_names: true,
        units: Vec::new(),
    })
}

/// The source of the time of messages.
struct TimePath {
    clock: Clock,
    /// Whether it was chosen by default.
    is_usual: bool,
    /// Path of the stamp.
    path: Vec<Step>,
}

fn time_path(definition: &Definition, pick: &Pick) -> Result<TimePath, String> {
    let time = |clock, is_usual, path| TimePath {
        clock,
        is_usual,
        path,
    };
    let field = pick.to_string();
    let is_time = |path: &[Step]| matches!(end_of(definition, path), Some((Base::Message(kind), Count::One)) if definition.is_time(kind));
    match field.as_str() {
        "log_time" => Ok(time(Clock::Received, false, Vec::new())),
        "" => {
            let usual = ["header.stamp", "stamp"].map(steps);
            Ok(
                match usual.into_iter().flatten().find(|path| is_time(path)) {
                    Some(path) => time(Clock::Stamp, true, path),
                    None => time(Clock::Received, false, Vec::new()),
                },
            )
        }
        _ => {
            let path = steps(&field).ok_or_else(|| format!("cannot have a field \"{field}\""))?;
            if is_time(&path) {
                return Ok(time(Clock::Stamp, false, path));
            }
            Err(format!(
                "have no time \"{field}\"; name a field of type builtin_interfaces/Time, or \"log_time\""
            ))
        }
    }
}

/// Returns the path of a column, and its name in messages.
fn path_of(definition: &Definition, pick: &Pick) -> Result<(Vec<Step>, String), String> {
    let Pick::Field {
        field,
        joint,
        index,
        of,
    } = pick
    else {
        return Err(format!(
            "have fields and no column \"{pick}\"; name a field"
        ));
    };
    let text = field.replace('*', &index.to_string());
    let strange = || {
        let leaves = definition.leaves();
        let leaves: Vec<&str> = leaves.iter().map(String::as_str).collect();
        let distance = |name: &&str| edits(&text, name);
        let nearest = (leaves.iter().copied().min_by_key(distance))
            .filter(|name| distance(name) <= 1 + name.chars().count() / 2);
        match nearest {
            Some(name) => format!("have no number \"{text}\"; did you mean \"{name}\"?"),
            None if leaves.is_empty() => {
                format!("have no number \"{text}\"; they contain no numbers")
            }
            None => format!("have no number \"{text}\"; they have {}", listed(&leaves)),
        }
    };
    let mut path = steps(&text).ok_or_else(strange)?;
    let Some((Base::Number(_), count)) = end_of(definition, &path) else {
        return Err(strange());
    };
    if count == Count::One {
        if *of > 1 && !field.contains('*') {
            return Err(format!(
                "have one number \"{text}\" for {of} joints; list the fields: field = [\"…\", \"…\"]"
            ));
        }
        return Ok((path, text));
    }
    if has_names(definition, &path) {
        path.push(Step::Named(joint.clone()));
        return Ok((path, format!("{text}[{joint}]")));
    }
    if let Count::Fixed(length) = count
        && length != *of
    {
        return Err(format!(
            "have {length} numbers \"{text}\" without names for {of} joints; list the elements: field \
             = [\"{text}[0]\", …]"
        ));
    }
    path.push(Step::Index(*index));
    Ok((path, format!("{text}[{index}]")))
}

/// Most elements of a list that a survey counts.
const MAX_ELEMENTS: usize = 64;

/// Returns the numbers in the first message of a topic, except times; none if it has no message.
///
/// # Errors
///
/// [`LogError`] if the message is damaged.
pub(super) fn elements(file: &str, mut topic: Topic) -> Result<Vec<Element>, LogError> {
    let Some(message) = topic.messages.next()? else {
        return Ok(Vec::new());
    };
    let definition = &topic.definition;
    let mut found = Vec::new();
    let mut decoded = |paths: &[Vec<Step>]| {
        found.resize(paths.len(), None);
        let names = decode(definition, &message.data, paths, &mut found).map_err(|what| {
            LogError::format(file, format!(": message 1 ({}) {what}", topic.kind))
        })?;
        let there: Vec<bool> = found.iter().map(Option::is_some).collect();
        Ok((names, there))
    };
    let mut all = Vec::new();
    for leaf in definition.leaves() {
        let Some(path) = steps(&leaf) else { continue };
        let Some((Base::Number(_), count)) = end_of(definition, &path) else {
            continue;
        };
        let list = |index: Step| [&path[..], &[index]].concat();
        if count != Count::One && has_names(definition, &path) {
            let (names, _) = decoded(&[])?;
            let paths: Vec<Vec<Step>> = (names.iter())
                .map(|name| list(Step::Named(name.clone())))
                .collect();
            let (_, there) = decoded(&paths)?;
            let present = names.into_iter().zip(there).filter(|(_, there)| *there);
            all.extend(present.map(|(name, _)| Element {
                field: leaf.clone(),
                place: ElementPlace::Named(name),
            }));
        } else if count != Count::One {
            let paths: Vec<Vec<Step>> = (0..MAX_ELEMENTS).map(|k| list(Step::Index(k))).collect();
            let (_, there) = decoded(&paths)?;
            let present = (0..MAX_ELEMENTS).take_while(|&k| there[k]);
            all.extend(present.map(|k| Element {
                field: leaf.clone(),
                place: ElementPlace::Index(k),
            }));
        } else if path.contains(&Step::Index(0)) {
            let field = leaf.replacen("[0]", "[*]", 1);
            let at = |k: usize| field.replacen('*', &k.to_string(), 1);
            let paths: Vec<Vec<Step>> = (0..MAX_ELEMENTS).filter_map(|k| steps(&at(k))).collect();
            let (_, there) = decoded(&paths)?;
            let present = there.iter().take_while(|there| **there).enumerate();
            all.extend(present.map(|(k, _)| Element {
                field: field.clone(),
                place: ElementPlace::Index(k),
            }));
        } else {
            all.push(Element {
                field: leaf,
                place: ElementPlace::Alone,
            });
        }
    }
    Ok(all)
}

/// Splits a path such as `motors[0].position[elbow]` into steps.
fn steps(text: &str) -> Option<Vec<Step>> {
    let mut all = Vec::new();
    for part in text.split('.') {
        let (name, mut rest) = part.split_at(part.find('[').unwrap_or(part.len()));
        if name.is_empty() {
            return None;
        }
        all.push(Step::Field(name.to_owned()));
        while let Some(inner) = rest.strip_prefix('[') {
            let (index, behind) = inner.split_once(']')?;
            all.push(match index.parse() {
                Ok(index) => Step::Index(index),
                Err(_) => Step::Named(index.to_owned()),
            });
            rest = behind;
        }
        if !rest.is_empty() {
            return None;
        }
    }
    Some(all)
}

/// Returns the type at the end of a path, `None` if no such field exists.
fn end_of(definition: &Definition, path: &[Step]) -> Option<(Base, Count)> {
    let mut at = (Base::Message(0), Count::One);
    for step in path {
        at = match (step, at) {
            (Step::Field(name), (Base::Message(kind), Count::One)) => {
                let field = definition.field(kind, name)?;
                (field.base, field.count)
            }
            (Step::Index(_) | Step::Named(_), (base, Count::Fixed(_) | Count::Any)) => {
                (base, Count::One)
            }
            _ => return None,
        };
    }
    Some(at)
}

/// Returns whether a message on the path contains a list of names.
fn has_names(definition: &Definition, path: &[Step]) -> bool {
    (0..path.len()).any(|length| match end_of(definition, &path[..length]) {
        Some((Base::Message(kind), Count::One)) => NAMES.iter().any(|name| {
            let field = definition.field(kind, name);
            field.is_some_and(|field| field.base == Base::Text && field.count != Count::One)
        }),
        _ => false,
    })
}

impl Table for BagTable {
    fn read(&mut self, limit: usize, out: &mut [Readings]) -> Result<usize, LogError> {
        self.places.clear();
        self.settle_clock()?;
        while self.places.len() < limit {
            let message = match self.ahead.pop_front() {
                Some(message) => message,
                None => match self.topic.messages.next()? {
                    Some(message) => message,
                    None => break,
                },
            };
            self.number += 1;
            if self.row(&message)? {
                for (i, (found, out)) in self.found.iter().zip(&mut *out).enumerate() {
                    match found {
                        _ if i == 0 && self.clock == Clock::Received => {
                            out.push_integer(message.time);
                        }
                        Some(reading) => out.push_reading(*reading),
                        None => out.push(f64::NAN),
                    }
                }
                self.places.push(self.number);
                self.any = true;
            }
        }
        if self.places.is_empty() && !self.any {
            return Err(self.nothing());
        }
        Ok(self.places.len())
    }

    fn place(&self, i: usize) -> Place {
        Place::Message(self.places.get(i).copied().unwrap_or_default())
    }
}

impl BagTable {
    /// Chooses the time of reception if the stamps of the first two messages are zero: the recorder did not
    /// set them.
    fn settle_clock(&mut self) -> Result<(), LogError> {
        if !std::mem::replace(&mut self.usual, false) {
            return Ok(());
        }
        let mut unset = true;
        for _ in 0..2 {
            let Some(message) = self.topic.messages.next()? else {
                break;
            };
            self.number += 1;
            self.decode(&message)?;
            self.number -= 1;
            unset &= self.found.first() == Some(&Some(Reading::Integer(0)));
            self.ahead.push_back(message);
        }
        if unset && self.ahead.len() == 2 {
            self.clock = Clock::Received;
        }
        Ok(())
    }

    fn decode(&mut self, message: &Message) -> Result<Vec<String>, LogError> {
        let definition = &self.topic.definition;
        decode(definition, &message.data, &self.paths, &mut self.found).map_err(|what| {
            LogError::format(
                &self.file,
                format!(": message {} ({}) {what}", self.number, self.topic.kind),
            )
        })
    }

    /// Reads a message; returns false if it contains none of the wanted joints.
    fn row(&mut self, message: &Message) -> Result<bool, LogError> {
        let names = self.decode(message)?;
        let named: Vec<&String> = (self.paths.iter().flatten())
            .filter_map(|step| match step {
                Step::Named(name) => Some(name),
                _ => None,
            })
            .collect();
        if !named.is_empty() && !named.iter().any(|name| names.contains(name)) {
            if self.strangers.is_empty() {
                self.strangers = names;
            }
            return Ok(false);
        }
        let wrong = |message: String| Err(LogError::format(&self.file, message));
        if let Some(missing) = named.iter().find(|name| !names.contains(name)) {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            return wrong(format!(
                ": message {} has no joint \"{missing}\"; it has {}",
                self.number,
                listed(&names)
            ));
        }
        for (path, found) in self.paths.iter().zip(&self.found) {
            if found.is_none() && !path.is_empty() {
                return wrong(format!(
                    ": message {} has no value at \"{}\"; the list is too short or empty",
                    self.number,
                    shown(path)
                ));
            }
        }
        Ok(true)
    }

    #[cold]
    fn nothing(&self) -> LogError {
        if self.strangers.is_empty() {
            return LogError::format(&self.file, " has no messages");
        }
        let names: Vec<&str> = self.strangers.iter().map(String::as_str).collect();
        let wanted = self.paths.iter().flatten().find_map(|step| match step {
            Step::Named(name) => Some(name.as_str()),
            _ => None,
        });
        LogError::format(
            &self.file,
            format!(
                " has no joint \"{}\"; its messages name {}; say joint_names = [\"…\"] beside the topic",
                wanted.unwrap_or_default(),
                listed(&names)
            ),
        )
    }
}

fn shown(path: &[Step]) -> String {
    let steps = path.iter().map(|step| match step {
        Step::Field(name) => format!(".{name}"),
        Step::Index(index) => format!("[{index}]"),
        Step::Named(name) => format!("[{name}]"),
    });
    let text: String = steps.collect();
    text.trim_start_matches('.').to_owned()
}
