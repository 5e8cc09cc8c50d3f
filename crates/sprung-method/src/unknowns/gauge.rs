//! Delays are relative: if all channels of a joint are late by the same time, its equations hardly change. The earliest channel of a
//! joint is the reference, so no channel is early; channels of one signal that are equally late are one cause.

use super::found::Found;
use super::unknown::{Kind, Place};
use crate::log::{Channels, Signal};

/// Delays that differ by less than this part of the largest one are the same.
const SAME_SHARE: f64 = 0.05;

/// Longest common delay of all torques that controller and recorder cause, in samples.
const TIMING_SAMPLES: f64 = 1.5;

/// Delay of a channel, s, with an unknown that causes a part of it.
#[derive(Clone, Copy)]
struct Late<'f> {
    channel: usize,
    delay: f64,
    cause: Option<&'f Found>,
}

/// Returns the same unknowns with delays against the earliest channel of each joint.
pub(super) fn relative(found: Vec<Found>, channels: &Channels, period: f64) -> Vec<Found> {
    let (delays, mut all): (Vec<Found>, Vec<Found>) =
        found.into_iter().partition(|one| one.kind == Kind::Delay);
    let Some(pattern) = delays.first().cloned() else {
        return all;
    };
    let error = delays
        .iter()
        .fold(0.0, |most: f64, one| most.max(one.standard_error));
    let is_of_torque = |one: &Found| match one.place {
        Place::All(signal) => signal == Signal::Torque,
        Place::Channel(channel) => is_torque(channel, channels),
        Place::Joint(_) => false,
    };
    // A short delay of a torque is that of the controller, which holds all of them.
    let (short, delays): (Vec<Found>, Vec<Found>) = delays
        .into_iter()
        .partition(|one| is_of_torque(one) && one.value.abs() <= TIMING_SAMPLES * period);
    let precision: f64 = short.iter().map(|one| one.standard_error.powi(-2)).sum();
    let timing = if short.is_empty() {
        0.0
    } else {
        short
            .iter()
            .map(|one| one.value * one.standard_error.powi(-2))
            .sum::<f64>()
            / precision
    };
    let mut late: Vec<Late<'_>> = Vec::new();
    for joint in 0..channels.instruments.joint_count() {
        let of_joint: Vec<Late<'_>> = (0..channels.all.len())
            .filter(|&i| {
                channels.all[i].joint == joint
                    && is_position_or_torque(channels.all[i].quantity.signal())
            })
            .map(|channel| total(channel, &delays, channels))
            .collect();
        let earliest = of_joint
            .iter()
            .map(|late| late.delay)
            .fold(f64::INFINITY, f64::min);
        late.extend(of_joint.iter().map(|one| Late {
            delay: one.delay - earliest,
            ..*one
        }));
    }
    // If all positions are late together by as little as controller and recorder cause, the torques act later.
    let positions: Vec<f64> = late
        .iter()
        .filter(|late| !is_torque(late.channel, channels))
        .map(|late| late.delay)
        .collect();
    let mean = positions.iter().sum::<f64>() / positions.len().max(1) as f64;
    let together = positions
        .iter()
        .all(|delay| (delay - mean).abs() <= (SAME_SHARE * mean).max(2.0 * error));
    let others = late
        .iter()
        .filter(|late| is_torque(late.channel, channels))
        .all(|late| late.delay <= 2.0 * error);
    let is_later = together && others && (timing - mean).abs() <= TIMING_SAMPLES * period;
    if is_later {
        late.iter_mut().for_each(|late| late.delay = 0.0);
    }
    let timing = if is_later { timing - mean } else { timing };
    let largest = late
        .iter()
        .fold(0.0, |most: f64, late| most.max(late.delay));
    let same = (SAME_SHARE * largest).max(2.0 * error);
    let found = |late: &[Late<'_>], delay: f64| {
        let cause = late.iter().find_map(|late| late.cause).unwrap_or(&pattern);
        Found {
            value: delay,
            standard_error: late
                .iter()
                .filter_map(|late| Some(late.cause?.standard_error))
                .fold(cause.standard_error, f64::max),
            // Rivals belong to the delay as it was found.
            competing: if (cause.value - delay).abs() < f64::EPSILON {
                cause.competing.clone()
            } else {
                Vec::new()
            },
            ..cause.clone()
        }
    };
    let mut of_torques = timing;
    for (signal, name) in [
        (Signal::Link, "link positions"),
        (Signal::Motor, "motor positions"),
        (Signal::Torque, "torques"),
    ] {
        let of_signal: Vec<Late<'_>> = late
            .iter()
            .copied()
            .filter(|late| channels.all[late.channel].quantity.signal() == signal)
            .collect();
        let mean =
            of_signal.iter().map(|late| late.delay).sum::<f64>() / of_signal.len().max(1) as f64;
        let are_equal = of_signal.len() > 1
            && of_signal
                .iter()
                .all(|late| (late.delay - mean).abs() <= same);
        if signal == Signal::Torque
            && (are_equal || of_signal.len() == 1)
            && (mean + of_torques).abs() <= TIMING_SAMPLES * period
        {
            of_torques += mean;
            continue;
        }
        if are_equal && mean > same {
            all.push(Found {
                id: format!("delay all {name}"),
                place: Place::All(signal),
                ..found(&of_signal, mean)
            });
            continue;
        }
        for late in of_signal.iter().filter(|late| late.delay > same) {
            let column = &channels.all[late.channel].column;
            all.push(Found {
                id: format!("delay {column}"),
                place: Place::Channel(late.channel),
                ..found(&[*late], late.delay)
            });
        }
    }
    if of_torques.abs() > 2.0 * error {
        let torques: Vec<Late<'_>> = late
            .iter()
            .copied()
            .filter(|late| is_torque(late.channel, channels))
            .collect();
        let place = Place::All(Signal::Torque);
        all.push(Found {
            id: "timing of the torques".to_owned(),
            kind: Kind::Timing,
            place,
            ..found(&torques, of_torques)
        });
    }
    all
}

fn is_torque(channel: usize, channels: &Channels) -> bool {
    channels.all[channel].quantity.signal() == Signal::Torque
}

fn is_position_or_torque(signal: Signal) -> bool {
    matches!(signal, Signal::Link | Signal::Motor | Signal::Torque)
}

/// Returns the delay of a channel by all unknowns.
fn total<'f>(channel: usize, delays: &'f [Found], channels: &Channels) -> Late<'f> {
    let is_of = |found: &&Found| match found.place {
        Place::Channel(at) => at == channel,
        Place::All(signal) => channels.all[channel].quantity.signal() == signal,
        Place::Joint(_) => false,
    };
    let all: Vec<&Found> = delays.iter().filter(is_of).collect();
    Late {
        channel,
        delay: all.iter().map(|found| found.value).sum(),
        cause: all.first().copied(),
    }
}
