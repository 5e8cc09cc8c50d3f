//! Logs that can be read more than once.

use std::io::Read;

use super::channels::Channels;
use super::{CsvLog, LogError};

/// A log that can be opened any number of times.
pub struct LogSource<'a> {
    /// Name for messages.
    pub name: String,
    /// Opens it at its beginning.
    pub reader: &'a mut (dyn FnMut() -> std::io::Result<Box<dyn Read + Send>> + Send),
}

impl LogSource<'_> {
    /// Opens the log and finds its columns.
    ///
    /// # Errors
    ///
    /// [`LogError`] if it cannot be opened or a column is not there.
    pub fn open(&mut self, channels: &Channels) -> Result<CsvLog<Box<dyn Read + Send>>, LogError> {
        let read = (self.reader)().map_err(|source| LogError::Io {
            file: self.name.clone(),
            source,
        })?;
        CsvLog::new(&self.name, read, channels)
    }
}
