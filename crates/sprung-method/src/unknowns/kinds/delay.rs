//! A channel, or one signal of all joints, that is recorded late.

use std::sync::Arc;

use super::catalogued::Catalogued;
use super::words::{falls, or_else};
use crate::description::Delay as Given;
use crate::finding::{Finding, Severity};
use crate::log::Signal;
use crate::numbers::{in_ms, with_error};
use crate::unknowns::found::Telling;
use crate::unknowns::unknown::{ChannelEffect, Effect, Kind, Place, Samples, ShownBy, Unknown};

/// Usual delay, s.
const USUAL_S: f64 = 0.010;

/// Delay of all torques by controller and recorder, in samples.
const EXPECTED_SAMPLES: f64 = 1.5;

/// Usual delay if the description asks for it, s. Sensors with a filter of their own are late by its lag.
const ASKED_S: f64 = 0.1;

#[derive(Debug)]
struct Delay;

impl ChannelEffect for Delay {
    /// Reads the channel later by the delay, by a cubic through four samples.
    fn perturb(&self, samples: &Samples<'_>, size: f64) -> Vec<f64> {
        let x = samples.values;
        let last = x.len().saturating_sub(1);
        let shift = size / samples.period;
        let whole = shift.floor();
        let f = shift - whole;
        let weights = [
            -f * (f - 1.0) * (f - 2.0) / 6.0,
            (f + 1.0) * (f - 1.0) * (f - 2.0) / 2.0,
            -(f + 1.0) * f * (f - 2.0) / 2.0,
            (f + 1.0) * f * (f - 1.0) / 6.0,
        ];
        let at = |k: i64| x[k.clamp(0, last as i64) as usize];
        (0..x.len() as i64)
            .map(|k| {
                let first = k + whole as i64 - 1;
                (weights.iter().zip(first..))
                    .map(|(weight, k)| weight * at(k))
                    .sum()
            })
            .collect()
    }
}

/// Returns the unknown of some channels that are late together.
pub(crate) fn late(id: String, place: Place, channels: Vec<usize>) -> Unknown {
    Unknown {
        scale: USUAL_S,
        shown_by: ShownBy::Both,
        ..Unknown::new(
            id,
            Kind::Delay,
            place,
            "s",
            Effect::Channels(channels, Arc::new(Delay)),
        )
    }
}

pub(super) fn list(of: &Catalogued<'_>) -> Vec<Unknown> {
    let open = |channel: &usize| !matches!(of.channels.all[*channel].delay, Some(Given::Known(_)));
    let is_only_torque = |channel: &usize| {
        of.channels.all[*channel].quantity.signal() == Signal::Torque
            && of.of_signals(&[Signal::Torque]).count() == 1
    };
    let signals = [Signal::Link, Signal::Motor, Signal::Torque];
    let is_asked = |channel: usize| of.channels.all[channel].delay == Some(Given::Estimate);
    // If the description asks for the delays of all other channels of a joint, they are delays against this one.
    let is_reference = |channel: &usize| {
        let joint = of.channels.all[*channel].joint;
        let mut others = of
            .of_signals(&signals)
            .filter(|other| other != channel && of.channels.all[*other].joint == joint)
            .peekable();
        others.peek().is_some() && !is_asked(*channel) && others.all(is_asked)
    };
    let mut all: Vec<Unknown> = (of.of_signals(&signals))
        .filter(|channel| open(channel) && !is_only_torque(channel) && !is_reference(channel))
        .map(|channel| {
            let column = &of.channels.all[channel].column;
            Unknown {
                scale: if is_asked(channel) { ASKED_S } else { USUAL_S },
                ..late(
                    format!("delay {column}"),
                    Place::Channel(channel),
                    vec![channel],
                )
            }
        })
        .collect();
    for (signal, name) in [
        (Signal::Link, "link positions"),
        (Signal::Motor, "motor positions"),
        (Signal::Torque, "torques"),
    ] {
        let channels: Vec<usize> = of.of_signals(&[signal]).collect();
        // The delay of the only torque is the timing of all torques.
        let is_common = channels.len() > 1 || signal == Signal::Torque && channels.len() == 1;
        if is_common && channels.iter().all(open) {
            // Few recorders say for how long a torque acts.
            let is_open = signal == Signal::Torque && of.channels.torque_hold.is_none();
            let expected = if is_open {
                EXPECTED_SAMPLES * of.period
            } else {
                0.0
            };
            all.push(Unknown {
                expected,
                ..late(format!("delay all {name}"), Place::All(signal), channels)
            });
        }
    }
    all
}

/// Finding: a channel is late.
pub(super) fn finding(of: &Telling<'_>) -> Finding {
    if of.moves.is_some() {
        return likely(of, &format!("\"{}\" was", of.columns.join("\", \"")));
    }
    let (value, error) = (of.found.value, of.found.standard_error);
    let when = if value < 0.0 { "early" } else { "late" };
    let columns: Vec<String> = of
        .columns
        .iter()
        .map(|column| format!("\"{column}\""))
        .collect();
    let settings: Vec<String> = of
        .columns
        .iter()
        .map(|column| format!("\"{column}\" = {value:.6}"))
        .collect();
    let setting = format!("delay_s = {{ {} }}", settings.join(", "));
    let [late, late_error] = with_error(in_ms(value.abs()), in_ms(error));
    Finding::new(
        Severity::Info,
        "delayed-channel",
        format!(
            "{} {} recorded {late} ms {when} (standard error {late_error} ms): with this delay {}. sprung uses it{}",
            columns.join(", "),
            if columns.len() == 1 { "was" } else { "were" },
            falls(of),
            or_else(of)
        ),
        "give the delay as a number to keep it fixed, or mend the recorder",
    )
    .seen(of.file, of.columns.first().copied().unwrap_or_default(), value, "s")
    .mended_by("[log]", &setting)
}

/// Finding: all torques act at another time than their stamps.
pub(super) fn timing(of: &Telling<'_>) -> Finding {
    if of.moves.is_some() {
        return likely(of, "every motor torque was");
    }
    let (value, error) = (of.found.value, of.found.standard_error);
    let when = if value < 0.0 { "later" } else { "earlier" };
    let [size, size_error] = with_error(in_ms(value.abs()), in_ms(error));
    Finding::new(
        Severity::Info,
        "torque-timing",
        format!(
            "the torques act {size} ms {when} (standard error {size_error} ms, {:.2} samples) than torques that are held from their time \
             stamp to the next one: {}. sprung uses this timing{}",
            value.abs() / of.excerpt.period(),
            falls(of),
            or_else(of)
        ),
        "nothing; torque and controller_period_s in [log] say the same if they are known",
    )
    .seen(of.file, of.columns.first().copied().unwrap_or_default(), value, "s")
}

/// Finding: a channel is late by likelihood. The hold-out that follows completes the name of the log.
fn likely(of: &Telling<'_>, what: &str) -> Finding {
    let value = of.found.value;
    let when = if value < 0.0 { "early" } else { "late" };
    let column = of.columns.first().copied().unwrap_or_default();
    Finding::new(
        Severity::Warning,
        "late-channel",
        format!(
            "by likelihood, {what} recorded {:.5} s {when} (standard error {:.5} s): {}",
            value.abs(),
            of.found.standard_error,
            falls(of)
        ),
        &format!("set delay_s = {{ \"{column}\" = \"estimate\" }} in [log]"),
    )
    .seen(of.file, column, value, "s")
}
