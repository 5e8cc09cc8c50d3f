//! A log as one table: streams put together, time checked.

use std::path::Path;

use super::channels::{Channel, Channels};
use super::follow::Follower;
use super::formats::{Opened, Request, open};
use super::input::Input;
use super::origin::{Pick, Start, Stream, TimeOrigin};
use super::rows::{Rows, TimeOfRows};
use super::{BLOCK, Clock, LogBlock, LogError};
use crate::description::ColumnName;

/// A log that is read block by block.
pub struct LogReader {
    first: Rows,
    // Places of the first stream's channels among all.
    channels: Vec<usize>,
    // Streams whose rows are those of the first, and others.
    beside: Vec<(String, Rows, Vec<usize>)>,
    followers: Vec<Follower>,
    clock: Clock,
    file: String,
    // Values of rows that are not known to be in all streams.
    found: Vec<Vec<f64>>,
}

/// Opens the log's own file, or another that a channel names.
type OpenFile<'a> = &'a mut dyn FnMut(Option<&Path>) -> Result<Box<dyn Input>, LogError>;

impl LogReader {
    /// Opens all that the channels name.
    ///
    /// - `file`: name of the log, for messages.
    ///
    /// # Errors
    ///
    /// [`LogError`] if a file cannot be read or lacks a column.
    pub(super) fn new(
        file: &str,
        channels: &Channels,
        open_file: OpenFile<'_>,
    ) -> Result<Self, LogError> {
        let streams = streams(channels);
        let mut opened = Vec::new();
        for (i, stream) in streams.iter().enumerate() {
            let time = time_of(channels, stream, i == 0);
            let of: Vec<usize> = (channels.all.iter().enumerate())
                .filter(|(_, channel)| channel.origin.stream == *stream)
                .map(|(place, _)| place)
                .collect();
            let name = name_of(file, stream);
            let rows = rows(&name, channels, stream, (time, &of), open_file)?;
            opened.push((name, rows, of, time));
        }
        let mut opened = opened.into_iter();
        let Some((_, first, of_first, _)) = opened.next() else {
            return Err(LogError::format(file, " has no channels"));
        };
        let (mut beside, mut followers) = (Vec::new(), Vec::new());
        for (name, rows, of, time) in opened {
            if matches!(time, Time::None) {
                beside.push((name, rows, of));
            } else {
                followers.push(Follower::new(name, rows, of));
            }
        }
        Ok(Self {
            first,
            channels: of_first,
            beside,
            followers,
            clock: Clock::new(file),
            file: file.to_owned(),
            found: vec![Vec::new(); channels.all.len()],
        })
    }

    /// Reads the next block; returns false when the log has ended.
    ///
    /// # Errors
    ///
    /// [`LogError`] naming place, column and value of the first bad reading, or
    /// the place at which time goes wrong.
    pub fn read(&mut self, block: &mut LogBlock) -> Result<bool, LogError> {
        block.clear();
        let first = self.clock.samples();
        let mut ended = false;
        while block.len() < BLOCK && !ended {
            ended = !self.more(BLOCK - block.len(), block)?;
        }
        if ended {
            self.clock.finish()?;
        }
        // The period is known within the first block, so none is missed.
        let gaps = self.clock.new_gaps().into_iter();
        block
            .gaps
            .extend(gaps.map(|sample| (sample - first) as usize));
        Ok(!block.is_empty())
    }

    /// Returns the clock, which knows period and number of samples so far.
    #[must_use]
    pub fn clock(&self) -> &Clock {
        &self.clock
    }

    /// Appends at most `limit` rows; returns false at the end.
    fn more(&mut self, limit: usize, block: &mut LogBlock) -> Result<bool, LogError> {
        let count = self.first.read(limit)?;
        for (name, rows, _) in &mut self.beside {
            let own = rows.read(count.max(1))?;
            if own != count {
                return Err(unequal(
                    &self.file,
                    name,
                    self.clock.samples(),
                    (count, own),
                ));
            }
        }
        if count == 0 {
            return Ok(false);
        }
        if self.beside.is_empty() && self.followers.is_empty() {
            for (i, &time) in self.first.times.iter().enumerate() {
                self.clock.tick(self.first.place(i), time)?;
            }
            block.time.extend_from_slice(&self.first.times);
            for (own, &channel) in self.first.values.iter().zip(&self.channels) {
                block.values[channel].extend_from_slice(own);
            }
            return Ok(true);
        }
        for values in &mut self.found {
            values.clear();
        }
        let of_first = (&self.first, &self.channels);
        let beside = self.beside.iter().map(|(_, rows, of)| (rows, of));
        for (rows, of) in std::iter::once(of_first).chain(beside) {
            for (own, &channel) in rows.values.iter().zip(of) {
                self.found[channel].extend_from_slice(own);
            }
        }
        let origin = self.first.origin();
        for follower in &mut self.followers {
            follower.at(&self.first.times, origin, &mut self.found)?;
        }
        for (i, &time) in self.first.times.iter().enumerate() {
            // Before a stream begins, in its gaps, and behind its end.
            if self.found.iter().any(|values| values[i].is_nan()) {
                continue;
            }
            self.clock.tick(self.first.place(i), time)?;
            block.time.push(time);
            for (values, found) in block.values.iter_mut().zip(&self.found) {
                values.push(found[i]);
            }
        }
        Ok(true)
    }
}

/// How a stream says its time.
#[derive(Clone, Copy, Debug)]
enum Time<'a> {
    Column(&'a ColumnName, f64),
    Period(f64),
    Messages,
    None,
}

/// Returns the streams of a log, the one whose time is used first.
fn streams(channels: &Channels) -> Vec<Stream> {
    let first = match (&channels.time_stream, &channels.time) {
        (Some(stream), _) => Some(stream.clone()),
        (None, TimeOrigin::Messages) => None,
        (None, _) => Some(Stream::default()),
    };
    let mut all: Vec<Stream> = first.into_iter().collect();
    for channel in &channels.all {
        let stream = &channel.origin.stream;
        if !all.contains(stream) {
            all.push(stream.clone());
        }
    }
    all
}

fn time_of<'a>(channels: &'a Channels, stream: &'a Stream, first: bool) -> Time<'a> {
    match (&stream.time, &stream.topic, &channels.time) {
        (Some(name), None, _) => Time::Column(name, channels.time_factor),
        (_, Some(_), _) => Time::Messages,
        (None, None, TimeOrigin::Column(name)) if first => Time::Column(name, channels.time_factor),
        (None, None, TimeOrigin::Period(period)) if first => Time::Period(*period),
        _ => Time::None,
    }
}

fn name_of(log: &str, stream: &Stream) -> String {
    let file = match &stream.file {
        None => log.to_owned(),
        Some(file) => file.display().to_string(),
    };
    match &stream.topic {
        None => file,
        Some(topic) => format!("{topic} in {file}"),
    }
}

/// Opens a stream.
///
/// - `time`, `of`: how it says its time, and places of its channels.
fn rows(
    name: &str,
    channels: &Channels,
    stream: &Stream,
    (time, of): (Time<'_>, &[usize]),
    open_file: OpenFile<'_>,
) -> Result<Rows, LogError> {
    let own: Vec<&Channel> = of.iter().map(|&place| &channels.all[place]).collect();
    let mut picks: Vec<Pick> = Vec::new();
    match time {
        Time::Column(name, _) => picks.push(Pick::Column(name.clone())),
        Time::Messages => picks.push(Pick::Field {
            field: stream
                .time
                .as_ref()
                .map_or_else(String::new, ToString::to_string),
            joint: String::new(),
            index: 0,
            of: 1,
        }),
        Time::Period(_) | Time::None => {}
    }
    let has_time = !picks.is_empty();
    picks.extend(own.iter().map(|channel| channel.origin.pick.clone()));
    let mut starts = Vec::new();
    for channel in &own {
        starts.push(match &channel.origin.start {
            Some(Start::Of(pick)) => {
                picks.push(pick.clone());
                Some(picks.len() - 1)
            }
            _ => None,
        });
    }
    let request = Request {
        file: name,
        picks: &picks,
        time: has_time.then_some(0),
        dates: channels.dates && matches!(time, Time::Column(..)),
        topic: stream.topic.as_deref(),
        csv: &channels.csv,
    };
    let path = stream.file.as_deref();
    let opened: Opened = open(&request, &mut || open_file(path))?;
    let time = match time {
        Time::Column(_, factor) => TimeOfRows::Column(factor),
        Time::Messages => TimeOfRows::Column(1e-9),
        Time::Period(period) => TimeOfRows::Period(period),
        Time::None => TimeOfRows::None,
    };
    Ok(Rows::new(name, opened, time, &own, &starts))
}

#[cold]
fn unequal(log: &str, other: &str, before: u64, (first, own): (usize, usize)) -> LogError {
    let (short, long, rows) = if own < first {
        (other, log, before + own as u64)
    } else {
        (log, other, before + first as u64)
    };
    LogError::format(
        short,
        format!(
            " ends after {rows} rows, {long} goes on; rows are matched one by one, so name the column \
             of its own time with time = \"…\" beside the file"
        ),
    )
}
