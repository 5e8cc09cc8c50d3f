//! Delays are relative: if all channels of a joint are late by the same time, its equations hardly change. The earliest channel of a
//! joint is the reference, so no channel is early; channels of one signal that are equally late are one cause.
//!
//! Gains of torques are relative too: all of them together are a factor of all parameters.

use super::found::{Competing, Found};
use super::unknown::{Kind, Place};
use crate::description::Delay;
use crate::log::{Channels, Signal};
use crate::model::Model;

/// Id of the common delay of all torques by controller and recorder.
pub(super) const TIMING: &str = "timing of the torques";

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
    let errors = delays.iter().map(|one| one.standard_error);
    let error = errors.fold(0.0, f64::max);
    let longest = TIMING_SAMPLES * period;
    let is_of_torque = |one: &Found| match one.place {
        Place::All(signal) => signal == Signal::Torque,
        Place::Channel(channel) => is_torque(channel, channels),
        Place::Joint(_) | Place::Robot => false,
    };
    // If two channels of a joint are early, the third is late.
    let has_early_fellow = |one: &Found| {
        let joint = |one: &Found| match one.place {
            Place::Channel(at) => Some(channels.all[at].joint),
            Place::Joint(_) | Place::All(_) | Place::Robot => None,
        };
        let is_fellow = |other: &&Found| other.id != one.id && joint(other) == joint(one);
        let mut fellows = delays.iter().filter(is_fellow);
        joint(one).is_some() && one.value < 0.0 && fellows.any(|other| other.value < 0.0)
    };
    // A short delay of a torque is that of the controller, which holds all of them; unless this delay was found beside it.
    let is_of_all = |one: &Found| matches!(one.place, Place::All(_));
    let has_timing = delays.iter().any(|one| is_of_torque(one) && is_of_all(one));
    let is_short = |one: &Found| {
        let is_common = is_of_all(one) || !has_timing;
        is_of_torque(one) && is_common && one.value.abs() <= longest
    };
    let (short, delays): (Vec<Found>, Vec<Found>) =
        (delays.iter().cloned()).partition(|one| is_short(one) && !has_early_fellow(one));
    let mut late = against_earliest(&delays, channels);
    let mut timing = weighted_mean(&short);
    // If all positions are late together by as little as controller and recorder cause, the torques act later.
    if let Some(later) =
        positions_later(&late, channels, error).filter(|later| (timing - later).abs() <= longest)
    {
        timing -= later;
        for late in &mut late {
            late.delay = 0.0;
        }
    }
    let largest = late.iter().map(|late| late.delay).fold(0.0, f64::max);
    let same = (SAME_SHARE * largest).max(2.0 * error);
    for (signal, name) in [
        (Signal::Link, "link positions"),
        (Signal::Motor, "motor positions"),
        (Signal::Torque, "torques"),
    ] {
        let of_signal = of_signal(&late, channels, signal);
        let mean = mean(&of_signal);
        let are_equal = of_signal
            .iter()
            .all(|late| (late.delay - mean).abs() <= same);
        let is_timing = signal == Signal::Torque && (mean + timing).abs() <= longest;
        if are_equal && is_timing {
            timing += mean;
        } else if are_equal && of_signal.len() > 1 && mean > same {
            all.push(Found {
                id: format!("delay all {name}"),
                place: Place::All(signal),
                ..with_delay(&of_signal, mean, &pattern)
            });
        } else {
            all.extend(
                of_signal
                    .iter()
                    .filter(|late| {
                        late.delay > same || is_asked(late.channel, channels) && late.delay < 0.0
                    })
                    .map(|late| Found {
                        id: format!("delay {}", channels.all[late.channel].column),
                        place: Place::Channel(late.channel),
                        ..with_delay(&[*late], late.delay, &pattern)
                    }),
            );
        }
    }
    if timing.abs() > 2.0 * error {
        all.push(Found {
            id: TIMING.to_owned(),
            kind: Kind::Timing,
            place: Place::All(Signal::Torque),
            ..with_delay(
                &of_signal(&late, channels, Signal::Torque),
                timing,
                short.first().unwrap_or(&pattern),
            )
        });
    }
    all
}

/// Adds the rivals of gains of torques: a common factor of all torques is a factor of all parameters, so gains of half of the
/// torques or more may as well be those of the others.
pub(super) fn with_rival_torques(
    mut found: Vec<Found>,
    channels: &Channels,
    model: &Model,
) -> Vec<Found> {
    let is_scale_given = (model.parameters().iter().enumerate()).any(|(i, parameter)| {
        let is_size = parameter.joint.is_none_or(|(kind, _)| kind.is_vital());
        is_size && model.known(i).is_some_and(|value| value != 0.0)
    });
    let of_torque = |one: &Found| match one.place {
        Place::Channel(at) if one.kind == Kind::Gain && is_torque(at, channels) => Some(at),
        Place::Channel(_) | Place::Joint(_) | Place::All(_) | Place::Robot => None,
    };
    let gains: Vec<usize> = found.iter().filter_map(of_torque).collect();
    let torques: Vec<usize> = (0..channels.all.len())
        .filter(|&at| is_torque(at, channels))
        .collect();
    if is_scale_given || 2 * gains.len() < torques.len() {
        return found;
    }
    let others = torques.iter().filter(|at| !gains.contains(at));
    let rivals: Vec<Competing> = (others.map(|&at| &channels.all[at].column))
        .map(|column| Competing {
            id: format!("gain {column}"),
            correlation: 1.0,
        })
        .collect();
    for one in found.iter_mut().filter(|one| of_torque(one).is_some()) {
        one.competing.splice(0..0, rivals.iter().cloned());
    }
    found
}

/// Returns the mean of some sizes, each with the weight of its precision; zero without any.
fn weighted_mean(found: &[Found]) -> f64 {
    let precision = |one: &Found| one.standard_error.powi(-2);
    let sum: f64 = found.iter().map(|one| one.value * precision(one)).sum();
    let weights: f64 = found.iter().map(precision).sum();
    if weights > 0.0 { sum / weights } else { 0.0 }
}

/// Returns the delay of each channel against the earliest of its joint, or against the only one whose delay the description does not
/// ask for.
fn against_earliest<'f>(delays: &'f [Found], channels: &Channels) -> Vec<Late<'f>> {
    let is_compared = |i: &usize| is_position_or_torque(channels.all[*i].quantity.signal());
    let mut all = Vec::new();
    for joint in 0..channels.instruments.joint_count() {
        let of_joint: Vec<Late<'_>> = (0..channels.all.len())
            .filter(|i| channels.all[*i].joint == joint && is_compared(i))
            .map(|channel| total(channel, delays, channels))
            .collect();
        let all_delays = of_joint.iter().map(|late| late.delay);
        let earliest = all_delays.fold(f64::INFINITY, f64::min);
        let reference = match &(of_joint.iter())
            .filter(|late| !is_asked(late.channel, channels))
            .collect::<Vec<_>>()[..]
        {
            [only] if of_joint.len() > 1 => only.delay,
            _ => earliest,
        };
        all.extend(of_joint.iter().map(|late| Late {
            delay: late.delay - reference,
            ..*late
        }));
    }
    all
}

/// Returns the delay that all positions have together while no torque is late; `None` if they have none.
fn positions_later(late: &[Late<'_>], channels: &Channels, error: f64) -> Option<f64> {
    let (torques, positions): (Vec<Late<'_>>, Vec<Late<'_>>) =
        (late.iter().copied()).partition(|late| is_torque(late.channel, channels));
    let mean = mean(&positions);
    let same = (SAME_SHARE * mean).max(2.0 * error);
    let together = positions
        .iter()
        .all(|late| (late.delay - mean).abs() <= same);
    let are_torques_early = torques.iter().all(|late| late.delay <= 2.0 * error);
    (together && are_torques_early).then_some(mean)
}

fn of_signal<'f>(late: &[Late<'f>], channels: &Channels, signal: Signal) -> Vec<Late<'f>> {
    let is_of = |late: &&Late<'f>| channels.all[late.channel].quantity.signal() == signal;
    late.iter().filter(is_of).copied().collect()
}

fn mean(late: &[Late<'_>]) -> f64 {
    late.iter().map(|late| late.delay).sum::<f64>() / late.len().max(1) as f64
}

/// Returns an unknown with another delay than the one that was found.
///
/// - `pattern`: gives its other figures if no unknown causes the delay.
fn with_delay(late: &[Late<'_>], delay: f64, pattern: &Found) -> Found {
    let mut causes = late.iter().filter_map(|late| late.cause);
    let cause = causes.next().unwrap_or(pattern);
    Found {
        value: delay,
        standard_error: causes
            .map(|cause| cause.standard_error)
            .fold(cause.standard_error, f64::max),
        // Rivals belong to the delay as it was found.
        competing: if (cause.value - delay).abs() < f64::EPSILON {
            cause.competing.clone()
        } else {
            Vec::new()
        },
        ..cause.clone()
    }
}

fn is_asked(channel: usize, channels: &Channels) -> bool {
    channels.all[channel].delay == Some(Delay::Estimate)
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
        Place::Joint(_) | Place::Robot => false,
    };
    let all: Vec<&Found> = delays.iter().filter(is_of).collect();
    Late {
        channel,
        delay: all.iter().map(|found| found.value).sum(),
        cause: all.first().copied(),
    }
}
