//! The logs that an experiment names.

use std::io::{Read, Seek};
use std::path::{Path, PathBuf};

use super::error::SessionError;
use super::files::{Files, open_file};
use super::load::Session;
use super::stream::{Growing, Stream};
use sprung_log::{Input, LogFile, LogSource, Opener, is_shared};
use sprung_robot::{FilePart, Log, Payload, Window};

/// Bytes that tell the format of a file that is being written.
const START_BYTES: u64 = 64;

/// Path of the standard input.
const STANDARD_INPUT: &str = "-";

/// A function that opens the files of a log, any number of times.
type BoxedOpener<'a> = Box<Opener<'a>>;

/// Logs of one run, which can be read any number of times.
pub(super) struct Logs<'a> {
    files: Vec<FilePart>,
    openers: Vec<BoxedOpener<'a>>,
}

impl Logs<'_> {
    /// Returns the logs as sources.
    pub(super) fn sources(&mut self) -> Vec<LogSource<'_>> {
        (self.files.iter().zip(&mut self.openers))
            .map(|(file, opener)| {
                let name = file.path.display().to_string();
                let source = LogSource::files(name, &mut **opener);
                source.within(file.window).carrying(file.payload.clone())
            })
            .collect()
    }
}

impl Session {
    /// Returns the description of the log, merged with that of a validation run.
    ///
    /// # Errors
    ///
    /// [`SessionError::NoLog`] if the experiment has no log.
    pub(super) fn log(&self, overlay: Option<&Log>) -> Result<Log, SessionError> {
        let log = self.experiment().log.as_ref();
        let log = log.ok_or(SessionError::NoLog)?;
        Ok(overlay.map_or_else(
            || log.clone(),
            |over| log.overlaid(over, &self.experiment().robot),
        ))
    }

    /// Returns the files of a log with their paths and windows.
    ///
    /// # Errors
    ///
    /// [`SessionError`] if the experiment has no log, or if the log has no file.
    pub(super) fn log_files(&self, overlay: Option<&Log>) -> Result<Vec<FilePart>, SessionError> {
        let mut files = self.log(overlay)?.file.ok_or(SessionError::NoLogFile)?;
        for file in &mut files {
            file.path = self.folder.join(&file.path);
        }
        Ok(files)
    }

    /// Returns the bodies that the robot carried, for logs that replace the files of the experiment in their order.
    ///
    /// - `given`: number of these logs.
    ///
    /// # Errors
    ///
    /// [`SessionError::PayloadLogs`] if files of the experiment carry payloads and their number differs.
    pub fn payloads(&self, given: usize) -> Result<Vec<Option<Payload>>, SessionError> {
        let log = self.experiment().log.as_ref();
        let files: Vec<&FilePart> = log.iter().flat_map(|log| &log.file).flatten().collect();
        if files.iter().all(|file| file.payload.is_none()) {
            return Ok(vec![None; given]);
        }
        if files.len() != given {
            return Err(SessionError::PayloadLogs {
                given,
                named: files.len(),
            });
        }
        Ok(files.iter().map(|file| file.payload.clone()).collect())
    }

    /// Returns files that the experiment does not name, relative to the working directory; `-` is the standard input.
    ///
    /// - `follow_s`: time without growth after which a file ends, s; `None` for complete files.
    pub(super) fn other_logs(&self, files: &[PathBuf], follow_s: Option<f64>) -> Logs<'_> {
        let part = |path: &PathBuf| FilePart {
            path: path.clone(),
            window: Window::default(),
            payload: None,
        };
        let opener = |path: &PathBuf| -> BoxedOpener<'_> {
            if path.as_os_str() == STANDARD_INPUT {
                return Box::new(|_| Ok(Box::new(Stream::new(std::io::stdin()))));
            }
            let Some(follow_s) = follow_s else {
                return opener(&*self.files, &self.folder, path.clone());
            };
            let path = path.clone();
            Box::new(move |_| growing(&path, follow_s))
        };
        Logs {
            files: files.iter().map(part).collect(),
            openers: files.iter().map(opener).collect(),
        }
    }

    /// Returns the logs that the experiment, or one of its validation runs, names.
    ///
    /// # Errors
    ///
    /// The errors of [`log_files`](Self::log_files).
    pub(super) fn logs(&self, overlay: Option<&Log>) -> Result<Logs<'_>, SessionError> {
        let files = self.log_files(overlay)?;
        let openers = (files.iter())
            .map(|file| opener(&*self.files, &self.folder, file.path.clone()))
            .collect();
        Ok(Logs { files, openers })
    }
}

/// Opens a file that is being written.
fn growing(path: &Path, patience_s: f64) -> std::io::Result<Box<dyn Input>> {
    let (mut file, mut start) = (open_file(path)?, Vec::new());
    (&file).take(START_BYTES).read_to_end(&mut start)?;
    file.rewind()?;
    if is_shared(&start) {
        return Ok(Box::new(LogFile::new(file, path).growing(patience_s)));
    }
    Ok(Box::new(Stream::new(Growing::new(file, patience_s))))
}

/// Returns a function that opens a log, and other files relative to the experiment's folder.
fn opener<'a>(files: &'a dyn Files, folder: &'a Path, path: PathBuf) -> BoxedOpener<'a> {
    Box::new(move |other: Option<&Path>| match other {
        None => files.open(&path),
        Some(other) => files.open(&folder.join(other)),
    })
}
