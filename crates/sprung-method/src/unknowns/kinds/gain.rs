//! A channel that reads a constant factor too much or too little.

use std::sync::Arc;

use super::catalogued::Catalogued;
use super::words::{falls, or_else};
use crate::finding::{Finding, Severity};
use crate::log::Signal;
use crate::unknowns::found::{Competing, Telling};
use crate::unknowns::unknown::{ChannelEffect, Effect, Kind, Place, Samples, Unknown};

/// Usual errors, relative: of a position that another one confirms, and of a torque, whose constant is often a guess.
const USUAL_OF_POSITION: f64 = 0.05;
const USUAL_OF_TORQUE: f64 = 0.2;

/// Usual error of a gain that is asked for, relative.
const ASKED: f64 = 0.5;

#[derive(Debug)]
struct Gain {
    is_of_torque: bool,
}

impl ChannelEffect for Gain {
    fn perturb(&self, samples: &Samples<'_>, size: f64) -> Vec<f64> {
        samples.values.iter().map(|x| (1.0 + size) * x).collect()
    }

    fn scales_torque(&self) -> bool {
        self.is_of_torque
    }
}

pub(super) fn list(of: &Catalogued<'_>) -> Vec<Unknown> {
    // A common factor of all torques is a factor of all parameters.
    let signals: &[Signal] = if of.joints > 1 || of.is_known {
        &[Signal::Link, Signal::Motor, Signal::Torque]
    } else {
        &[Signal::Link, Signal::Motor]
    };
    let is_asked = |channel: usize| of.channels.all[channel].open_gain;
    let is_torque = |channel: usize| of.channels.all[channel].quantity.signal() == Signal::Torque;
    let asked = of
        .of_signals(&[Signal::Torque])
        .filter(|_| !signals.contains(&Signal::Torque));
    of.of_signals(signals)
        .filter(|channel| of.is_measured_twice(*channel))
        .chain(asked.filter(|channel| is_asked(*channel)))
        .map(|channel| Unknown {
            scale: if is_asked(channel) {
                ASKED
            } else if is_torque(channel) {
                USUAL_OF_TORQUE
            } else {
                USUAL_OF_POSITION
            },
            ..Unknown::new(
                format!("gain {}", of.channels.all[channel].column),
                Kind::Gain,
                Place::Channel(channel),
                "",
                Effect::Channels(
                    vec![channel],
                    Arc::new(Gain {
                        is_of_torque: is_torque(channel),
                    }),
                ),
            )
        })
        .collect()
}

/// Finding: a channel reads too much or too little.
pub(super) fn finding(of: &Telling<'_>) -> Finding {
    let column = of.columns.first().copied().unwrap_or_default();
    let (value, error) = (of.found.value, of.found.standard_error);
    // A number would hide its error from the parameters.
    let setting = match of.gain {
        Some(gain) => format!("gain = {{ \"{column}\" = {:.6} }}", gain * (1.0 + value)),
        None => format!("gain = {{ \"{column}\" = \"estimate\" }}"),
    };
    let finding = Finding::new(
        Severity::Warning,
        "channel-gain",
        format!(
            "{}: \"{column}\" reads {:.2} % too {} (standard error {:.2} %): multiplied by {:.4}, {}{}",
            of.joint,
            100.0 * value.abs(),
            if value < 0.0 { "much" } else { "little" },
            100.0 * error,
            1.0 + value,
            falls(of),
            or_else(of)
        ),
        "check counts per turn, gear ratio and unit of the column, or set its gain",
    )
    .seen(of.file, column, 1.0 + value, "");
    // Of gains with the same effect the log tells none.
    let is_rival = |rival: &Competing| rival.correlation >= 1.0 && rival.id.starts_with("gain ");
    if of.found.competing.iter().any(is_rival) {
        return finding;
    }
    finding.mended_by("[log]", &setting)
}
