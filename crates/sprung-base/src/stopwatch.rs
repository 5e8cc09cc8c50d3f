//! Measures durations. Only this module reads a clock.

use std::time::Instant;

/// Whether the target has a clock. Reading the clock panics on a target without one.
const HAS_CLOCK: bool = !cfg!(all(target_family = "wasm", target_os = "unknown"));

/// Measures the time since its start.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch(Option<Instant>);

impl Stopwatch {
    /// Returns a running stopwatch.
    pub fn start() -> Self {
        Self(HAS_CLOCK.then(Instant::now))
    }

    /// Returns the time since the start, s; zero on a target without a clock.
    #[must_use]
    pub fn seconds(self) -> f64 {
        self.0.map_or(0.0, |start| start.elapsed().as_secs_f64())
    }
}
