//! Checks of a description that its types do not make; each fault has the path of its keys.

mod columns;
mod control;
mod excite;
mod experiment;
mod fault;
mod identify;
mod inertial;
mod laws;
mod log;
mod name;
mod payload;
mod robot;
mod run;
mod servo;
mod time;
mod window;

pub(super) use experiment::{check, check_format, check_log_over};
pub(super) use fault::{Fault, fault};
pub(super) use name::check_name;
pub(super) use robot::kinematics;
pub(super) use run::check_reference;
