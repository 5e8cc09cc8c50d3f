//! Reads names and samples of all columns.

use std::ops::Range;

use super::figures::Figures;
use super::parts::{PART_ROWS, Parts, head, part_rows, parts, parts_between};
use super::words::{Meaning, Sort, tokens};
use crate::columns::origin::Pick;
use crate::description::{ColumnName, CsvForm, MissingValues};
use crate::error::LogError;
use crate::formats::contents::{Contents, TopicContents, contents};
use crate::formats::open::open;
use crate::formats::table::{Element, ElementPlace, Reopen, Request};
use crate::input_limits::COLUMNS;
use crate::source::Opener;

/// Samples that are read to compare the columns of logs.
const BEGINNING_ROWS: usize = 1000;

/// Samples that distinguish a column of numbers from a column of text.
const PROBED_ROWS: usize = 16;

/// Rows of a log that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Extent {
    /// A beginning, an end and parts between them.
    Parts,
    /// The first rows, at most this number.
    Head(usize),
}

/// Columns of a log with a part of their samples.
#[derive(Clone, Debug, Default)]
pub struct Survey {
    /// Name of the log.
    pub(super) file: String,
    /// Sources of rows: the file itself, or the topics of a bag.
    pub(super) sources: Vec<Source>,
    /// Names of columns or topics that hold no numbers.
    pub(super) others: Vec<String>,
    /// Names of columns that count rows.
    pub(super) counters: Vec<String>,
    /// Whether the file names its columns; otherwise they only have numbers.
    pub(super) has_names: bool,
    /// Sentences about the files that were joined.
    pub(super) joined: Vec<String>,
}

/// Columns that share their times.
#[derive(Clone, Debug, Default)]
pub(super) struct Source {
    /// The topic; `None` for a table.
    pub(super) topic: Option<String>,
    /// Another file of the same recording, and its column of time as TOML.
    pub(super) file: Option<(String, String)>,
    /// Name of the file, if it says what the columns are.
    pub(super) label: Option<String>,
    /// Times of the messages of a topic, s, from the first on; times of a file that was joined; empty for another table.
    pub(super) times: Vec<f64>,
    /// Time of the first message, ns.
    pub(super) begin: i64,
    /// Samples before which rows of the log are left out.
    pub(super) joins: Vec<usize>,
    pub(super) columns: Vec<Column>,
}

/// A column of numbers.
#[derive(Clone, Debug)]
pub(super) struct Column {
    /// Its name in the file, or the field of a topic.
    pub(super) name: String,
    /// Its number in the file, from 1.
    pub(super) number: usize,
    /// Its unit as the file writes it; empty if it has none.
    pub(super) unit: String,
    /// Its place in the field of a topic.
    pub(super) place: ElementPlace,
    /// Size of its unit in s, if the file defines it as a time.
    pub(super) time_unit: Option<f64>,
    pub(super) values: Vec<f64>,
    pub(super) figures: Figures,
}

impl Survey {
    /// Reads the names of the columns, and samples of the beginning, the end and parts between them.
    ///
    /// - `file`: name of the log, for messages.
    ///
    /// # Errors
    ///
    /// [`LogError`] if the log cannot be read.
    pub fn read(file: &str, opener: &mut Opener<'_>) -> Result<Self, LogError> {
        Self::of(file, Extent::Parts, opener)
    }

    /// Reads the names of the columns and their first samples.
    ///
    /// - `file`: name of the log, for messages.
    ///
    /// # Errors
    ///
    /// [`LogError`] if the log cannot be read.
    pub fn read_beginning(file: &str, opener: &mut Opener<'_>) -> Result<Self, LogError> {
        Self::of(file, Extent::Head(BEGINNING_ROWS), opener)
    }

    fn of(file: &str, extent: Extent, opener: &mut Opener<'_>) -> Result<Self, LogError> {
        let mut reopen = || {
            opener(None).map_err(|source| LogError::Io {
                file: file.to_owned(),
                source,
            })
        };
        match contents(file, &mut reopen)? {
            Contents::Columns {
                names,
                has_names,
                units,
            } => {
                let mut survey = table(file, (&names, has_names), extent, &mut reopen)?;
                for column in survey
                    .sources
                    .iter_mut()
                    .flat_map(|source| &mut source.columns)
                {
                    let unit = units.get(column.number - 1);
                    column.unit = unit.cloned().unwrap_or_default();
                }
                for source in &mut survey.sources {
                    survey.counters = without_counters(source);
                }
                Ok(survey)
            }
            Contents::Topics { numeric, others } => {
                Ok(bag(file, &numeric, others, extent, &mut reopen))
            }
        }
    }

    /// Returns the names of all columns and topics.
    pub(super) fn all_names(&self) -> Vec<String> {
        let names = self.sources.iter().flat_map(|source| {
            (source.columns.iter()).map(|column| match &source.topic {
                None => column.name.clone(),
                Some(topic) => format!("{topic}.{}", column.label()),
            })
        });
        let beside = self.others.iter().chain(&self.counters).cloned();
        names.chain(beside).collect()
    }

    /// Returns whether another log has the same columns, or the name of one that it lacks.
    #[must_use]
    pub fn lacks_of(&self, other: &Self) -> Option<String> {
        let names = self.all_names();
        other
            .all_names()
            .into_iter()
            .find(|name| !names.contains(name))
    }
}

impl Source {
    /// Returns the words that stand before the names of its columns: its topic, or the name of its file.
    pub(super) fn prefix(&self) -> &str {
        (self.topic.as_deref().or(self.label.as_deref())).unwrap_or_default()
    }

    /// Returns the parts of `count` samples that follow each other without a gap.
    pub(super) fn parts(&self, count: usize) -> Vec<Range<usize>> {
        parts_between(&self.joins, count)
    }
}

impl Column {
    /// Returns the meaning of its name and its unit.
    pub(super) fn meaning(&self) -> Meaning {
        let mut all = tokens(&self.name);
        all.extend(tokens(&self.unit));
        Meaning::of(&all, &[])
    }

    /// Returns its name with its place, for messages.
    pub(super) fn label(&self) -> String {
        match &self.place {
            ElementPlace::Alone => self.name.clone(),
            ElementPlace::Index(k) if self.name.contains('*') => {
                self.name.replacen('*', &k.to_string(), 1)
            }
            ElementPlace::Index(k) => format!("{}[{k}]", self.name),
            ElementPlace::Named(name) => format!("{}[{name}]", self.name),
        }
    }
}

/// Samples of some columns.
struct Samples {
    parts: Parts,
    time_unit: Option<f64>,
}

/// Reads samples of some columns.
///
/// - `time`: index of the time among the columns.
fn samples(
    (file, topic): (&str, Option<&str>),
    picks: &[Pick],
    time: Option<usize>,
    extent: Extent,
    reopen: Reopen<'_>,
) -> Result<Samples, LogError> {
    let request = Request {
        file,
        picks,
        time,
        dates: false,
        topic,
        csv: &CsvForm::default(),
        nan: MissingValues::Gap,
    };
    let mut opened = open(&request, reopen)?;
    let (table, most) = (&mut *opened.table, part_rows(picks.len()));
    let parts = match extent {
        Extent::Parts => parts(table, picks.len(), most)?,
        Extent::Head(rows) => head(table, picks.len(), rows.min(most))?,
    };
    Ok(Samples {
        parts,
        time_unit: opened.time_unit,
    })
}

fn table(
    file: &str,
    (names, has_names): (&[String], bool),
    extent: Extent,
    reopen: Reopen<'_>,
) -> Result<Survey, LogError> {
    let wanted: Vec<usize> = (0..names.len()).collect();
    let pick = |k: &usize| Pick::Column(ColumnName::Number(k + 1));
    let mut of = |columns: &[usize], extent: Extent| {
        let picks: Vec<Pick> = columns.iter().map(pick).collect();
        samples((file, None), &picks, None, extent, reopen)
    };
    let mut found: Vec<(usize, Vec<f64>, Figures)> = Vec::new();
    let into = |columns: &[usize], parts: &Parts| -> Vec<(usize, Vec<f64>, Figures)> {
        let all = parts.columns.iter().zip(&parts.left_out);
        let all = columns.iter().zip(all).map(|(&k, (one, (min, max)))| {
            // A time as a large integer needs its origin only for its unit.
            let origin = one.origin as f64;
            let values: Vec<f64> = one.values.iter().map(|x| x + origin).collect();
            let figures = Figures::of(&values, &parts.joins);
            (k, values, figures.with_range((min + origin, max + origin)))
        });
        all.collect()
    };
    let mut joins = Vec::new();
    match of(&wanted, extent) {
        Ok(all) => {
            found.extend(into(&wanted, &all.parts));
            joins = all.parts.joins;
        }
        Err(error) => {
            // Texts accompany the numbers, or arrays have different lengths.
            let numeric: Vec<usize> = (wanted.iter().copied())
                .filter(|&k| of(&[k], Extent::Head(PROBED_ROWS)).is_ok())
                .collect();
            if numeric.is_empty() {
                return Err(error);
            }
            match of(&numeric, extent) {
                Ok(all) => {
                    found.extend(into(&numeric, &all.parts));
                    joins = all.parts.joins;
                }
                Err(_) => {
                    // One pass over the file for each column would take long.
                    for k in numeric {
                        if let Ok(one) = of(&[k], Extent::Head(PART_ROWS)) {
                            found.extend(into(&[k], &one.parts));
                        }
                    }
                }
            }
        }
    }
    let others = (wanted.iter())
        .filter(|k| !found.iter().any(|(other, ..)| other == *k))
        .map(|&k| names[k].clone())
        .collect();
    let mut columns = Vec::new();
    for (k, values, figures) in found {
        columns.push(Column {
            name: names[k].clone(),
            number: k + 1,
            unit: String::new(),
            place: ElementPlace::Alone,
            time_unit: time_unit_of(file, k, &values, reopen),
            figures,
            values,
        });
    }
    let source = Source {
        topic: None,
        columns,
        joins,
        ..Source::default()
    };
    Ok(Survey {
        file: file.to_owned(),
        sources: vec![source],
        others,
        has_names,
        ..Survey::default()
    })
}

/// Removes the columns that count rows, unless their names say that they are times. Returns their names.
fn without_counters(source: &mut Source) -> Vec<String> {
    let is_counter = |column: &Column| {
        let is_time = column.time_unit.is_some() || column.meaning().sort == Some(Sort::Time);
        column.figures.counts_rows() && !is_time
    };
    let all = std::mem::take(&mut source.columns);
    let (counters, kept): (Vec<Column>, Vec<Column>) = all.into_iter().partition(is_counter);
    source.columns = kept;
    counters.into_iter().map(|column| column.name).collect()
}

/// Returns the unit of a column in s, if the file defines it as a time.
fn time_unit_of(file: &str, k: usize, values: &[f64], reopen: Reopen<'_>) -> Option<f64> {
    let rises = values.len() > 1 && values.windows(2).all(|pair| pair[1] > pair[0]);
    let pick = [Pick::Column(ColumnName::Number(k + 1))];
    let one = rises.then(|| samples((file, None), &pick, Some(0), Extent::Head(1), reopen))?;
    one.ok()?.time_unit
}

fn bag(
    file: &str,
    numeric: &[TopicContents],
    others: Vec<String>,
    extent: Extent,
    reopen: Reopen<'_>,
) -> Survey {
    let mut survey = Survey {
        file: file.to_owned(),
        sources: Vec::new(),
        others,
        has_names: true,
        ..Survey::default()
    };
    for topic in numeric {
        // A topic whose messages change their form is not for the robot.
        match of_topic(file, topic, extent, reopen) {
            Ok(source) => survey.sources.push(source),
            Err(_) => survey.others.push(topic.name.clone()),
        }
    }
    survey
}

fn of_topic(
    file: &str,
    topic: &TopicContents,
    extent: Extent,
    reopen: Reopen<'_>,
) -> Result<Source, LogError> {
    let elements = &topic.elements[..topic.elements.len().min(COLUMNS)];
    let time = Pick::Field {
        field: String::new(),
        joint: String::new(),
        index: 0,
        of: 1,
    };
    let picks: Vec<Pick> = std::iter::once(time)
        .chain(elements.iter().map(pick_of))
        .collect();
    let place = (file, Some(topic.name.as_str()));
    let read = samples(place, &picks, Some(0), extent, reopen)?;
    let Parts {
        columns: mut readings,
        joins,
        mut left_out,
    } = read.parts;
    let times = readings.remove(0);
    left_out.remove(0);
    let unit = read.time_unit.unwrap_or(1e-9);
    let columns = (elements
        .iter()
        .zip(readings.into_iter().zip(left_out))
        .enumerate())
    .map(|(k, (element, (readings, range)))| Column {
        name: element.field.clone(),
        number: k + 1,
        unit: String::new(),
        place: element.place.clone(),
        time_unit: None,
        figures: Figures::of(&readings.values, &joins).with_range(range),
        values: readings.values,
    })
    .collect();
    let first = times.values.first().copied().unwrap_or_default();
    Ok(Source {
        topic: Some(topic.name.clone()),
        file: None,
        label: None,
        times: times.values.iter().map(|t| (t - first) * unit).collect(),
        begin: times.origin.saturating_add(first as i64),
        columns,
        joins,
    })
}

fn pick_of(element: &Element) -> Pick {
    let (joint, index, of) = match &element.place {
        ElementPlace::Alone => (String::new(), 0, 1),
        ElementPlace::Index(k) => (String::new(), *k, 1),
        ElementPlace::Named(name) => (name.clone(), 0, 1),
    };
    let field = match &element.place {
        // The element of a list without names.
        ElementPlace::Index(k) if !element.field.contains('*') => {
            format!("{}[{k}]", element.field)
        }
        ElementPlace::Alone | ElementPlace::Index(_) | ElementPlace::Named(_) => {
            element.field.clone()
        }
    };
    Pick::Field {
        field,
        joint,
        index,
        of,
    }
}
