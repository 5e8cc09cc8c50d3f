//! Statistical tests that several folders share.

mod between_parts;
mod chi_square;
mod kind_of_change;
mod normal;
mod numerics;
mod significance;
mod sizes;
mod student;

pub(crate) use between_parts::between_parts;
pub(super) use kind_of_change::kind_of_change;
pub use normal::NORMAL_95;
pub(super) use numerics::{MAX_ITERATIONS, MAX_ROUNDS, RIDGE, ROUNDING};
pub(super) use significance::{
    CERTAIN_SIGMAS, FALSE_ALARM_PROBABILITY, HELD_OUT_PARTS, MIN_COST_SAVED, MIN_DELAY_SAMPLES,
    SHORT_STEP_SIGMAS, SIGNIFICANT_SIGMAS,
};
pub(super) use sizes::{
    LARGE_SHARE, NEGLIGIBLE_SHARE, SATURATED_ARGUMENT, SMALL_SHARE, UNKNOWN_RELATIVE_ERROR,
};
pub(crate) use student::both_tails;
