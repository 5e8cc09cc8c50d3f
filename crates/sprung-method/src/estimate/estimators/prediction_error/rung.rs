//! The rungs of the ladder: limits of the slow disturbances.

use super::levels::Disturbances;

/// A rung of the ladder. Each rung allows less slow disturbance, so the parameters must explain
/// more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rung {
    /// Slow disturbances have any level.
    Free,
    /// Their spectrum is at most 10 times that of the white noise.
    Cap10,
    /// At most 3 times.
    Cap3,
    /// No slow disturbances.
    Flat,
}

impl Rung {
    /// All rungs, the first one first.
    pub(super) const ALL: [Self; 4] = [Self::Free, Self::Cap10, Self::Cap3, Self::Flat];

    /// Returns the name of the rung in the results.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::Cap10 => "cap10",
            Self::Cap3 => "cap3",
            Self::Flat => "flat",
        }
    }

    /// Returns the treatment of slow disturbances in words.
    pub(super) fn about(self) -> &'static str {
        match self {
            Self::Free => "slow disturbances of any level",
            Self::Cap10 => "slow disturbances up to 10 times the white noise",
            Self::Cap3 => "slow disturbances up to 3 times the white noise",
            Self::Flat => "no slow disturbances",
        }
    }

    pub(super) fn disturbances(self) -> Disturbances {
        match self {
            Self::Free => Disturbances::Free,
            Self::Cap10 => Disturbances::Capped(10.0),
            Self::Cap3 => Disturbances::Capped(3.0),
            Self::Flat => Disturbances::Zero,
        }
    }
}
