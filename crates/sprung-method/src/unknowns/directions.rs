//! The columns of channels: derivatives of their corrections, through the filters.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::rows::{Direction, Wanted};
use super::search::Search;
use super::unknown::{Effect, Unknown};
use crate::description::LinkPosition;
use crate::log::{Channel, LogBlock, Measures, Signal};
use crate::prepare::{Excerpt, Smoothed};
use crate::preprocess::SignalBlock;

/// Step of a size for its column, in usual sizes.
const STEP: f64 = 0.05;

impl Search<'_> {
    /// Returns whether each position is the one of its encoder, so that those of links do not move with those of motors.
    fn has_separate_positions(&self) -> bool {
        let is_difference = |channel: &Channel| matches!(channel.quantity.measures(), Measures::Position { link, motor } if link * motor != 0.0);
        let are_flexible = (0..self.model.joint_count()).all(|joint| self.model.is_flexible(joint));
        let mut instruments = self.channels.instruments.iter();
        are_flexible
            && self.channels.position_mix.is_none()
            && !self.channels.all.iter().any(is_difference)
            && instruments.all(|instrument| instrument.link_position() == LinkPosition::Column)
    }

    /// Returns the signals of a log whose channels are all zero.
    pub(super) fn zero(&self) -> Option<&Smoothed> {
        let zero = || {
            let blocks = (self.excerpt.blocks().iter())
                .map(|block| block.with_values(zeros(block)))
                .collect();
            self.signals(&self.excerpt.replaced(blocks))
        };
        self.zero.get_or_init(zero).as_ref()
    }

    /// Returns the directions of the wanted unknowns of channels. Those of one kind are formed together, joint by joint, and if link
    /// positions follow from those of motors, signal by signal.
    pub(super) fn directions(
        &self,
        corrected: &Excerpt,
        zero: &Smoothed,
        wanted: Wanted<'_>,
    ) -> Option<Vec<Direction>> {
        let mut passes: BTreeMap<(String, bool), Vec<usize>> = BTreeMap::new();
        let is_coupled = self.channels.position_mix.is_some() || self.channels.torque_mix.is_some();
        let are_separate = self.has_separate_positions();
        let groups: Vec<&Unknown> = (self.unknowns.iter().enumerate())
            .filter(|(k, unknown)| wanted.contains(*k) && unknown.channels().len() > 1)
            .map(|(_, unknown)| unknown)
            .collect();
        let is_member = |unknown: &Unknown, channel: usize| {
            (groups.iter())
                .any(|group| group.kind == unknown.kind && group.channels().contains(&channel))
        };
        for (k, unknown) in self.unknowns.iter().enumerate() {
            let [channel] = unknown.channels() else {
                continue;
            };
            if !wanted.contains(k) && !is_member(unknown, *channel) {
                continue;
            }
            let of = &self.channels.all[*channel];
            let signal = of.quantity.signal() == Signal::Motor && !are_separate;
            let key = unknown.id.replace(&of.column, "");
            let alone = if is_coupled {
                format!("{key} {k}")
            } else {
                key
            };
            passes.entry((alone, signal)).or_default().push(k);
        }
        let passes: Vec<Vec<usize>> = passes.into_values().collect();
        let found: Option<Vec<Vec<Direction>>> = passes
            .par_iter()
            .map(|pass| self.pass(pass, (corrected, zero), is_coupled))
            .collect();
        let mut directions: Vec<Direction> = found?.into_iter().flatten().collect();
        directions.sort_by_key(|direction| direction.unknown);
        for (k, unknown) in self.unknowns.iter().enumerate() {
            if unknown.channels().len() < 2 || !wanted.contains(k) {
                continue;
            }
            let single = |direction: &&Direction| {
                let other = &self.unknowns[direction.unknown];
                other.kind == unknown.kind
                    && matches!(other.channels(), [channel] if unknown.channels().contains(channel))
            };
            let members: Vec<&Direction> = directions.iter().filter(single).collect();
            let Some(sum) = sum_of(k, &members) else {
                continue;
            };
            directions.push(sum);
        }
        directions.retain(|direction| wanted.contains(direction.unknown));
        Some(directions)
    }

    /// Returns the directions of unknowns of different joints.
    pub(super) fn pass(
        &self,
        unknowns: &[usize],
        (corrected, zero): (&Excerpt, &Smoothed),
        is_coupled: bool,
    ) -> Option<Vec<Direction>> {
        let blocks = (corrected.blocks().iter())
            .map(|block| {
                let mut values = zeros(block);
                for &unknown in unknowns {
                    let Effect::Channels(channels, effect) = &self.unknowns[unknown].effect else {
                        continue;
                    };
                    let step = STEP * self.unknowns[unknown].scale;
                    for &channel in channels {
                        let samples = self.samples(block, channel);
                        let (more, less) = (
                            effect.perturb(&samples, step),
                            effect.perturb(&samples, -step),
                        );
                        for (value, (more, less)) in
                            values[channel].iter_mut().zip(more.iter().zip(&less))
                        {
                            *value = (more - less) / (2.0 * step);
                        }
                    }
                }
                block.with_values(values)
            })
            .collect();
        let smoothed = self.signals(&corrected.replaced(blocks))?;
        let n = self.model.joint_count();
        let are_separate = self.has_separate_positions();
        let directions = unknowns.iter().map(|&unknown| {
            let channel = self.unknowns[unknown].channels()[0];
            let of = &self.channels.all[channel];
            let joints: Vec<usize> = if is_coupled {
                (0..n).collect()
            } else {
                vec![of.joint]
            };
            let signal = Some(of.quantity.signal());
            let of = signal.filter(|signal| are_separate || *signal == Signal::Torque);
            let segments = (smoothed.segments().iter().zip(zero.segments()))
                .map(|(signals, zero)| difference(signals, zero, &joints, of))
                .collect();
            Direction {
                unknown,
                joints,
                segments,
                has_rate: self.unknowns[unknown].has_rate(),
                scales_torque: self.unknowns[unknown].scales_torque(),
            }
        });
        Some(directions.collect())
    }
}

/// Returns channels that are zero.
fn zeros(block: &LogBlock) -> Vec<Vec<f64>> {
    let channels = block.values.iter();
    channels.map(|values| vec![0.0; values.len()]).collect()
}

/// Returns the change of the signals of some joints; columns that do not change are empty.
///
/// - `of`: the signal that changes, or `None` for both positions.
fn difference(
    signals: &SignalBlock,
    zero: &SignalBlock,
    joints: &[usize],
    of: Option<Signal>,
) -> SignalBlock {
    let mut change = SignalBlock::new(signals.q.len());
    let minus =
        |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a - b).collect() };
    for &j in joints {
        if of == Some(Signal::Torque) {
            change.tau[j] = minus(&signals.tau[j], &zero.tau[j]);
            continue;
        }
        if of != Some(Signal::Motor) {
            change.q[j] = minus(&signals.q[j], &zero.q[j]);
            change.dq[j] = minus(&signals.dq[j], &zero.dq[j]);
        }
        if of != Some(Signal::Link) {
            change.phi[j] = minus(&signals.phi[j], &zero.phi[j]);
            change.dphi[j] = minus(&signals.dphi[j], &zero.dphi[j]);
        }
    }
    change
}

/// Returns the sum of the directions of several unknowns, of which each changes the signals of its joints.
fn sum_of(unknown: usize, members: &[&Direction]) -> Option<Direction> {
    let (first, others) = members.split_first()?;
    let mut joints: Vec<usize> = (members.iter())
        .flat_map(|member| member.joints.iter().copied())
        .collect();
    joints.sort_unstable();
    joints.dedup();
    let mut segments = first.segments.clone();
    for other in others {
        for (sum, more) in segments.iter_mut().zip(&other.segments) {
            sum.add(more);
        }
    }
    Some(Direction {
        unknown,
        joints,
        segments,
        has_rate: first.has_rate,
        scales_torque: false,
    })
}
