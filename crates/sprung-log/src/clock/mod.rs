//! Sampling times: the clock of the samples, and resampling of uneven samples.
//!
//! [`cycle`] tracks a clock that ticks once per period. [`evidence`] decides whether samples were
//! taken at the stamps or at the ticks of the clock. [`resample`] interpolates. [`grid`] combines
//! these steps. [`timing`] holds the results, and [`check`] makes findings from them.

mod check;
mod cycle;
mod evidence;
pub(super) mod grid;
pub(super) mod resample;
pub(super) mod timing;
mod watch;

pub use check::{TIME_UNIT, check_timing, time_unit};
pub use timing::{Jitter, Sampling, Timing};
