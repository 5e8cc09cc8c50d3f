//! Results side by side: estimators, settings, runs, robots.

mod agreement;
mod chi_square;
mod labels;
mod result;
mod table;

pub use agreement::{RUNS_DISAGREE, SURE};
pub use chi_square::upper_tail;
pub use result::{ComparedParameter, ComparedResult, ComparedValue, Comparison};
pub use table::{CompareError, Compared, compare};
