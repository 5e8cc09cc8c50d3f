//! Design of input shapers: the shortest sequence of impulses that leaves little vibration of modes which are known
//! with an uncertainty.

mod centre;
mod combine;
mod design;
mod humps;
mod region;
mod result;
#[cfg(test)]
mod tests;

pub use design::{ShaperDesignError, ShaperSettings, design_shaper};
pub use result::{ModeShaper, ShapedImpulse, ShaperDesign};
