//! Figures of how a log was sampled.

use crate::log::error::Place;

/// When the samples of a log were taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sampling {
    /// One each period; time stamps that say otherwise were rounded or late.
    Even,
    /// At whole multiples of a cycle, s, which time stamps tell to the nearest.
    OnCycle(f64),
    /// When their time stamps say.
    AsStamped,
}

impl Sampling {
    /// Returns the name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Even => "even",
            Self::OnCycle(_) => "on-cycle",
            Self::AsStamped => "as-stamped",
        }
    }

    /// Returns the cycle, s, if there is one.
    #[must_use]
    pub fn cycle(self) -> Option<f64> {
        match self {
            Self::OnCycle(cycle) => Some(cycle),
            Self::Even | Self::AsStamped => None,
        }
    }
}

/// Something that happened at samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Count {
    /// How often.
    pub count: u64,
    /// Where first.
    pub first: Option<Place>,
}

impl Count {
    /// Counts `more` at a place.
    pub(in crate::log) fn add(&mut self, more: u64, place: impl Into<Option<Place>>) {
        if more > 0 {
            self.count += more;
            self.first = self.first.or(place.into());
        }
    }
}

/// Gaps of a log.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gaps {
    /// How many.
    pub count: u64,
    /// How long together, s.
    pub duration: f64,
}

/// What tells stamped from even samples: how far samples lie from the cubic
/// through their four neighbours, where steps are uneven.
///
/// Root mean squares of the most telling channel, in its unit, made alike for
/// all by the noise that they would show without any motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evidence {
    /// Samples that were looked at.
    pub samples: u64,
    /// Index of the channel in [`Channels::all`](crate::log::Channels::all).
    pub channel: usize,
    /// If samples were taken when stamped.
    pub stamped: f64,
    /// If evenly.
    pub even: f64,
    /// If at multiples of the likeliest cycle, s.
    pub on_cycle: (f64, f64),
    /// Whether this decides.
    pub decisive: bool,
}

/// How a log was sampled, so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timing {
    /// Samples in the file.
    pub recorded: u64,
    /// Period of the samples that are handed on, s; 0 until it is known.
    pub period: f64,
    /// Time between the first and the last sample, s.
    pub duration: f64,
    /// Largest deviation of a step between time stamps from the period (of
    /// missing samples: from so many periods), as a part of the period.
    pub jitter: f64,
    /// Root mean square of these deviations.
    pub jitter_rms: f64,
    /// When samples were taken; nothing until that is known.
    pub sampling: Option<Sampling>,
    /// What that was decided by, if it had to be.
    pub evidence: Option<Evidence>,
    /// Samples that were written twice, with one time, and left out.
    pub repeated: Count,
    /// Samples that repeat all values of the one before although a joint moves.
    pub frozen: Count,
    /// Samples that are missing, at most three together, and were interpolated.
    pub dropped: Count,
    /// Samples between which more are missing.
    pub gaps: Gaps,
    /// Samples handed on that were interpolated.
    pub interpolated: u64,
}
