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

/// Usual root mean square of the error over the motion, in root mean squares of the deflection.
const USUAL_DEFLECTIONS: f64 = 0.2;

/// Usual amplitude, rad, of an encoder whose joint moves over a short arc: there, a larger one changes the deflection little.
const USUAL_RAD: f64 = 5e-3;

/// Least standard deviation, rad, of a position that moves over an arc.
const LEAST_MOTION: f64 = 0.1;

#[derive(Debug)]
struct Eccentricity {
    is_cosine: bool,
}

impl ChannelEffect for Eccentricity {
    fn perturb(&self, samples: &Samples<'_>, size: f64) -> Vec<f64> {
        (samples.values.iter())
            .map(|x| x + size * self.wave(*x))
            .collect()
    }
}

impl Eccentricity {
    fn wave(&self, x: f64) -> f64 {
        if self.is_cosine {
            x.cos() - 1.0
        } else {
            x.sin()
        }
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
            let effect = Eccentricity { is_cosine };
            let usual = USUAL_DEFLECTIONS * deflection;
            let moves = of.deviation_of(channel, |x| x) > LEAST_MOTION;
            let spread = if moves {
                of.deviation_of(channel, |x| effect.wave(x))
            } else {
                1.0
            };
            all.push(Unknown {
                scale: (usual / spread).min(USUAL_RAD).max(usual),
                least: of.count(channel),
                is_rare: true,
                shown_by: ShownBy::Both,
                ..Unknown::new(
                    format!("eccentricity {} {phase}", of.channels.all[channel].column),
                    Kind::Eccentricity,
                    Place::Channel(channel),
                    "rad",
                    Effect::Channels(vec![channel], Arc::new(effect)),
                )
            });
        }
    }
    all
}

/// Finding: the error of an encoder repeats with each turn.
pub(super) fn finding(of: &Telling<'_>) -> Finding {
    let column = of.columns.first().copied().unwrap_or_default();
    let value = of.found.value;
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
