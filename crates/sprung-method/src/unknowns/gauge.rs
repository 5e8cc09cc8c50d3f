//! Delays are relative: if all channels of a joint are late by the same time, its equations hardly change. Of all delays that
//! explain the log, those of the fewest channels are named, and late ones before early ones.

use super::settle::Found;
use super::settled::is_position_or_torque;
use super::unknown::Place;
use crate::log::{Channels, Signal};

/// Delays that differ by less than this part of the largest one are the same.
const SAME_SHARE: f64 = 0.05;

/// Longest common delay of all torques that controller and recorder cause, in samples.
const TIMING_SAMPLES: f64 = 1.5;

/// Returns the same unknowns with the fewest late channels.
pub(super) fn sparsest(found: Vec<Found>, channels: &Channels, period: f64) -> Vec<Found> {
    let (delays, mut others): (Vec<Found>, Vec<Found>) = found.into_iter().partition(|one| one.kind == "delay");
    let (timing, delays): (Vec<Found>, Vec<Found>) = (delays.into_iter())
        .partition(|one| one.place == Place::All(Signal::Torque) && one.value.abs() <= TIMING_SAMPLES * period);
    others.extend(timing.into_iter().map(|one| Found { kind: "timing", id: "timing of the torques".to_owned(), ..one }));
    let joints = channels.instruments.joint_count();
    let is_sparse = |one: &Found| one.value > 0.0 && is_alone(one, &delays, channels);
    if delays.iter().all(is_sparse) {
        others.extend(delays);
        return others;
    }
    for joint in 0..joints {
        let of_joint: Vec<usize> = (0..channels.all.len())
            .filter(|&i| channels.all[i].joint == joint && is_position_or_torque(channels.all[i].quantity.signal()))
            .collect();
        let values: Vec<(f64, Option<&Found>)> = of_joint.iter().map(|&i| total(i, &delays, channels)).collect();
        let largest = values.iter().fold(0.0, |most: f64, (value, _)| most.max(value.abs()));
        let errors = values.iter().filter_map(|(_, found)| Some(found.as_ref()?.standard_error)).fold(0.0, f64::max);
        let same = (SAME_SHARE * largest).max(2.0 * errors);
        let count = |reference: f64| {
            let late = values.iter().filter(|(value, _)| (value - reference).abs() > same).count();
            let early = values.iter().filter(|(value, _)| value - reference < -same).count();
            (late, early)
        };
        let references = std::iter::once(0.0).chain(values.iter().map(|(value, _)| *value));
        let Some(reference) = references.min_by_key(|reference| count(*reference)) else { continue };
        let Some(pattern) = values.iter().find_map(|(_, found)| *found) else { continue };
        for (&channel, (value, of)) in of_joint.iter().zip(&values) {
            if (value - reference).abs() > same {
                let column = &channels.all[channel].column;
                others.push(Found {
                    id: format!("delay {column}"),
                    place: Place::Channel(channel),
                    value: value - reference,
                    standard_error: errors,
                    ..of.unwrap_or(pattern).clone()
                });
            }
        }
    }
    others
}

/// Returns whether no other delay concerns the joint of one.
fn is_alone(one: &Found, delays: &[Found], channels: &Channels) -> bool {
    let joint = |found: &Found| match found.place {
        Place::Channel(at) => Some(channels.all[at].joint),
        Place::All(_) | Place::Joint(_) => None,
    };
    let with = delays.iter().filter(|other| joint(one).is_none() || joint(other).is_none() || joint(one) == joint(other));
    with.count() == 1
}

/// Returns the delay of a channel by all unknowns, s, and one of them.
fn total<'f>(channel: usize, delays: &'f [Found], channels: &Channels) -> (f64, Option<&'f Found>) {
    let is_of = |found: &&Found| match found.place {
        Place::Channel(at) => at == channel,
        Place::All(signal) => channels.all[channel].quantity.signal() == signal,
        Place::Joint(_) => false,
    };
    let all: Vec<&Found> = delays.iter().filter(is_of).collect();
    (all.iter().map(|found| found.value).sum(), all.first().copied())
}
