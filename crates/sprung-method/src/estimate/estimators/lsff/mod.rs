//! LSFF, the on-line estimator of the paper.

mod on_line;
mod recursion;

pub(in crate::estimate) use on_line::{OnLine, on_line};
pub use recursion::Lsff;
