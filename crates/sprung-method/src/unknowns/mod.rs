//! What a log does not say of itself: channels that are late, scaled, shifted or drifting, and laws that the description lacks.
//!
//! An unknown has one definition: what the samples would be without it, if it had a size. The derivative by the size is its column
//! in one regression, which has the columns of all unknowns; its correction is the same function at the size that was found.
//! `settle` regresses, selects the unknown that best explains parts of the log which the fit has not seen, applies it, and repeats
//! this until nothing is left. All causes compete.

mod added_law;
mod changes;
mod confirmed_laws;
mod directions;
mod evidence;
mod far;
mod found;
mod gauge;
mod innovations;
mod jumps;
mod kinds;
mod law_columns;
mod meanings;
mod result;
mod rows;
mod search;
mod searched;
mod select;
mod settle;
mod settled;
mod sizes;
mod sliding;
mod spring_rivals;
mod state;
mod unknown;

pub(crate) use added_law::changed;
pub use added_law::with_added_laws;
pub(crate) use changes::{Asked, FoundChange, changes};
pub(crate) use evidence::Pull;
pub(crate) use found::Found;
pub(crate) use innovations::{Innovations, OfLikelihood, PARTS_OF_INNOVATIONS, Shown};
pub(crate) use kinds::{LAWS_MISSING, LEAST_CHANGE_OF_SHARPNESS, late};
pub use result::{AddedLaw, CompetingUnknown, UnknownResult, UnknownStatus};
pub use searched::AboutUnknowns;
pub(crate) use searched::{Settled, by_likelihood};
pub(crate) use settle::settle;
pub(crate) use settled::settled;
pub(crate) use unknown::{
    ChannelEffect, Effect, JointScales, Kind, LawColumn, MotorSample, OfMotor, Place, Samples,
    Unknown,
};
