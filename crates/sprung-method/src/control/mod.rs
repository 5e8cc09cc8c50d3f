//! Design of control from identified values.

// A new law, parameter, quantity or format is named wherever it is told from the others.
#![warn(clippy::wildcard_enum_match_arm)]

mod margins;
mod pose;
mod sampled;
mod shapers;
#[cfg(test)]
mod tests;

pub use margins::{LoopPole, Margins, Stability, stability};
pub use shapers::{
    KindTrial, ModeShaper, ShapedImpulse, ShaperDesign, ShaperDesignError, ShaperKind,
    ShaperSettings, TradeOff, design_shaper,
};
