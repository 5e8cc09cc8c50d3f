//! Logs that can be read more than once.

use std::path::Path;

use super::error::LogError;
use super::input::Input;
use super::reader::LogReader;
use crate::log::columns::channels::Channels;

/// Opens the log's own file at its beginning, or another that a channel
/// names; as often as it is called.
pub type Opener<'a> = dyn FnMut(Option<&Path>) -> std::io::Result<Box<dyn Input>> + Send + 'a;

/// A log that can be opened any number of times.
pub struct LogSource<'a> {
    /// Name for messages.
    pub name: String,
    /// Opens its files.
    pub reader: &'a mut Opener<'a>,
}

impl LogSource<'_> {
    /// Opens the log and finds its columns.
    ///
    /// # Errors
    ///
    /// [`LogError`] if it cannot be opened or a column is not there.
    pub fn open(&mut self, channels: &Channels) -> Result<LogReader, LogError> {
        let mut open_file = |path: Option<&Path>| {
            (self.reader)(path).map_err(|source| LogError::Io {
                file: path.map_or_else(|| self.name.clone(), |path| path.display().to_string()),
                source,
            })
        };
        LogReader::new(&self.name, channels, &mut open_file)
    }
}
