//! The steps of an identification, in their order: prepare, pass, examine, fit, refine, describe.

mod basis;
mod curves;
mod describe;
mod examine;
mod fit;
mod identified;
mod joint_curves;
mod log_info;
mod one_result;
mod pass;
mod prepare;
mod refine;
mod refuse;
mod springs_of_motors;

pub(super) use basis::{Basis, Logs};
pub(super) use describe::{before_refinement, describe};
pub(super) use examine::examine;
pub(super) use fit::fit;
pub use identified::Identified;
pub(super) use pass::{ReadLogs, pass};
pub(super) use prepare::{Ready, make_ready};
pub(super) use refine::{Refined, refine};
