//! Contents of a file: its columns, or its topics with their numbers.

#[cfg(feature = "db3")]
use super::db3;
#[cfg(feature = "mcap")]
use super::mcap;
use super::open::open;
use super::table::{Element, Reopen, Request};
use crate::description::{CsvForm, MissingValues};
use crate::error::LogError;
#[cfg(any(feature = "db3", feature = "mcap"))]
use crate::input::{Beginning, Kind, kind_of, peek};
#[cfg(any(feature = "db3", feature = "mcap"))]
use {super::bag, super::bag::Topic};

/// Most topics of a bag whose messages are examined.
#[cfg(any(feature = "db3", feature = "mcap"))]
const MAX_TOPICS: usize = 200;

/// Contents of a file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Contents {
    /// Columns by name.
    Columns {
        names: Vec<String>,
        /// Whether the file names its columns; otherwise they only have numbers.
        has_names: bool,
        /// Their units as the file writes them; empty if it has none.
        units: Vec<String>,
    },
    /// Topics with numbers, and the names of all other topics.
    #[cfg_attr(
        not(any(feature = "db3", feature = "mcap")),
        expect(dead_code, reason = "only bags have topics")
    )]
    Topics {
        numeric: Vec<TopicContents>,
        others: Vec<String>,
    },
}

/// The numbers in the messages of a topic.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TopicContents {
    pub(crate) name: String,
    pub(crate) elements: Vec<Element>,
}

/// Returns the contents of a file.
///
/// # Errors
///
/// [`LogError`] if the format is not supported or the file is damaged.
pub(crate) fn contents(file: &str, reopen: Reopen<'_>) -> Result<Contents, LogError> {
    #[cfg(any(feature = "db3", feature = "mcap"))]
    if let Some(topics) = topics(file, reopen)? {
        return Ok(topics);
    }
    let request = Request {
        file,
        picks: &[],
        time: None,
        dates: false,
        topic: None,
        csv: &CsvForm::default(),
        nan: MissingValues::default(),
    };
    let opened = open(&request, reopen)?;
    Ok(Contents::Columns {
        names: opened.all,
        has_names: opened.has_names,
        units: opened.units,
    })
}

/// Returns the topics of a bag; `None` for another file.
#[cfg(any(feature = "db3", feature = "mcap"))]
fn topics(file: &str, reopen: Reopen<'_>) -> Result<Option<Contents>, LogError> {
    let Beginning {
        start, again: read, ..
    } = peek(file, "its beginning", reopen()?)?;
    let kind = kind_of(&start);
    let names = match kind {
        #[cfg(feature = "mcap")]
        Kind::Mcap => mcap::topics(file, Box::new(read))?,
        #[cfg(feature = "db3")]
        Kind::Sqlite => {
            drop(read);
            db3::topics(file, reopen()?)?
        }
        _ => return Ok(None),
    };
    let mut topic = |name: &str| -> Result<Topic, LogError> {
        match kind {
            #[cfg(feature = "mcap")]
            Kind::Mcap => mcap::topic(file, Some(name), Box::new(reopen()?)),
            #[cfg(feature = "db3")]
            Kind::Sqlite => db3::topic(file, Some(name), reopen()?),
            _ => Err(LogError::format(file, " is no bag")),
        }
    };
    let (mut numeric, mut others) = (Vec::new(), Vec::new());
    for (i, name) in names.into_iter().enumerate() {
        // A topic of an unknown type or encoding may accompany those of the joints.
        let elements = (i < MAX_TOPICS)
            .then(|| {
                topic(&name)
                    .and_then(|topic| bag::elements(file, topic))
                    .ok()
            })
            .flatten()
            .unwrap_or_default();
        if elements.is_empty() {
            others.push(name);
        } else {
            numeric.push(TopicContents { name, elements });
        }
    }
    Ok(Some(Contents::Topics { numeric, others }))
}
