//! Design of control from identified values.

mod shapers;

pub use shapers::{
    KindTrial, ModeShaper, ShapedImpulse, ShaperDesign, ShaperDesignError, ShaperKind,
    ShaperSettings, TradeOff, design_shaper,
};
