//! Accepts delays by blocked hold-out.

use super::excerpt::Excerpt;
use crate::fit::HoldOut;
use crate::regression::Reading;

/// Number of consecutive parts of the excerpt; each is predicted by a fit of the others.
const PARTS: usize = 8;

/// Two held-out errors are equal if they differ by less than this fraction.
const TIE_SHARE: f64 = 0.02;

/// Held-out error of the motor torques with two delays of a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DelayGain {
    /// Error relative to the torque, root mean squares, with the present delay.
    pub(crate) without: f64,
    /// The same with the new delay.
    pub(crate) with: f64,
}

impl DelayGain {
    /// Returns the gain of one delay over that of `reading`, which has the other delays; `None` if
    /// the excerpt is too short.
    ///
    /// - `channel`: index of the channel; `delay`: its delay, s.
    pub(crate) fn of(
        excerpt: &Excerpt,
        reading: &Reading,
        channel: usize,
        delay: f64,
    ) -> Option<Self> {
        Some(Self {
            without: held_out_at(excerpt, reading, channel, reading.delays()[channel])?,
            with: held_out_at(excerpt, reading, channel, delay)?,
        })
    }

    /// Returns the gain of other delays of all channels, s, over those of `reading`; `None` if the excerpt is too short.
    pub(crate) fn between(excerpt: &Excerpt, reading: &Reading, delays: &[f64]) -> Option<Self> {
        Some(Self {
            without: held_out(excerpt, reading)?,
            with: held_out(excerpt, &reading.with_delays(delays))?,
        })
    }

    /// Returns whether the delay lowers the held-out error by more than a tie.
    pub(crate) fn is_lower(&self) -> bool {
        self.with < (1.0 - TIE_SHARE) * self.without
    }

    /// Returns both errors in words: `from 12.3 % to 8.1 %`.
    pub(crate) fn words(&self) -> String {
        format!(
            "from {:.2} % to {:.2} %",
            100.0 * self.without,
            100.0 * self.with
        )
    }
}

/// Returns the held-out error of the motor torques with one delay, relative to the torques; `None`
/// if the excerpt is too short.
pub(crate) fn held_out_at(
    excerpt: &Excerpt,
    reading: &Reading,
    channel: usize,
    delay: f64,
) -> Option<f64> {
    let mut delays = reading.delays().to_vec();
    delays[channel] = delay;
    held_out(excerpt, &reading.with_delays(&delays))
}

/// Returns the held-out error of the motor torques, relative to the torques; `None` if the excerpt
/// is too short.
pub(super) fn held_out(excerpt: &Excerpt, reading: &Reading) -> Option<f64> {
    let reading = reading.without_weights();
    let system = excerpt.reduce(&reading)?;
    let hold_out = HoldOut::new(reading.model(), &system, PARTS);
    hold_out.missed_by_fits()?.of_torque_rows()
}
