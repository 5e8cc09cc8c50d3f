//! Bags of ROS 2 in databases (`.db3`).

use super::bag::{Message, Messages, Topic, absent, no_topic, table};
use super::definition::Definition;
use super::sqlite::{Database, Scan, TableInfo, Value};
use super::table::{Opened, Request};
use crate::log::error::LogError;
use crate::log::input::Input;

struct Db3 {
    file: String,
    base: Database,
    scan: Scan,
    topics: Vec<i64>,
    // Places of topic, time and data in a row.
    places: [usize; 3],
}

/// Opens a topic of a bag.
pub(super) fn open(request: &Request<'_>, input: Box<dyn Input>) -> Result<Opened, LogError> {
    let file = request.file;
    let failed = |error| LogError::read(file, "its database", error);
    let mut base = Database::new(input).map_err(failed)?;
    let tables = base.tables().map_err(failed)?;
    let find = |name: &str| tables.iter().find(|table| table.name == name);
    let (Some(of_topics), Some(of_messages)) = (find("topics"), find("messages")) else {
        let names: Vec<&str> = tables.iter().map(|table| table.name.as_str()).collect();
        return Err(LogError::format(
            file,
            format!(
                " is an SQLite database and no bag of ROS 2; it has the tables {}",
                names.join(", ")
            ),
        ));
    };
    let topics = rows(
        &mut base,
        of_topics,
        ["name", "type", "serialization_format"],
    )
    .map_err(failed)?;
    let known: Vec<&str> = topics.iter().filter_map(|(_, row)| row[0].text()).collect();
    let Some(topic) = request.topic else {
        return Err(no_topic(file, &known));
    };
    let of_topic: Vec<_> = topics
        .iter()
        .filter(|(_, row)| row[0].text() == Some(topic))
        .collect();
    let Some((_, first)) = of_topic.first() else {
        return Err(absent(file, topic, &known));
    };
    let kind = first[1].text().unwrap_or_default().to_owned();
    let encoding = first[2].text().unwrap_or_default();
    if encoding != "cdr" {
        return Err(LogError::format(
            file,
            format!(": its messages ({kind}) are encoded as \"{encoding}\"; only \"cdr\" is read"),
        ));
    }
    if let Some((_, other)) = of_topic.iter().find(|(_, row)| row[1] != first[1]) {
        return Err(LogError::format(
            file,
            format!(
                " carries two types of messages, {kind} and {}",
                other[1].text().unwrap_or_default()
            ),
        ));
    }
    let definition = definition(file, &mut base, find("message_definitions"), &kind)?;
    let columns = ["topic_id", "timestamp", "data"];
    let places = places(of_messages, columns).ok_or_else(|| strange(file))?;
    let messages = Db3 {
        file: file.to_owned(),
        base,
        scan: Scan::new(of_messages.root),
        topics: of_topic.iter().map(|(id, _)| *id).collect(),
        places,
    };
    let topic = Topic {
        kind,
        definition,
        messages: Box::new(messages),
    };
    table(request, topic)
}

fn strange(file: &str) -> LogError {
    LogError::format(file, " has tables of another shape than a bag of ROS 2")
}

fn places<const N: usize>(table: &TableInfo, names: [&str; N]) -> Option<[usize; N]> {
    let mut all = [0; N];
    for (place, name) in all.iter_mut().zip(names) {
        *place = table.columns.iter().position(|column| column == name)?;
    }
    Some(all)
}

/// Reads some columns of all rows of a small table, with the numbers of the rows.
fn rows<const N: usize>(
    base: &mut Database,
    table: &TableInfo,
    names: [&str; N],
) -> std::io::Result<Vec<(i64, [Value; N])>> {
    let strange = || std::io::Error::new(std::io::ErrorKind::InvalidData, "a column is missing");
    let places = places(table, names).ok_or_else(strange)?;
    let mut scan = Scan::new(table.root);
    let mut all = Vec::new();
    while let Some(row) = scan.next(base)? {
        let value = |place: usize| row.values.get(place).cloned().unwrap_or(Value::Null);
        all.push((row.id, places.map(value)));
    }
    Ok(all)
}

/// Returns the definition that the bag brings along, or that of a usual message.
fn definition(
    file: &str,
    base: &mut Database,
    table: Option<&TableInfo>,
    kind: &str,
) -> Result<Definition, LogError> {
    if let Some(table) = table {
        let columns = ["topic_type", "encoding", "encoded_message_definition"];
        let all = rows(base, table, columns)
            .map_err(|error| LogError::read(file, "its database", error))?;
        let own = (all.iter()).find(|(_, row)| row[0].text() == Some(kind));
        if let Some((_, [_, encoding, text])) = own
            && encoding.text() == Some("ros2msg")
            && let Some(text) = text.text()
        {
            return Definition::parse(kind, text).map_err(|what| {
                LogError::format(file, format!(": the definition of {kind} {what}"))
            });
        }
    }
    Definition::known(kind).ok_or_else(|| {
        LogError::format(
            file,
            format!(
                " does not bring along what {kind} is; convert it with \"ros2 bag convert\" to MCAP, \
                 which does"
            ),
        )
    })
}

impl Messages for Db3 {
    fn next(&mut self) -> Result<Option<Message>, LogError> {
        let [topic, time, data] = self.places;
        loop {
            let row = (self.scan.next(&mut self.base))
                .map_err(|error| LogError::read(&self.file, "its database", error))?;
            let Some(mut row) = row else {
                return Ok(None);
            };
            let of_topic = matches!(row.values.get(topic), Some(Value::Integer(id)) if self.topics.contains(id));
            if !of_topic {
                continue;
            }
            let time = match row.values.get(time) {
                Some(Value::Integer(time)) => *time,
                _ => return Err(strange(&self.file)),
            };
            let data = match row.values.get_mut(data) {
                Some(Value::Blob(data)) => std::mem::take(data),
                _ => return Err(strange(&self.file)),
            };
            return Ok(Some(Message { time, data }));
        }
    }
}
