//! Laws of friction and springs that the model of an estimate has beside those of simulators, or lacks.

mod dependence;
mod tested;

pub(super) use dependence::dependence;
pub(super) use tested::{Tested, with_tested_laws};
