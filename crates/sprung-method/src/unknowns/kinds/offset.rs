//! A link encoder whose zero is not that of the motor's.

use std::sync::Arc;

use super::catalogued::Catalogued;
use super::words::{falls, or_else};
use crate::finding::{Finding, Severity};
use crate::log::Signal;
use crate::unknowns::found::Telling;
use crate::unknowns::result::UnknownStatus;
use crate::unknowns::unknown::{ChannelEffect, Effect, Kind, Place, Samples, Unknown};

/// Usual offset, in root mean squares of the deflection.
const USUAL_DEFLECTIONS: f64 = 1.0;

#[derive(Debug)]
struct Offset;

impl ChannelEffect for Offset {
    fn perturb(&self, samples: &Samples<'_>, size: f64) -> Vec<f64> {
        samples.values.iter().map(|x| x + size).collect()
    }
}

pub(super) fn list(of: &Catalogued<'_>) -> Vec<Unknown> {
    of.of_signals(&[Signal::Link])
        .filter(|&channel| of.is_known || !of.has_preload(of.channels.all[channel].joint))
        .filter_map(|channel| {
            Some(Unknown {
                scale: USUAL_DEFLECTIONS * of.deflection(channel)?,
                least: of.count(channel),
                ..Unknown::new(
                    format!("offset {}", of.channels.all[channel].column),
                    Kind::Offset,
                    Place::Channel(channel),
                    of.unit_of_position(channel),
                    Effect::Channels(vec![channel], Arc::new(Offset)),
                )
            })
        })
        .collect()
}

/// Finding: the zeros of two encoders differ.
pub(super) fn finding(of: &Telling<'_>) -> Finding {
    let column = of.columns.first().copied().unwrap_or_default();
    let (value, unit) = (-of.found.value, of.found.unit);
    let (severity, used) = match of.status {
        UnknownStatus::Found => (
            Severity::Warning,
            "encoder_offset = \"none\" in [identify] keeps it out of the model",
        ),
        UnknownStatus::Given | UnknownStatus::Estimated | UnknownStatus::Applied => {
            (Severity::Info, "sprung estimates it")
        }
    };
    Finding::new(
        severity,
        "encoder-offset",
        format!(
            "{}: \"{column}\" is {value:.3e} {unit} (standard error {:.1e} {unit}) from the zero of the motor's encoder: without this \
             offset {}. {used}{}",
            of.joint,
            of.found.standard_error,
            falls(of),
            or_else(of)
        ),
        "set encoder_offset = \"estimate\" in [identify], so that the file says the same",
    )
    .seen(of.file, column, value, unit)
    .mended_by("[identify]", "encoder_offset = \"estimate\"")
}
