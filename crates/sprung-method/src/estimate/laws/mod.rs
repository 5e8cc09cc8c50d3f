//! Laws of friction and springs that the model of an estimate has beside those of simulators, or lacks.

mod dependence;

pub(super) use dependence::dependence;
