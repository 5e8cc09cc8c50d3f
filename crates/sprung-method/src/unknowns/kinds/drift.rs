//! A position whose zero moves evenly during the log.

use std::sync::Arc;

use super::catalogued::Catalogued;
use super::words::{falls, or_else};
use crate::finding::{Finding, Severity};
use crate::log::Signal;
use crate::unknowns::found::Telling;
use crate::unknowns::unknown::{ChannelEffect, Effect, Kind, Place, Samples, Unknown};

#[derive(Debug)]
struct Drift;

impl ChannelEffect for Drift {
    /// - `size`: over the whole span.
    fn perturb(&self, samples: &Samples<'_>, size: f64) -> Vec<f64> {
        let [begin, duration] = samples.span;
        (samples.values.iter().zip(samples.time))
            .map(|(x, time)| x + size * (time - begin) / duration)
            .collect()
    }
}

pub(super) fn list(of: &Catalogued<'_>) -> Vec<Unknown> {
    of.of_signals(&[Signal::Link, Signal::Motor])
        .filter_map(|channel| {
            Some(Unknown {
                scale: of.deflection(channel)?,
                least: of.count(channel),
                is_rare: true,
                ..Unknown::new(
                    format!("drift {}", of.channels.all[channel].column),
                    Kind::Drift,
                    Place::Channel(channel),
                    of.unit_of_position(channel),
                    Effect::Channels(vec![channel], Arc::new(Drift)),
                )
            })
        })
        .collect()
}

/// Finding: the zero of a position moves.
pub(super) fn finding(of: &Telling<'_>) -> Finding {
    let column = of.columns.first().copied().unwrap_or_default();
    let (value, unit) = (-of.found.value, of.found.unit);
    Finding::new(
        Severity::Warning,
        "position-drifts",
        format!(
            "{}: the zero of \"{column}\" moves evenly by {value:.3e} {unit} (standard error {:.1e} {unit}) during the log: without \
             this drift {}{}",
            of.joint,
            of.found.standard_error,
            falls(of),
            or_else(of)
        ),
        "check the coupling of the encoder and whether it loses counts; record a shorter log until it is mended",
    )
    .seen(of.file, column, value, unit)
}
