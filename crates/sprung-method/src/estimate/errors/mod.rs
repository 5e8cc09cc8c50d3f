//! Reasons why there is no result.

mod factors;
mod identify;
mod lsff;

pub use factors::FactorsError;
pub use identify::IdentifyError;
pub use lsff::LsffError;
