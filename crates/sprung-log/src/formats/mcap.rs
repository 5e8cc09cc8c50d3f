//! MCAP files.

use std::collections::BTreeMap;
use std::io::Read;

use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, parse_record};

use super::bag::{Message, Messages, Topic, absent, no_topic, table};
use super::damaged::guarded;
use super::definition::Definition;
use super::table::{Opened, Request, whole_file};
use crate::error::LogError;
use crate::input_limits::RECORD_BYTES;

type Source = Box<dyn Read + Send>;

/// Largest accepted length of a record or a chunk, in bytes.
const MAX_RECORD_BYTES: usize = RECORD_BYTES;

/// Bytes that one read returns at most. A damaged length then allocates no more than this before the file ends.
const READ_BYTES: usize = 1 << 20;

struct Mcap {
    file: String,
    read: Source,
    records: LinearReader,
    // Channels of the topic.
    channels: Vec<u16>,
    schemas: BTreeMap<u16, (String, String, String)>,
    topic: String,
    found: Option<(String, Definition)>,
    topics: Vec<String>,
    // Whether the data section has ended; an index follows it.
    ended: bool,
}

/// Most records that a search for topics reads.
const MAX_SEARCHED_RECORDS: usize = 1 << 18;

/// Opens a topic of a file as a table.
pub(super) fn open(request: &Request<'_>, read: Source) -> Result<Opened, LogError> {
    let topic = topic(request.file, request.topic, read)?;
    table(request, topic)
}

/// Lists the topics at the beginning of a file.
pub(super) fn topics(file: &str, read: Source) -> Result<Vec<String>, LogError> {
    let mut mcap = Mcap::new(file, None, read);
    for _ in 0..MAX_SEARCHED_RECORDS {
        if mcap.step()? == Step::Ended {
            break;
        }
    }
    Ok(mcap.topics)
}

/// Opens a topic of a file.
///
/// # Errors
///
/// [`LogError`] if the file is damaged or has no such topic.
pub(super) fn topic(file: &str, wanted: Option<&str>, read: Source) -> Result<Topic, LogError> {
    let mut mcap = Mcap::new(file, wanted, read);
    // The channel of a topic precedes its first message.
    while mcap.found.is_none() && mcap.step()? != Step::Ended {}
    let Some((kind, definition)) = mcap.found.clone() else {
        let topics: Vec<&str> = mcap.topics.iter().map(String::as_str).collect();
        return Err(match wanted {
            None => no_topic(file, &topics),
            Some(topic) => absent(whole_file(file, wanted), topic, &topics),
        });
    };
    Ok(Topic {
        kind,
        definition,
        messages: Box::new(mcap),
    })
}

#[derive(Debug, PartialEq)]
enum Step {
    Message(i64, Vec<u8>),
    Other,
    Ended,
}

impl Messages for Mcap {
    fn next(&mut self) -> Result<Option<Message>, LogError> {
        loop {
            match self.step()? {
                Step::Message(time, data) => return Ok(Some(Message { time, data })),
                Step::Other => {}
                Step::Ended => return Ok(None),
            }
        }
    }
}

impl Mcap {
    /// - `wanted`: the topic whose messages are returned.
    fn new(file: &str, wanted: Option<&str>, read: Source) -> Self {
        let options = LinearReaderOptions::default()
            .with_record_length_limit(MAX_RECORD_BYTES)
            .with_validate_chunk_crcs(true);
        Self {
            file: file.to_owned(),
            read,
            records: LinearReader::new_with_options(options),
            channels: Vec::new(),
            schemas: BTreeMap::new(),
            topic: wanted.unwrap_or_default().to_owned(),
            found: None,
            topics: Vec::new(),
            ended: false,
        }
    }

    fn step(&mut self) -> Result<Step, LogError> {
        let file = self.file.clone();
        guarded(&file, || self.record())
    }

    /// Reads the next record.
    fn record(&mut self) -> Result<Step, LogError> {
        if self.ended {
            return Ok(Step::Ended);
        }
        let record = match self.records.next_event() {
            None => return Ok(Step::Ended),
            Some(Err(error)) => return Err(damaged(&self.file, &error)),
            Some(Ok(LinearReadEvent::ReadRequest(count))) => {
                let buffer = self.records.insert(count.min(READ_BYTES));
                let read = self.read.read(buffer);
                let count = read.map_err(|error| LogError::read(&self.file, "it", error))?;
                self.records.notify_read(count);
                return Ok(Step::Other);
            }
            Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                parse_record(opcode, data).map_err(|error| damaged(&self.file, &error))?
            }
        };
        match record {
            Record::Schema { header, data } => {
                let text = String::from_utf8_lossy(&data).into_owned();
                self.schemas
                    .insert(header.id, (header.name, header.encoding, text));
                Ok(Step::Other)
            }
            Record::Channel(channel) => {
                self.introduce(&channel)?;
                Ok(Step::Other)
            }
            Record::Message { header, data } if self.channels.contains(&header.channel_id) => {
                let time = i64::try_from(header.log_time).unwrap_or(i64::MAX);
                Ok(Step::Message(time, data.into_owned()))
            }
            // The summary section repeats the channels.
            Record::DataEnd(_) | Record::Footer(_) => {
                self.ended = true;
                Ok(Step::Ended)
            }
            _ => Ok(Step::Other),
        }
    }

    /// Adds a channel and, if it belongs to the wanted topic, its definition.
    fn introduce(&mut self, channel: &mcap::records::Channel) -> Result<(), LogError> {
        if !self.topics.contains(&channel.topic) {
            self.topics.push(channel.topic.clone());
        }
        if channel.topic != self.topic || self.channels.contains(&channel.id) {
            return Ok(());
        }
        let wrong = |message: String| Err(LogError::format(&self.file, message));
        let Some((kind, encoding, text)) = self.schemas.get(&channel.schema_id) else {
            return wrong(" does not contain the definition of its messages".to_owned());
        };
        if channel.message_encoding != "cdr" || encoding != "ros2msg" {
            return wrong(format!(
                ": its messages ({kind}) are encoded as \"{}\" with a schema in \"{encoding}\"; only \
                 ROS 2 messages (\"cdr\", \"ros2msg\") are read",
                channel.message_encoding
            ));
        }
        if let Some((first, _)) = &self.found
            && first != kind
        {
            return wrong(format!(
                " carries two types of messages, {first} and {kind}"
            ));
        }
        match Definition::parse(kind, text) {
            Ok(definition) => self.found = Some((kind.clone(), definition)),
            Err(what) => return wrong(format!(": the definition of {kind} {what}")),
        }
        self.channels.push(channel.id);
        Ok(())
    }
}

fn damaged(file: &str, error: &McapError) -> LogError {
    let message = match error {
        McapError::UnexpectedEof => {
            " ends in the middle of a record: it was cut off; recover it with \"mcap recover\""
                .to_owned()
        }
        McapError::UnsupportedCompression(method) => format!(
            " has chunks compressed with {method}, which is not read; compress it anew with \"mcap \
             compress\""
        ),
        other => format!(
            " is damaged ({}); recover it with \"mcap recover\"",
            other.to_string().to_lowercase()
        ),
    };
    LogError::format(file, message)
}
