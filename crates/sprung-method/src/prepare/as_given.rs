//! Settings for reading a log before the searches in it.

use super::cutoff::choose_cutoff;
use super::excerpt::Excerpt;
use super::mounting::mounted;
use crate::description::{Cutoff, Delay, Identify};
use crate::log::Channels;
use crate::model::Model;
use crate::regression::Reading;

/// Returns the settings for reading a log as the description gives them, and the reason for the
/// cut-off if sprung chose it. Delays that are not given are zero, and all weights are equal.
#[must_use]
pub(crate) fn as_given(
    model: &Model,
    settings: &Identify,
    channels: &Channels,
    excerpt: &Excerpt,
) -> (Reading, Option<String>) {
    let channels = &mounted(channels, excerpt);
    let (cutoff, reason) = match settings.position_cutoff_hz {
        Cutoff::Fixed(cutoff) => (cutoff, None),
        Cutoff::Auto => {
            let (cutoff, reason) = choose_cutoff(model, channels, settings.weights, excerpt);
            (cutoff, Some(reason))
        }
    };
    let known = channels.all.iter().map(|channel| match channel.delay {
        Some(Delay::Known(delay)) => delay,
        Some(Delay::Estimate) | None => 0.0,
    });
    let reading = Reading::new(model, settings, channels, cutoff).at_period(excerpt.period());
    (reading.with_delays(&known.collect::<Vec<f64>>()), reason)
}
