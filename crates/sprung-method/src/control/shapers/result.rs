//! A designed shaper, as result.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sprung_core::shaper::Impulse;

/// A shaper for one or several modes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ShaperDesign {
    /// Whether the largest residual is at most the allowed one.
    pub reached: bool,
    /// Allowed residual vibration, in percent of that without shaper.
    pub level_percent: f64,
    /// Sampling period of the filter, s.
    pub period_s: f64,
    /// The modes, in the order of the input.
    pub modes: Vec<ModeShaper>,
    /// Impulses of the whole sequence, in the order of time. Their amplitudes have the sum 1.
    pub impulses: Vec<ShapedImpulse>,
    /// Time of the last impulse, s. The filter is at most one sampling period slower.
    pub delay_s: f64,
    /// Largest residual vibration of the sampled sequence over all regions, percent.
    pub largest_percent: f64,
    /// Median over the region of a mode, percent; that of the mode with the largest median.
    pub median_percent: f64,
}

/// The part of a shaper for one mode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "ShapedMode")]
pub struct ModeShaper {
    /// Number of impulses of the sequence, one more than the frequencies without residual vibration; absent in designs of
    /// earlier versions.
    #[serde(default)]
    pub impulses: usize,
    /// Natural frequency for which the sequence is designed, Hz.
    pub centre_hz: f64,
    /// Damping ratio for which it is designed.
    pub damping: f64,
    /// Residual vibration at the maxima between these frequencies, percent; absent for two impulses.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hump_percent: Option<f64>,
    /// Largest residual vibration of the mode under the whole sampled sequence, percent.
    pub largest_percent: f64,
    /// Median over its region, percent.
    pub median_percent: f64,
}

/// An impulse of the sequence.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ShapedImpulse {
    /// Time after the command, s.
    pub time_s: f64,
    /// Part of the command.
    pub amplitude: f64,
}

impl ShaperDesign {
    /// Returns the sequence for the filter, [`sprung_core::shaper::sample`].
    #[must_use]
    pub fn sequence(&self) -> Vec<Impulse> {
        let impulse = |impulse: &ShapedImpulse| Impulse {
            time: impulse.time_s,
            amplitude: impulse.amplitude,
        };
        self.impulses.iter().map(impulse).collect()
    }
}
