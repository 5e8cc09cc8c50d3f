//! When samples were taken: the clock behind time stamps, and even samples of uneven ones.
//!
//! [`cycle`] follows a clock that ticks once a period; [`evidence`] weighs whether stamps or
//! the clock say when samples were taken; [`resample`] interpolates; [`grid`] puts all together.
//! [`timing`] has the figures, [`check`] says what they mean.

mod check;
mod cycle;
mod evidence;
pub(super) mod grid;
pub(super) mod resample;
pub(super) mod timing;
mod watch;

pub(crate) use check::{check_timing, time_unit};
pub use timing::{Sampling, Timing};
