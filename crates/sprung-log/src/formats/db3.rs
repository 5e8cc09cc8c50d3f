//! Bags of ROS 2 in databases (`.db3`).

use std::collections::VecDeque;

use rusqlite::{Connection, Error, OptionalExtension, Result, ffi, params};

use super::bag::{Message, Messages, Topic, absent, no_topic, table};
use super::definition::Definition;
use super::sqlite::{self, failed};
use super::table::{Opened, Request, whole_file};
use crate::error::LogError;
use crate::input::{Input, awaited};

/// Rows that one query returns, at most.
const MAX_BATCH_ROWS: u32 = 1024;

/// Bytes of messages after which a batch ends.
const MAX_BATCH_BYTES: usize = 1 << 20;

/// Topics that are read, at most.
const MAX_TOPICS: u32 = 1 << 16;

/// Messages of one topic, in the order in which they were recorded.
struct Db3 {
    file: String,
    base: Connection,
    topic: String,
    /// Messages that were read and not yet returned.
    batch: VecDeque<Message>,
    /// Number of the last row that was read.
    last_row: i64,
    /// Time without a message after which a bag that is being written ends, s; zero for a complete bag.
    patience_s: f64,
}

/// Opens a topic of a bag as a table.
pub(super) fn open(
    request: &Request<'_>,
    input: Box<dyn Input>,
) -> std::result::Result<Opened, LogError> {
    let topic = topic(request.file, request.topic, input)?;
    table(request, topic)
}

/// Lists the topics of a bag.
pub(super) fn topics(
    file: &str,
    input: Box<dyn Input>,
) -> std::result::Result<Vec<String>, LogError> {
    let base = opened(file, input)?;
    let topics = listed(&base).map_err(|error| failed(file, &error))?;
    Ok(topics.into_iter().map(|[name, ..]| name).collect())
}

/// Opens a database that holds a bag.
fn opened(file: &str, input: Box<dyn Input>) -> std::result::Result<Connection, LogError> {
    let base = sqlite::open(file, input)?;
    let tables = tables(&base).map_err(|error| failed(file, &error))?;
    let has = |name: &str| tables.iter().any(|table| table == name);
    if has("topics") && has("messages") {
        return Ok(base);
    }
    Err(LogError::format(
        file,
        format!(
            " is an SQLite database and no bag of ROS 2; it has the tables {}",
            tables.join(", ")
        ),
    ))
}

/// Opens a topic of a bag.
///
/// # Errors
///
/// [`LogError`] if the file is damaged or has no such topic.
pub(super) fn topic(
    file: &str,
    wanted: Option<&str>,
    input: Box<dyn Input>,
) -> std::result::Result<Topic, LogError> {
    let wrong = |error| failed(file, &error);
    let patience_s = input.patience_s().unwrap_or(0.0);
    let base = opened(file, input)?;
    let topics = listed(&base).map_err(wrong)?;
    let known: Vec<&str> = topics.iter().map(|[name, ..]| name.as_str()).collect();
    let Some(topic) = wanted else {
        return Err(no_topic(file, &known));
    };
    let mut of_topic = topics.iter().filter(|[name, ..]| name == topic);
    let Some([_, kind, encoding]) = of_topic.next() else {
        return Err(absent(whole_file(file, wanted), topic, &known));
    };
    if encoding != "cdr" {
        return Err(LogError::format(
            file,
            format!(": its messages ({kind}) are encoded as \"{encoding}\"; only \"cdr\" is read"),
        ));
    }
    if let Some([_, other, _]) = of_topic.find(|[_, other, _]| other != kind) {
        return Err(LogError::format(
            file,
            format!(" carries two types of messages, {kind} and {other}"),
        ));
    }
    let has_definitions = tables(&base)
        .map_err(wrong)?
        .iter()
        .any(|table| table == "message_definitions");
    let stored = if has_definitions {
        stored_definition(&base, kind).map_err(wrong)?
    } else {
        None
    };
    Ok(Topic {
        kind: kind.clone(),
        definition: definition(file, kind, stored)?,
        messages: Box::new(Db3 {
            file: file.to_owned(),
            base,
            topic: topic.to_owned(),
            batch: VecDeque::new(),
            last_row: i64::MIN,
            patience_s,
        }),
    })
}

/// Lists the tables; views and virtual tables have no root page, and are left out.
fn tables(base: &Connection) -> Result<Vec<String>> {
    base.prepare("SELECT name FROM sqlite_schema WHERE type = 'table' AND rootpage > 0")?
        .query_map([], |row| row.get(0))?
        .collect()
}

/// Lists name, type and encoding of the topics.
fn listed(base: &Connection) -> Result<Vec<[String; 3]>> {
    base.prepare("SELECT name, type, serialization_format FROM topics LIMIT ?1")?
        .query_map([MAX_TOPICS], |row| {
            Ok([row.get(0)?, row.get(1)?, row.get(2)?])
        })?
        .collect()
}

/// Returns the definition of a type that the bag contains, if it contains one.
fn stored_definition(base: &Connection, kind: &str) -> Result<Option<String>> {
    base.query_row(
        "SELECT encoded_message_definition FROM message_definitions \
         WHERE topic_type = ?1 AND encoding = 'ros2msg'",
        [kind],
        |row| row.get(0),
    )
    .optional()
}

/// Reads the definition of a type, or takes that of a usual one.
///
/// - `stored`: the definition that the bag contains.
fn definition(
    file: &str,
    kind: &str,
    stored: Option<String>,
) -> std::result::Result<Definition, LogError> {
    if let Some(text) = stored {
        return Definition::parse(kind, &text)
            .map_err(|what| LogError::format(file, format!(": the definition of {kind} {what}")));
    }
    Definition::known(kind).ok_or_else(|| {
        LogError::format(
            file,
            format!(
                " does not contain the definition of {kind}; convert the bag with \"ros2 bag convert\" to MCAP, \
                 which contains it"
            ),
        )
    })
}

impl Db3 {
    /// Reads messages until there is at least one of the topic, or the bag ends.
    fn fill(&mut self) -> Result<()> {
        awaited(self.patience_s, || {
            let mut more = true;
            while more && self.batch.is_empty() {
                if self.patience_s > 0.0 {
                    // The length of the bag was another one when it was opened.
                    sqlite::limit(&mut self.base, 0)?;
                }
                more = self.read_batch()?;
            }
            Ok((!self.batch.is_empty()).then_some(()))
        })
        .map(|_| ())
    }

    /// Reads some rows; returns false if there are none.
    fn read_batch(&mut self) -> Result<bool> {
        // Messages of other topics may be long, as images are; they are not loaded.
        let mut statement = self.base.prepare(
            "SELECT rowid, timestamp, \
             CASE WHEN topic_id IN (SELECT id FROM topics WHERE name = ?2) THEN data END \
             FROM messages WHERE rowid > ?1 ORDER BY rowid LIMIT ?3",
        )?;
        let mut rows = statement.query(params![self.last_row, self.topic, MAX_BATCH_ROWS])?;
        let (mut any, mut bytes) = (false, 0);
        while bytes < MAX_BATCH_BYTES
            && let Some(row) = rows.next()?
        {
            let number = row.get(0)?;
            // Pages of a damaged file may lead back to the same rows.
            if number <= self.last_row {
                let error = ffi::Error::new(ffi::SQLITE_CORRUPT);
                let why = format!("its row {number} follows row {}", self.last_row);
                return Err(Error::SqliteFailure(error, Some(why)));
            }
            self.last_row = number;
            any = true;
            if let Some(data) = row.get_ref(2)?.as_blob_or_null()? {
                bytes += data.len();
                self.batch.push_back(Message {
                    time: row.get(1)?,
                    data: data.to_vec(),
                });
            }
        }
        Ok(any)
    }
}

impl Messages for Db3 {
    fn next(&mut self) -> std::result::Result<Option<Message>, LogError> {
        self.fill().map_err(|error| failed(&self.file, &error))?;
        Ok(self.batch.pop_front())
    }
}
