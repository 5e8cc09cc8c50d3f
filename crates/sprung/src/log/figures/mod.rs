//! Statistics of each channel of a log, and findings made from them.

mod channel;
mod check;
mod faults;
mod sizes;
mod summary;

pub(crate) use channel::{Figures, Overview};
pub use check::check;
pub use sizes::Sizes;
pub(crate) use summary::Summary;
