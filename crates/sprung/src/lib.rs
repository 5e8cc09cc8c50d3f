//! sprung
pub mod description;
pub mod finding;
pub mod log;
pub mod model;
pub mod simulate;
pub mod preprocess;
