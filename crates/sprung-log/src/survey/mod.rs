//! Survey of an unknown log: its columns and their contents.
//!
//! [`Survey::read`] reads the names of all columns and a bounded number of samples: a beginning, an
//! end and parts between them. [`choose`] assigns columns to the quantities of a robot's joints,
//! first by their names, then by their contents, and explains each decision.

mod blocks;
mod by_content;
mod choose;
mod error;
mod families;
mod figures;
mod join;
mod joint_names;
mod parts;
mod period;
mod positions;
mod read;
mod recorders;
mod robots;
mod slopes;
mod times;
mod torques;
mod units;
mod words;
mod write;

pub use choose::{choose, joint_count};
pub use error::ChooseError;
pub use joint_names::joint_names;
pub use read::Survey;
