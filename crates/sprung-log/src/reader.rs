//! Reads a log as one table: its streams are combined and put on an even grid of times.

use std::path::Path;
use std::sync::Arc;

use super::block::{BLOCK, LogBlock};
use super::error::LogError;
use super::formats::table::{Opened, Request};
use super::mend::{Mended, Mender};
use super::meter::Meter;
use super::select::Selector;
use crate::clock::grid::Grid;
use crate::clock::timing::{Gaps, Timing};
use crate::columns::channel::Channel;
use crate::columns::channels::Channels;
use crate::columns::follow::Follower;
use crate::columns::origin::{Pick, Start, Stream, TimeOrigin};
use crate::columns::rows::{Rows, TimeOfRows, Tolerance};
use crate::description::{ColumnName, TorqueHold, Window};

/// A log that is read block by block.
pub struct LogReader {
    first: Rows,
    // Streams whose rows match those of the first stream one by one, and streams with their own
    // time.
    beside: Vec<Beside>,
    followers: Vec<Follower>,
    grid: Grid,
    // Indices of the grid's channels among all channels.
    of_grid: Vec<usize>,
    ended: bool,
    window: Selector,
    // Samples left out because a follower lacks them, and the resulting gaps.
    left_out: LeftOut,
    meter: Meter,
    file: String,
    // Until it is compared with the period of the log.
    torque_hold: Option<TorqueHold>,
    // Name in the file of the column of each channel.
    names: Vec<String>,
    mender: Mender,
    raw: LogBlock,
    replay: Option<Replay>,
}

/// The blocks of a log that was read before, and the next one.
struct Replay {
    blocks: Arc<Vec<LogBlock>>,
    next: usize,
}

/// A stream whose rows match those of the first one by one: its name, its rows, and the indices of
/// its channels.
type Beside = (String, Rows, Vec<usize>);

/// Opens columns of the log itself, or of another file that a channel names.
type OpenStream<'a> = &'a mut dyn FnMut(Option<&Path>, &Request<'_>) -> Result<Opened, LogError>;

impl LogReader {
    /// Opens all files and topics that the channels name.
    ///
    /// - `file`: name of the log, for messages, and the window of it that is read.
    /// - `meter`: counts the bytes of the first stream.
    ///
    /// # Errors
    ///
    /// [`LogError`] if a file cannot be read or lacks a column.
    pub(super) fn new(
        (file, window): (&str, Window),
        channels: &Channels,
        meter: Meter,
        open_stream: OpenStream<'_>,
    ) -> Result<Self, LogError> {
        let tolerance = if window.is_whole() {
            Tolerance::Strict
        } else {
            Tolerance::OfWindow
        };
        let streams = streams(channels);
        let mut opened = Vec::new();
        let mut names = vec![String::new(); channels.all.len()];
        for (i, stream) in streams.iter().enumerate() {
            let time = time_of(channels, stream, i == 0);
            let of: Vec<usize> = (channels.all.iter().enumerate())
                .filter(|(_, channel)| channel.origin.stream == *stream)
                .map(|(place, _)| place)
                .collect();
            let name = name_of(file, stream);
            let rows = rows(
                (&name, tolerance),
                channels,
                stream,
                (time, &of),
                open_stream,
            )?;
            for (k, &place) in of.iter().enumerate() {
                rows.name(k).clone_into(&mut names[place]);
            }
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
                followers.push(Follower::new(name, rows, of, tolerance));
            }
        }
        let mut of_grid = of_first;
        of_grid.extend(beside.iter().flat_map(|(_, _, of): &Beside| of));
        let smooth: Vec<bool> = (of_grid.iter())
            .map(|&place| channels.all[place].quantity.is_position())
            .collect();
        Ok(Self {
            first,
            beside,
            followers,
            grid: Grid::new(&window.of(file), channels.time.sampling, &smooth, &of_grid),
            of_grid,
            ended: false,
            window: Selector::new(window),
            left_out: LeftOut::default(),
            meter,
            file: file.to_owned(),
            torque_hold: channels.torque_hold,
            names,
            mender: Mender::new(channels),
            raw: LogBlock::new(channels.all.len()),
            replay: None,
        })
    }

    /// Returns a reader that was read to its end at the beginning of its blocks.
    pub(super) fn rewound(self, blocks: Arc<Vec<LogBlock>>) -> Self {
        Self {
            replay: Some(Replay { blocks, next: 0 }),
            ..self
        }
    }

    /// Returns the name in the file of the column of each channel, \[channels\].
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Reads the next block; returns false when the log has ended.
    ///
    /// # Errors
    ///
    /// [`LogError`] with place, column and value of the first bad reading, or with the place where
    /// the time does not increase, or with the period if that of the controller does not suit it.
    pub fn read(&mut self, block: &mut LogBlock) -> Result<bool, LogError> {
        if let Some(replay) = &mut self.replay {
            match replay.blocks.get(replay.next) {
                Some(next) => block.clone_from(next),
                None => block.clear(),
            }
            replay.next += 1;
            return Ok(!block.is_empty());
        }
        if self.mender.is_idle() {
            return self.fill(block);
        }
        block.clear();
        let mut raw = std::mem::take(&mut self.raw);
        let mut more = true;
        while block.len() < BLOCK && (more || !self.mender.is_empty()) {
            more = self.fill(&mut raw)?;
            let period = self.grid.timing().period;
            self.mender.push(&raw, period, block);
        }
        self.raw = raw;
        Ok(!block.is_empty())
    }

    /// Returns the corrected samples of each channel so far, \[channels\].
    #[must_use]
    pub fn mended(&self) -> &[Mended] {
        self.mender.mended()
    }

    /// Reads the next block as it was recorded; returns false when the log has ended.
    fn fill(&mut self, block: &mut LogBlock) -> Result<bool, LogError> {
        block.clear();
        while block.len() < BLOCK {
            let wanted = BLOCK - block.len();
            if self.grid.ready() < wanted && !self.ended {
                self.more(wanted)?;
            }
            let begin = block.len();
            self.grid.hand_on(wanted, &self.of_grid, block);
            if begin == block.len() && self.ended {
                break;
            }
            self.follow(begin, block)?;
        }
        let period = self.grid.timing().period;
        if let Some(message) = self
            .torque_hold
            .take()
            .and_then(|torque_hold| torque_hold.conflict(period))
        {
            return Err(LogError::Implausible {
                message: format!("{}: {message}", self.file),
            });
        }
        Ok(!block.is_empty())
    }

    /// Returns the sampling of the part that was read. The period is known after the first block.
    #[must_use]
    pub fn timing(&self) -> Timing {
        let mut timing = self.grid.timing();
        // The rows count from the first stamp if it is a large integer.
        timing.start += 1e-9 * self.first.origin() as f64;
        timing.window = self.window.window();
        timing.beyond = self.window.beyond();
        let beside = self.beside.iter().map(|(_, rows, _)| rows);
        let mut streams = std::iter::once(&self.first).chain(beside);
        let of_followers = || self.followers.iter().find_map(Follower::cut);
        timing.beyond.cut = streams.find_map(Rows::cut).or_else(of_followers);
        timing.gaps.count += self.left_out.gaps.count;
        timing.gaps.duration += self.left_out.gaps.duration;
        let (gaps, duration) = self.mender.gaps();
        timing.gaps.count += gaps;
        timing.gaps.duration += duration;
        for follower in &self.followers {
            let (repeated, lacking) = (follower.repeated, follower.lacking);
            timing.repeated.add(repeated.count, repeated.first);
            timing.lacking.add(lacking.count, lacking.first);
        }
        timing
    }

    /// Returns the number of samples that the log probably has, from the part of its bytes that was
    /// read; `None` if this is unknown.
    #[must_use]
    pub fn expected(&self) -> Option<u64> {
        let whole = self.window.window().is_whole();
        let part = self.meter.part().filter(|_| whole)?;
        let samples = self.grid.timing().recorded;
        Some(((samples as f64 / part).round() as u64).max(samples))
    }

    /// Reads at most `limit` rows, or records the end of the log.
    fn more(&mut self, limit: usize) -> Result<(), LogError> {
        let count = self.first.read(limit)?;
        let origin = 1e-9 * self.first.origin() as f64;
        let rows = self.window.select(&self.first.times, origin);
        for (name, beside, _) in &mut self.beside {
            let read = beside.read(count.max(1))?;
            if read != count && (rows.end > read || !self.window.ended()) {
                let timing = self.grid.timing();
                let before = timing.recorded + timing.lacking.count;
                return Err(match beside.later() {
                    Some(error) => error,
                    None => unequal(&self.file, name, before, (count, read)),
                });
            }
            beside.check(rows.clone())?;
        }
        self.first.check(rows.clone())?;
        let beside = self.beside.iter().flat_map(|(_, rows, _)| &rows.values);
        let columns = self.first.values.iter().chain(beside);
        for i in rows {
            if self.first.lacks(i) || self.beside.iter().any(|(_, rows, _)| rows.lacks(i)) {
                self.grid.leave_out(self.first.place(i));
                continue;
            }
            let values = columns.clone().map(|column| column[i]);
            let (place, time) = (self.first.place(i), self.first.times[i]);
            self.grid.take(place, time, values)?;
        }
        if count == 0 || self.window.ended() {
            self.ended = true;
            self.window.finish(&self.file)?;
            return self.grid.finish();
        }
        Ok(())
    }

    /// Adds the followers' values at the times from `begin` on. Leaves out the samples that a
    /// follower lacks: before its beginning, in its gaps, and after its end.
    fn follow(&mut self, begin: usize, block: &mut LogBlock) -> Result<(), LogError> {
        if self.followers.is_empty() {
            return Ok(());
        }
        let origin = self.first.origin();
        for follower in &mut self.followers {
            follower.at(&block.time[begin..], origin, &mut block.values)?;
        }
        let gaps = block
            .gaps
            .split_off(block.gaps.partition_point(|gap| *gap < begin));
        let period = self.grid.timing().period;
        let mut kept = begin;
        for i in begin..block.len() {
            let left_out = &mut self.left_out;
            left_out.gap |= gaps.contains(&i);
            if block.values.iter().any(|values| values[i].is_nan()) {
                left_out.missing = true;
                continue;
            }
            let (gap, missing) = (
                std::mem::take(&mut left_out.gap),
                std::mem::take(&mut left_out.missing),
            );
            if let Some(last) = left_out.last.replace(block.time[i])
                && (gap || missing)
            {
                block.gaps.push(kept);
                if !gap {
                    left_out.gaps.count += 1;
                    left_out.gaps.duration += block.time[i] - last - period;
                }
            }
            block.time[kept] = block.time[i];
            for values in &mut block.values {
                values[kept] = values[i];
            }
            kept += 1;
        }
        block.time.truncate(kept);
        for values in &mut block.values {
            values.truncate(kept);
        }
        Ok(())
    }
}

/// State of leaving out samples that a follower lacks.
#[derive(Clone, Copy, Debug, Default)]
struct LeftOut {
    // Time of the last sample that all streams have.
    last: Option<f64>,
    // Since that sample: whether the log had a gap, and whether samples were left out.
    gap: bool,
    missing: bool,
    gaps: Gaps,
}

/// Source of a stream's time.
#[derive(Clone, Copy, Debug)]
enum Time<'a> {
    Column(&'a ColumnName, f64),
    Period(f64),
    Messages,
    None,
}

/// Returns the streams of a log. The first one gives the time.
fn streams(channels: &Channels) -> Vec<Stream> {
    let first = match (&channels.time.stream, &channels.time.origin) {
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
    match (&stream.time, &stream.topic, &channels.time.origin) {
        (Some(name), None, _) => Time::Column(name, channels.time.factor),
        (_, Some(_), _) => Time::Messages,
        (None, None, TimeOrigin::Column(name)) if first => Time::Column(name, channels.time.factor),
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
/// - `name`, `tolerance`: its name for messages, and the rows whose faults are errors.
/// - `time`, `of`: source of its time, and indices of its channels.
fn rows(
    (name, tolerance): (&str, Tolerance),
    channels: &Channels,
    stream: &Stream,
    (time, of): (Time<'_>, &[usize]),
    open_stream: OpenStream<'_>,
) -> Result<Rows, LogError> {
    let picked: Vec<&Channel> = of.iter().map(|&place| &channels.all[place]).collect();
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
    picks.extend(picked.iter().map(|channel| channel.origin.pick.clone()));
    let mut starts = Vec::new();
    for channel in &picked {
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
        dates: channels.time.are_dates && matches!(time, Time::Column(..)),
        topic: stream.topic.as_deref(),
        csv: &channels.csv,
        nan: channels.nan,
    };
    let opened = open_stream(stream.file.as_deref(), &request)?;
    let time = match time {
        Time::Column(_, factor) => TimeOfRows::Column(factor),
        Time::Messages => TimeOfRows::Column(1e-9),
        Time::Period(period) => TimeOfRows::Period(period),
        Time::None => TimeOfRows::None,
    };
    Ok(Rows::new(
        name,
        opened,
        time,
        &picked,
        &starts,
        (tolerance, channels.nan),
    ))
}

#[cold]
fn unequal(log: &str, other: &str, before: u64, (first, second): (usize, usize)) -> LogError {
    let (short, long, rows) = if second < first {
        (other, log, before + second as u64)
    } else {
        (log, other, before + first as u64)
    };
    LogError::format(
        short,
        format!(
            " ends after {rows} rows, but {long} continues; without a time of its own, a file must have \
             one row for each row of the log, so name its time column with time = \"…\" beside the file"
        ),
    )
}
