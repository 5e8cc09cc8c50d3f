//! Reasons why there is no result.

mod identify;
mod lsff;

pub use identify::IdentifyError;
pub use lsff::LsffError;
