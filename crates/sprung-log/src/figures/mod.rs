//! Statistics of each channel of a log, and findings made from them.

mod channel;
mod check;
mod covariates;
mod deflection;
mod faults;
mod sizes;
mod slope;
mod summary;

pub use channel::{Figures, Overview};
pub use check::check;
pub use check::{LOOKS_LIKE_DEGREES, LOOKS_LIKE_RADIANS};
pub use faults::{SPIKES, STUCK_SAMPLES, longer_part};
pub use sizes::Sizes;
pub use slope::{rounded, slope_remedy};
pub use summary::Summary;
