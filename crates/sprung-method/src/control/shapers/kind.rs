//! Kinds of sequences for one mode.

use serde::{Deserialize, Serialize};
use sprung_core::shaper::{Impulse, Mode, zero_vibration};

use super::humps::extra_insensitive;

/// Kind of a sequence for one mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ShaperKind {
    /// Two impulses; the residual vanishes at the mode.
    Zv,
    /// Three impulses; the residual and its derivative vanish.
    Zvd,
    /// Three impulses; the residual has a maximum at the mode.
    Ei,
    /// Four impulses; the residual and two derivatives vanish.
    Zvdd,
    /// Four impulses; the residual has a maximum on either side of the mode.
    TwoHumpEi,
    /// Five impulses; the residual has a maximum at the mode and one on either side.
    ThreeHumpEi,
}

impl ShaperKind {
    /// All kinds.
    pub const ALL: [Self; 6] = [
        Self::Zv,
        Self::Zvd,
        Self::Ei,
        Self::Zvdd,
        Self::TwoHumpEi,
        Self::ThreeHumpEi,
    ];

    /// Returns the name in texts.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Zv => "ZV",
            Self::Zvd => "ZVD",
            Self::Ei => "EI",
            Self::Zvdd => "ZVDD",
            Self::TwoHumpEi => "two-hump EI",
            Self::ThreeHumpEi => "three-hump EI",
        }
    }

    /// Returns the number of maxima of the residual whose level is chosen.
    pub(super) fn humps(self) -> usize {
        match self {
            Self::Zv | Self::Zvd | Self::Zvdd => 0,
            Self::Ei => 1,
            Self::TwoHumpEi => 2,
            Self::ThreeHumpEi => 3,
        }
    }

    /// Returns the sequence for a mode; `None` if there is none for its damping.
    ///
    /// - `hump`: residual vibration of the humps.
    pub(super) fn sequence(self, mode: &Mode, hump: f64) -> Option<Vec<Impulse>> {
        match self {
            Self::Zv => Some(zero_vibration::<2>(mode).to_vec()),
            Self::Zvd => Some(zero_vibration::<3>(mode).to_vec()),
            Self::Zvdd => Some(zero_vibration::<4>(mode).to_vec()),
            Self::Ei | Self::TwoHumpEi | Self::ThreeHumpEi => {
                extra_insensitive(mode, hump, self.humps())
            }
        }
    }
}
