//! What each channel of a log did, and what that means.

mod channel;
mod check;
mod faults;
mod sizes;
mod summary;

pub use channel::{Event, Extent, Extreme, Figures, Overview, Stretch};
pub use check::check;
pub use sizes::Sizes;
pub use summary::{Line, Summary};
