//! Mends wrong samples: a single sample far from its neighbours is interpolated, and samples in which a channel stands
//! still although its joint moves are left out.

use crate::block::{BLOCK, LogBlock};
use crate::columns::channels::Channels;
use crate::description::{Quantity, WrongSamples};

/// Samples that are held back: a stall is corrected only if its end is among them.
const HELD: usize = 1024;

/// Samples before and after a sample that decide whether it is wrong.
const NEIGHBOURS: usize = 8;

/// A spike is farther from the mean of its neighbours than this multiple of the 99th percentile, and than this multiple
/// of the same distance of all samples near it.
const SPIKE_RATIO: f64 = 6.0;
const SPIKE_RATIO_NEAR: f64 = 4.0;

/// The neighbours of a spike differ by less than this fraction of it.
const NEIGHBOURS_AGREE: f64 = 0.5;

/// Quantiles that bound the usual values of a torque. A spike of a torque exceeds their distance, because a controller
/// causes smaller ones.
const USUAL: [f64; 2] = [0.01, 0.99];

/// Minimum numbers of equal samples of a stall of a position and of a torque.
const MIN_STALL: usize = 5;
const MIN_STALL_OF_TORQUE: usize = 6;

/// The step after a stall of a position lies between these multiples of the 99th percentile of the steps, the second
/// one for each sample of the stall: the joint moved meanwhile.
const STALL_STEP: [f64; 2] = [2.5, 2.0];

/// A torque stalls only if more than this fraction of its other samples changes.
const CHANGING: f64 = 0.9;

/// If a column stalls more often than this in one block, the recorder is too slow, and the samples are kept.
const MAX_STALLS: usize = 8;

/// Mended samples of one channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mended {
    /// Number of single samples that were interpolated.
    pub spikes: u64,
    /// Time of the largest, s, and its distance from the interpolated value.
    pub largest: (f64, f64),
    /// Number of stalls whose samples were left out.
    pub stalls: u64,
    /// Number of these samples.
    pub stalled: u64,
    /// Time at which the longest stall begins, s, and its number of samples.
    pub longest: (f64, u64),
}

/// Kind of corrected samples.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Position,
    Torque,
}

/// Corrects the samples of a log that is read block by block.
pub(crate) struct Mender {
    // Kind of each channel; `None` if its samples are kept.
    kinds: Vec<Option<Kind>>,
    // 99th percentiles of distances from the mean of the neighbours, and of steps: the largest of all blocks.
    usual: Vec<[f64; 2]>,
    held: LogBlock,
    // Whether each held sample stalls; the number of held samples that are decided.
    stalled: Vec<bool>,
    decided: usize,
    // Time of the last sample that was handed on, s, and whether samples after it were left out.
    last: Option<f64>,
    left_out: bool,
    mended: Vec<Mended>,
    gaps: u64,
    duration: f64,
}

impl Mender {
    pub(crate) fn new(channels: &Channels) -> Self {
        let mends = channels.wrong_samples == WrongSamples::Mend;
        let kinds = channels
            .all
            .iter()
            .map(|channel| kind(channel.quantity).filter(|_| mends));
        Self::of(kinds.collect())
    }

    fn of(kinds: Vec<Option<Kind>>) -> Self {
        let count = kinds.len();
        Self {
            kinds,
            usual: vec![[0.0; 2]; count],
            held: LogBlock::new(count),
            stalled: Vec::new(),
            decided: 0,
            last: None,
            left_out: false,
            mended: vec![Mended::default(); count],
            gaps: 0,
            duration: 0.0,
        }
    }

    /// Returns whether it changes no sample.
    pub(crate) fn is_idle(&self) -> bool {
        self.kinds.iter().all(Option::is_none)
    }

    /// Returns the corrected samples of each channel, \[channels\].
    pub(crate) fn mended(&self) -> &[Mended] {
        &self.mended
    }

    /// Returns the number of gaps that it made, and their duration, s.
    pub(crate) fn gaps(&self) -> (u64, f64) {
        (self.gaps, self.duration)
    }

    /// Returns whether it holds no sample back.
    pub(crate) fn is_empty(&self) -> bool {
        self.held.is_empty()
    }

    /// Takes the next block, or the end of the log if it is empty, and adds samples that are decided to `out`, which
    /// gets [`BLOCK`] samples at most.
    ///
    /// - `period`: sampling period, s.
    pub(crate) fn push(&mut self, block: &LogBlock, period: f64, out: &mut LogBlock) {
        let begin = self.held.len();
        self.held.extend(block, 0..block.len());
        self.held
            .gaps
            .extend(block.gaps.iter().map(|gap| begin + gap));
        self.stalled.resize(self.held.len(), false);
        let until = match block.len() {
            0 => self.held.len(),
            _ => self.held.len().saturating_sub(HELD),
        };
        for channel in 0..self.kinds.len() {
            if let Some(kind) = self.kinds[channel] {
                self.learn(channel, begin);
                self.spikes(channel, kind, until);
                self.stalls(channel, kind, until);
            }
        }
        let handed = match block.len() {
            0 => until,
            _ => until.saturating_sub(NEIGHBOURS),
        };
        let handed = handed.min(BLOCK - out.len());
        self.hand_on(handed, period, out);
        self.decided = until - handed;
    }

    /// Updates the usual sizes of a channel from the samples from `begin` on.
    fn learn(&mut self, channel: usize, begin: usize) {
        let values = &self.held.values[channel][begin.saturating_sub(2)..];
        let mut bends: Vec<f64> = (values.windows(3))
            .map(|x| (x[1] - 0.5 * (x[0] + x[2])).abs())
            .collect();
        let mut steps: Vec<f64> = values.windows(2).map(|x| (x[1] - x[0]).abs()).collect();
        let usual = &mut self.usual[channel];
        usual[0] = usual[0].max(quantile_of_nonzero(&mut bends, 0.99));
        usual[1] = usual[1].max(quantile_of_nonzero(&mut steps, 0.99));
    }

    /// Returns the samples of the segment of sample `at`, at most [`NEIGHBOURS`] on each side.
    fn near(&self, at: usize) -> (usize, usize) {
        let gaps = &self.held.gaps;
        let next = gaps.partition_point(|&gap| gap <= at);
        let begin = next.checked_sub(1).map_or(0, |gap| gaps[gap]);
        let end = gaps.get(next).copied().unwrap_or(self.held.len());
        (
            begin.max(at.saturating_sub(NEIGHBOURS)),
            end.min(at + NEIGHBOURS + 1),
        )
    }

    fn spikes(&mut self, channel: usize, kind: Kind, until: usize) {
        let values = &self.held.values[channel];
        let limit = SPIKE_RATIO * self.usual[channel][0];
        let bend = |i: usize| (values[i] - 0.5 * (values[i - 1] + values[i + 1])).abs();
        let found: Vec<usize> = (self.decided.max(2)..until.min(values.len().saturating_sub(2)))
            .filter(|&i| limit > 0.0 && bend(i) > limit)
            .filter(|&i| (values[i + 1] - values[i - 1]).abs() < NEIGHBOURS_AGREE * bend(i))
            .filter(|&i| {
                let (begin, end) = self.near(i);
                let beside = (begin + 1..end - 1).filter(|j| j.abs_diff(i) > 1);
                let most = beside.map(bend).fold(0.0, f64::max);
                begin + 2 <= i && i + 2 < end && bend(i) > SPIKE_RATIO_NEAR * most
            })
            .collect();
        if found.is_empty() {
            return;
        }
        let usual = USUAL.map(|part| quantile(&mut values.clone(), part));
        let values = &mut self.held.values[channel];
        let mended = &mut self.mended[channel];
        for i in found {
            let x = |k: usize| values[k];
            let near = (4.0 * (x(i - 1) + x(i + 1)) - x(i - 2) - x(i + 2)) / 6.0;
            let size = values[i] - near;
            if kind == Kind::Torque && size.abs() <= usual[1] - usual[0] {
                continue;
            }
            values[i] = near;
            mended.spikes += 1;
            if size.abs() > mended.largest.1.abs() {
                mended.largest = (self.held.time[i], size);
            }
        }
    }

    fn stalls(&mut self, channel: usize, kind: Kind, until: usize) {
        let values = &self.held.values[channel];
        let step = self.usual[channel][1];
        let runs = runs(values, &self.held.gaps);
        let changes = runs.len();
        let mut found: Vec<(usize, usize)> = Vec::new();
        for &(begin, end) in &runs {
            // The first sample of a stall was right. A channel that stands still from the beginning of a segment is at
            // rest.
            let length = end - begin;
            let inside = begin >= self.decided.max(1) && begin < until && end < values.len();
            if !inside || self.held.gaps.contains(&begin) || self.held.gaps.contains(&end) {
                continue;
            }
            let jump = (values[end] - values[begin]).abs();
            let stalls = match kind {
                Kind::Position => {
                    let [least, most] = [STALL_STEP[0], STALL_STEP[1] * length as f64];
                    length >= MIN_STALL && jump > least * step && jump < most * step
                }
                Kind::Torque => {
                    length >= MIN_STALL_OF_TORQUE
                        && values[begin] != 0.0
                        && changes as f64 > CHANGING * (values.len() - length) as f64
                        && !is_extreme(values, values[begin])
                        && jump > median_step(values)
                }
            };
            if stalls {
                found.push((begin, end));
            }
        }
        if found.len() > MAX_STALLS {
            return;
        }
        let mended = &mut self.mended[channel];
        for (begin, end) in found {
            self.stalled[begin + 1..end].fill(true);
            let length = (end - begin) as u64;
            mended.stalls += 1;
            mended.stalled += length - 1;
            if length > mended.longest.1 {
                mended.longest = (self.held.time[begin], length);
            }
        }
    }

    /// Moves the first `count` held samples without stalled ones to `out`.
    fn hand_on(&mut self, count: usize, period: f64, out: &mut LogBlock) {
        let later = self.held.gaps.partition_point(|&gap| gap < count);
        let handed_gaps: Vec<usize> = self.held.gaps.drain(..later).collect();
        self.held.gaps.iter_mut().for_each(|gap| *gap -= count);
        let mut begin = 0;
        while begin < count {
            let stalls = self.stalled[begin];
            let run = self.stalled[begin..count]
                .iter()
                .take_while(|stall| **stall == stalls);
            let end = begin + run.count();
            if !stalls {
                let (time, left_out) = (self.held.time[begin], self.left_out);
                if let Some(last) = self.last.filter(|_| left_out) {
                    self.gaps += 1;
                    self.duration += time - last - period;
                    out.gaps.push(out.len());
                }
                let inside = handed_gaps.iter().filter(|gap| (begin..end).contains(gap));
                let place = out.len();
                out.gaps.extend(
                    inside
                        .filter(|gap| !(left_out && **gap == begin))
                        .map(|gap| place + gap - begin),
                );
                out.extend(&self.held, begin..end);
                self.last = Some(self.held.time[end - 1]);
            }
            self.left_out = stalls;
            begin = end;
        }
        self.held.time.drain(..count);
        for values in &mut self.held.values {
            values.drain(..count);
        }
        self.stalled.drain(..count);
    }
}

fn kind(quantity: Quantity) -> Option<Kind> {
    match quantity {
        Quantity::LinkPosition | Quantity::LinkDeflection | Quantity::MotorPosition => {
            Some(Kind::Position)
        }
        Quantity::MotorTorque | Quantity::JointTorque => Some(Kind::Torque),
        Quantity::MotorTarget
        | Quantity::DriveOn
        | Quantity::Inertial(..)
        | Quantity::Covariate(_) => None,
    }
}

/// Returns begin and end of all runs of equal samples.
fn runs(values: &[f64], gaps: &[usize]) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut begin = 0;
    let mut gaps = gaps.iter().copied().peekable();
    for i in 1..=values.len() {
        let gap = gaps.next_if_eq(&i).is_some();
        if i == values.len() || gap || values[i].to_bits() != values[begin].to_bits() {
            found.push((begin, i));
            begin = i;
        }
    }
    found
}

fn is_extreme(values: &[f64], value: f64) -> bool {
    let range = |pick: fn(f64, f64) -> f64| values.iter().copied().reduce(pick);
    [range(f64::min), range(f64::max)].contains(&Some(value))
}

fn median_step(values: &[f64]) -> f64 {
    let mut steps: Vec<f64> = values.windows(2).map(|x| (x[1] - x[0]).abs()).collect();
    quantile_of_nonzero(&mut steps, 0.5)
}

fn quantile_of_nonzero(sizes: &mut Vec<f64>, part: f64) -> f64 {
    sizes.retain(|size| *size > 0.0);
    quantile(sizes, part)
}

/// Returns a quantile of values in any order; zero without values.
fn quantile(values: &mut [f64], part: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let at = (part * (values.len() - 1) as f64).floor() as usize;
    *values.select_nth_unstable_by(at, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: f64 = 1e-3;

    /// Returns a position and a torque after correction in blocks of `size` samples.
    fn mended(position: &[f64], torque: &[f64], gaps: &[usize], size: usize) -> (Mender, LogBlock) {
        let mut mender = Mender::of(vec![Some(Kind::Position), Some(Kind::Torque)]);
        let mut all = LogBlock::new(2);
        let count = position.len();
        let mut begin = 0;
        loop {
            let end = (begin + size).min(count);
            let mut block = LogBlock::new(2);
            block.time.extend((begin..end).map(|k| k as f64 * PERIOD));
            block.values[0].extend_from_slice(&position[begin..end]);
            block.values[1].extend_from_slice(&torque[begin..end]);
            let inside = gaps.iter().filter(|gap| (begin..end).contains(*gap));
            block.gaps.extend(inside.map(|gap| gap - begin));
            let mut out = LogBlock::new(2);
            mender.push(&block, PERIOD, &mut out);
            assert!(out.len() <= BLOCK);
            let place = all.len();
            all.gaps.extend(out.gaps.iter().map(|gap| place + gap));
            all.extend(&out, 0..out.len());
            if begin == end && mender.is_empty() {
                return (mender, all);
            }
            begin = end;
        }
    }

    fn motion(count: usize) -> (Vec<f64>, Vec<f64>) {
        let at = |k: usize| k as f64 * PERIOD;
        // The torque has noise of one hundredth of its size.
        let noise = |k: usize| 0.01 * ((k as f64 * 12.9898).sin() * 43758.545).fract();
        (
            (0..count).map(|k| (6.0 * at(k)).sin()).collect(),
            (0..count)
                .map(|k| 2.0 * (6.0 * at(k)).cos() + noise(k))
                .collect(),
        )
    }

    #[test]
    fn a_sound_log_is_handed_on_as_it_is() {
        let (position, torque) = motion(9000);
        let (mender, out) = mended(&position, &torque, &[700, 5000], 2048);
        assert_eq!(out.values, [position, torque]);
        assert_eq!(out.gaps, [700, 5000]);
        assert!(
            mender
                .mended()
                .iter()
                .all(|mended| *mended == Mended::default())
        );
        assert_eq!(mender.gaps().0, 0);
    }

    #[test]
    fn a_spike_is_interpolated() {
        let (sound, steady) = motion(9000);
        let (mut position, mut torque) = (sound.clone(), steady.clone());
        for at in [300, 2047, 2048 + 1024, 8990] {
            position[at] += 0.05;
        }
        torque[4000] -= 40.0;
        // A controller may cause such a torque.
        torque[6000] += 1.0;
        let (mender, out) = mended(&position, &torque, &[], 2048);
        let [of_position, of_torque] = mender.mended() else {
            panic!()
        };
        assert_eq!(
            (of_position.spikes, of_torque.spikes, of_position.stalls),
            (4, 1, 0)
        );
        assert!(
            (of_position.largest.1 - 0.05).abs() < 1e-4 && (of_torque.largest.1 + 40.0).abs() < 0.1
        );
        assert!((of_torque.largest.0 - 4.0).abs() < 1e-9);
        // A cubic through four samples of a sine of 6 rad/s deviates by (6 · 1 ms)⁴ / 6 at most.
        for (value, sound) in out.values[0].iter().zip(&sound) {
            assert!((value - sound).abs() < 6e-3_f64.powi(4));
        }
        assert!((out.values[1][4000] - steady[4000]).abs() < 0.05);
        assert_eq!(out.values[1][6000..6001], torque[6000..6001]);
    }

    #[test]
    fn a_stall_is_left_out_as_a_gap() {
        let (mut position, torque) = motion(9000);
        for (begin, count) in [(2000, 60), (6000, 400)] {
            let held = position[begin];
            position[begin..begin + count].fill(held);
        }
        let (mender, out) = mended(&position, &torque, &[], 2048);
        assert_eq!(out.len(), 9000 - 59 - 399);
        assert_eq!(out.gaps, [2001, 6001 - 59]);
        let mended = mender.mended()[0];
        assert_eq!(
            (mended.stalls, mended.stalled, mended.longest.1),
            (2, 458, 400)
        );
        let (gaps, duration) = mender.gaps();
        assert!(gaps == 2 && (duration - 0.458).abs() < 1e-9, "{duration}");
    }

    #[test]
    fn rest_saturation_and_slow_recorders_are_kept() {
        let (mut position, mut torque) = motion(9000);
        position[..3000].fill(0.0);
        for value in &mut position[3000..] {
            *value = (*value * 400.0).round() / 400.0;
        }
        for value in &mut torque {
            *value = value.clamp(-1.5, 1.5);
        }
        let (mender, out) = mended(&position, &torque, &[], 2048);
        assert_eq!(out.len(), 9000);
        assert!(mender.mended().iter().all(|mended| mended.stalls == 0));
        // A source that is five times slower than the recorder.
        let (fast, torque) = motion(9000);
        let slow: Vec<f64> = (0..9000).map(|k| fast[k / 5 * 5]).collect();
        let (_, out) = mended(&slow, &torque, &[], 2048);
        assert_eq!(out.values[0], slow);
    }
}
