//! Logs that can be read more than once: files, or columns in memory.

use std::path::Path;
use std::sync::Arc;

use super::arrays::Arrays;
use super::block::LogBlock;
use super::columns::channels::Channels;
use super::error::LogError;
use super::formats::table::{Opened, Request};
use super::formats::{memory, open};
use super::input::Input;
use super::meter::Meter;
use super::reader::LogReader;
use crate::description::{Payload, Window};

/// Opens the log's own file (`None`) or another file that a channel names. Each call returns the
/// file at its beginning.
pub type Opener<'a> = dyn FnMut(Option<&Path>) -> std::io::Result<Box<dyn Input>> + Send + 'a;

/// A log that can be opened any number of times.
pub struct LogSource<'a> {
    /// Name for messages.
    pub name: String,
    holds: Holds<'a>,
    window: Window,
    payload: Option<Payload>,
    kept: Option<(Channels, LogReader)>,
}

/// Location of a log's numbers.
enum Holds<'a> {
    Files(&'a mut Opener<'a>),
    Memory(Arrays),
}

impl<'a> LogSource<'a> {
    /// Returns a log that consists of files.
    ///
    /// - `name`: name of the log for messages.
    /// - `opener`: opens its files.
    #[must_use]
    pub fn files(name: impl Into<String>, opener: &'a mut Opener<'a>) -> Self {
        Self {
            name: name.into(),
            holds: Holds::Files(opener),
            window: Window::default(),
            payload: None,
            kept: None,
        }
    }

    /// Returns a log that consists of columns in memory. The experiment gives the units, signs and
    /// times of these columns by their names.
    ///
    /// - `name`: name of the log for messages.
    #[must_use]
    pub fn arrays(name: impl Into<String>, arrays: Arrays) -> Self {
        Self {
            name: name.into(),
            holds: Holds::Memory(arrays),
            window: Window::default(),
            payload: None,
            kept: None,
        }
    }

    /// Returns a window of the log.
    #[must_use]
    pub fn within(self, window: Window) -> Self {
        Self {
            window,
            kept: None,
            ..self
        }
    }

    /// Returns the log of a robot that carried a body.
    #[must_use]
    pub fn carrying(self, payload: Option<Payload>) -> Self {
        Self { payload, ..self }
    }

    /// Returns the body that the robot carried.
    #[must_use]
    pub fn payload(&self) -> Option<&Payload> {
        self.payload.as_ref()
    }

    /// Returns whether the robot carried a body that is to be estimated.
    #[must_use]
    pub fn has_unknown_payload(&self) -> bool {
        (self.payload.as_ref()).is_some_and(|payload| payload.known().is_none())
    }

    /// Returns its window.
    #[must_use]
    pub fn window(&self) -> Window {
        self.window
    }

    /// Returns its name with its window, for findings.
    #[must_use]
    pub fn label(&self) -> String {
        self.window.of(&self.name)
    }

    /// Keeps a log that was read to its end for the next [`LogSource::open`] of the same channels, which then reads no file.
    ///
    /// - `blocks`: all blocks that the reader returned.
    pub fn keep(&mut self, channels: &Channels, reader: LogReader, blocks: Arc<Vec<LogBlock>>) {
        self.kept = Some((channels.clone(), reader.rewound(blocks)));
    }

    /// Opens the log and finds its columns.
    ///
    /// # Errors
    ///
    /// [`LogError`] if the log cannot be opened or lacks a column.
    pub fn open(&mut self, channels: &Channels) -> Result<LogReader, LogError> {
        if let Some((_, reader)) = self.kept.take().filter(|(kept, _)| kept == channels) {
            return Ok(reader);
        }
        let (name, holds, window) = (&self.name, &mut self.holds, self.window);
        // The first stream gives the time; the others are read along with it.
        let meter = Meter::default();
        let mut unmetered = Some(&meter);
        let mut open_stream = |path: Option<&Path>, request: &Request<'_>| match holds {
            Holds::Files(opener) => open_file(name, opener, path, request, unmetered.take()),
            Holds::Memory(arrays) => open_arrays(name, arrays, path, request),
        };
        LogReader::new((name, window), channels, meter.clone(), &mut open_stream)
    }
}

fn open_file(
    name: &str,
    opener: &mut Opener<'_>,
    path: Option<&Path>,
    request: &Request<'_>,
    meter: Option<&Meter>,
) -> Result<Opened, LogError> {
    open::open(request, &mut || {
        let input = match meter {
            Some(meter) => opener(path).and_then(|input| meter.on(input)),
            None => opener(path),
        };
        input.map_err(|source| LogError::Io {
            file: path.map_or_else(|| name.to_owned(), |path| path.display().to_string()),
            source,
        })
    })
}

fn open_arrays(
    name: &str,
    arrays: &Arrays,
    path: Option<&Path>,
    request: &Request<'_>,
) -> Result<Opened, LogError> {
    match path {
        None => memory::open(request, arrays),
        Some(path) => Err(LogError::format(
            name,
            format!(
                " is in memory, but {} contains some of its columns; give these columns in memory, too",
                path.display()
            ),
        )),
    }
}
