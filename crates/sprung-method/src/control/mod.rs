//! Design of control from identified values.

// The compiler names each place that must handle a new law, parameter, quantity or format.
#![warn(clippy::wildcard_enum_match_arm)]

mod bandwidth;
mod bode;
mod design;
mod gains;
mod judge;
mod linear;
mod margins;
mod modes;
mod motions;
mod pictures;
mod pose;
mod proof;
mod refusal;
mod result;
mod riccati;
mod sampled;
mod shapers;
mod task;
#[cfg(test)]
mod tests;
mod vibrations;
mod workspace;

pub use design::{Controlled, design_control};
pub use margins::{LoopPole, Margins, Stability, stability};
pub use pictures::{Banded, ControlPictures, LinkCurves, LoopCurve, PoleInPose, Timed};
pub use refusal::ControlRefusal;
pub use result::{
    Bandwidth, CONTROL_FORMAT, ControlDesign, DesignedController, LoopMargins, Mode, Motors, Moves,
    Proof, Tracking, Vibration, WithDraws,
};
pub use shapers::{
    ModeShaper, ShapedImpulse, ShaperDesign, ShaperDesignError, ShaperSettings, design_shaper,
};
pub use task::ControlTask;
pub use workspace::workspace_poses;
