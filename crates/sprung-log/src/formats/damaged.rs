//! Damaged files: errors for them, and a guard for crates that panic on some of them.

use std::cell::Cell;

#[cfg(any(feature = "arrow", feature = "mcap", feature = "mat73"))]
use crate::error::LogError;

thread_local! {
    static GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// Returns whether sprung catches a panic of this thread and returns it as an error.
///
/// This holds while a crate that panics on some damaged files reads a file.
#[must_use]
pub fn panics_are_caught() -> bool {
    GUARDED.get()
}

/// Runs a crate that panics on some damaged files; returns a panic as an error.
#[cfg(any(feature = "arrow", feature = "mcap", feature = "mat73"))]
pub(super) fn guarded<T>(
    file: &str,
    read: impl FnOnce() -> Result<T, LogError>,
) -> Result<T, LogError> {
    let before = GUARDED.replace(true);
    let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(read));
    GUARDED.set(before);
    result.unwrap_or_else(|_| {
        Err(LogError::format(
            file,
            " is damaged: it contradicts itself; copy or write it again",
        ))
    })
}

/// Returns the error for a file in which a crate found an error.
#[cfg(feature = "arrow")]
pub(super) fn damaged(file: &str, error: &dyn std::fmt::Display) -> LogError {
    let error = error.to_string();
    if let Some((_, what)) = error.split_once("Disabled feature at compile time: ") {
        return LogError::format(
            file,
            format!(" is compressed with {what}, which is not read; write it with zstd or snappy"),
        );
    }
    LogError::format(
        file,
        format!(" is damaged or was cut off ({error}); copy or write it again"),
    )
}
