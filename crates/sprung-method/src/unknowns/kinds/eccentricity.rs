//! An encoder whose error repeats with each turn.

use std::sync::Arc;

use super::catalogued::Catalogued;
use super::words::{falls, or_else};
use crate::finding::{Finding, Severity};
use crate::log::Signal;
use crate::unknowns::found::Telling;
use crate::unknowns::unknown::{
    ChannelEffect, Effect, Kind, PHASES, Place, Samples, ShownBy, Unknown,
};

/// Usual amplitude, in root mean squares of the deflection.
const USUAL_DEFLECTIONS: f64 = 0.2;

#[derive(Debug)]
struct Eccentricity {
    is_cosine: bool,
}

impl ChannelEffect for Eccentricity {
    fn perturb(&self, samples: &Samples<'_>, size: f64) -> Vec<f64> {
        let wave = |x: f64| {
            if self.is_cosine {
                x.cos() - 1.0
            } else {
                x.sin()
            }
        };
        samples.values.iter().map(|x| x + size * wave(*x)).collect()
    }
}

pub(super) fn list(of: &Catalogued<'_>) -> Vec<Unknown> {
    let mut all = Vec::new();
    for channel in of
        .of_signals(&[Signal::Link])
        .filter(|&channel| of.turns(channel))
    {
        for (phase, is_cosine) in PHASES {
            let Some(deflection) = of.deflection(channel) else {
                continue;
            };
            all.push(Unknown {
                scale: USUAL_DEFLECTIONS * deflection,
                least: of.count(channel),
                is_rare: true,
                shown_by: ShownBy::Both,
                ..Unknown::new(
                    format!("eccentricity {} {phase}", of.channels.all[channel].column),
                    Kind::Eccentricity,
                    Place::Channel(channel),
                    "rad",
                    Effect::Channels(vec![channel], Arc::new(Eccentricity { is_cosine })),
                )
            });
        }
    }
    all
}

/// Finding: the error of an encoder repeats with each turn.
pub(super) fn finding(of: &Telling<'_>) -> Finding {
    let column = of.columns.first().copied().unwrap_or_default();
    let value = of.found.value.abs();
    Finding::new(
        Severity::Warning,
        "eccentric-encoder",
        format!(
            "{}: \"{column}\" has an error of {value:.2e} rad (standard error {:.1e} rad) that repeats with each turn: without it {}{}",
            of.joint,
            of.found.standard_error,
            falls(of),
            or_else(of)
        ),
        "check how the encoder is centred, or use two reading heads",
    )
    .seen(of.file, column, value, "rad")
}
