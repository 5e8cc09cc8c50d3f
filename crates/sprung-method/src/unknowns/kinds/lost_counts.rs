//! A position that jumps once, because its encoder lost counts.

use std::sync::Arc;

use super::catalogued::Catalogued;
use super::words::{falls, or_else};
use crate::finding::{Finding, Severity};
use crate::log::{Signal, longer_part};
use crate::unknowns::found::Telling;
use crate::unknowns::unknown::{ChannelEffect, Effect, Kind, Place, Samples, Unknown};

/// Number of times, evenly over the log, at which a jump is looked for; its time is refined between them.
const KNOTS: usize = 12;

/// Number of single samples of each joint at which a jump is looked for: those where the deflection jumps most.
const LARGEST_JUMPS: usize = 2;

#[derive(Debug)]
pub(crate) struct Jump {
    /// Time of the first sample after it, s.
    at: f64,
    /// Whether this time is known to the sample.
    is_sharp: bool,
}

impl ChannelEffect for Jump {
    fn perturb(&self, samples: &Samples<'_>, size: f64) -> Vec<f64> {
        (samples.values.iter().zip(samples.time))
            .map(|(x, time)| if *time >= self.at { x + size } else { *x })
            .collect()
    }

    fn has_rate(&self) -> bool {
        self.is_sharp
    }

    fn begins(&self) -> Option<f64> {
        Some(self.at)
    }
}

/// Returns the jump of a channel at a time.
pub(crate) fn at(of: &Catalogued<'_>, channel: usize, at: f64, is_sharp: bool) -> Option<Unknown> {
    Some(Unknown {
        scale: if is_sharp { 5.0 } else { 1.0 } * of.deflection(channel)?,
        least: of.count(channel),
        is_rare: true,
        ..Unknown::new(
            format!("lost counts {}", of.channels.all[channel].column),
            Kind::LostCounts,
            Place::Channel(channel),
            of.unit_of_position(channel),
            Effect::Channels(vec![channel], Arc::new(Jump { at, is_sharp })),
        )
    })
}

pub(super) fn list(of: &Catalogued<'_>) -> Vec<Unknown> {
    let [begin, duration] = of.span;
    let mut all = Vec::new();
    for channel in of.of_signals(&[Signal::Link, Signal::Motor]) {
        let knots = (1..KNOTS).map(|k| begin + duration * k as f64 / KNOTS as f64);
        let places = knots.map(|time| (time, false));
        let jumps = of
            .largest_jumps(channel, LARGEST_JUMPS)
            .into_iter()
            .map(|time| (time, true));
        for (k, (time, is_sharp)) in places.chain(jumps).enumerate() {
            if let Some(unknown) = at(of, channel, time, is_sharp) {
                all.push(Unknown {
                    id: format!("{} {k}", unknown.id),
                    ..unknown
                });
            }
        }
    }
    all
}

/// Finding: a position jumps once.
pub(super) fn finding(of: &Telling<'_>) -> Finding {
    let column = of.columns.first().copied().unwrap_or_default();
    let (value, unit) = (-of.found.value, of.found.unit);
    let at = of.found.begins.unwrap_or_default();
    let part = longer_part(of.file, at, of.excerpt.span());
    Finding::new(
        Severity::Warning,
        "position-jumps",
        format!(
            "{}: \"{column}\" jumps by {value:.3e} {unit} (standard error {:.1e} {unit}) at {at:.3} s and stays there: without this \
             jump {}{}",
            of.joint,
            of.found.standard_error,
            falls(of),
            or_else(of)
        ),
        "check the encoder and its reader: counts were lost, or the sensor was reset; use the log up to this time, or after it",
    )
    .seen(of.file, column, value, unit)
    .at(at)
    .mended_by("[log]", &part)
}
