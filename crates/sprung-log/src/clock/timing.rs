//! Results of the analysis of a log's sampling.

use crate::description::Window;
use crate::error::Place;
use crate::select::Beyond;

/// Times at which the samples of a log were taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sampling {
    /// Once per period; deviating time stamps were rounded or late.
    Even,
    /// At whole multiples of a cycle, s; the time stamps show which multiples.
    OnCycle(f64),
    /// At the times of the stamps.
    AsStamped,
}

impl Sampling {
    /// Returns the name used in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Even => "even",
            Self::OnCycle(_) => "on-cycle",
            Self::AsStamped => "as-stamped",
        }
    }

    /// Returns the cycle, s, for sampling on a cycle.
    #[must_use]
    pub fn cycle(self) -> Option<f64> {
        match self {
            Self::OnCycle(cycle) => Some(cycle),
            Self::Even | Self::AsStamped => None,
        }
    }
}

/// Number of occurrences, with the place of the first.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Count {
    /// Number of occurrences.
    pub count: u64,
    /// Place of the first.
    pub first: Option<Place>,
}

impl Count {
    /// Adds `more` occurrences at a place.
    pub(crate) fn add(&mut self, more: u64, place: impl Into<Option<Place>>) {
        if more > 0 {
            self.count += more;
            self.first = self.first.or(place.into());
        }
    }
}

/// Gaps of a log.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gaps {
    /// Number of gaps.
    pub count: u64,
    /// Total duration, s.
    pub duration: f64,
}

/// Evidence about sampling times: distances of samples from the cubic through their four
/// neighbours, at uneven steps.
///
/// The values are root mean squares for the channel that differs most between the hypotheses, in
/// its unit. They are scaled so that white noise alone gives equal values under all hypotheses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evidence {
    /// Number of samples examined.
    pub samples: u64,
    /// Index of the channel in [`Channels::all`](crate::Channels::all).
    pub channel: usize,
    /// Distance if samples were taken as stamped.
    pub stamped: f64,
    /// Distance if samples were taken evenly.
    pub even: f64,
    /// Likeliest cycle, s, and the distance if samples were taken at its multiples.
    pub on_cycle: (f64, f64),
    /// Whether the evidence is decisive.
    pub decisive: bool,
}

/// Deviations of steps between time stamps from the nearest whole number of periods, as a fraction of the period.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Jitter {
    /// The largest.
    pub largest: f64,
    /// Root mean square.
    pub rms: f64,
}

/// Sampling of the part of a log that was read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timing {
    /// Number of samples in the file, or in the window of it.
    pub recorded: u64,
    /// Window of the log that is read.
    pub window: Window,
    /// Extent of this window beyond the log.
    pub beyond: Beyond,
    /// Period of the resampled log, s; 0 until it is known.
    pub period: f64,
    /// Time of the first sample in the log's own time column, s.
    pub start: f64,
    /// Time between the first and the last sample, s.
    pub duration: f64,
    /// How uneven the time stamps are.
    pub jitter: Jitter,
    /// When samples were taken; `None` until it is known.
    pub sampling: Option<Sampling>,
    /// Evidence for this decision, if it was needed.
    pub evidence: Option<Evidence>,
    /// Samples left out because they repeat the time and the values of the preceding one.
    pub repeated: Count,
    /// Samples left out because a column has no value.
    pub lacking: Count,
    /// Samples that repeat all values of the preceding one although a joint moves.
    pub frozen: Count,
    /// Missing samples that were interpolated, at most three in a row.
    pub dropped: Count,
    /// Gaps, in which more samples are missing.
    pub gaps: Gaps,
    /// Number of resampled samples that were interpolated.
    pub interpolated: u64,
}
