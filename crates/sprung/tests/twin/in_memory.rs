//! Logs in memory, as sources.

use std::path::Path;

use sprung_log::{Input, LogSource};

/// Runs `use_source` on a log.
pub(crate) fn with_source<T>(log: &[u8], use_source: impl FnOnce(LogSource<'_>) -> T) -> T {
    let mut reader =
        |_: Option<&Path>| Ok(Box::new(std::io::Cursor::new(log.to_vec())) as Box<dyn Input>);
    use_source(LogSource::files("log", &mut reader))
}
