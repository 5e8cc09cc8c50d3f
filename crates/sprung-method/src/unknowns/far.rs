//! Starts far from zero: long delays, and other meanings of columns.

use rayon::prelude::*;

use super::evidence::{Evidence, PARTS, row_rms};
use super::meanings::Meaning;
use super::rows::Row;
use super::search::Search;
use super::state::State;
use super::unknown::Kind;
use crate::log::Signal;
use crate::prepare::Excerpt;

/// Sizes, s, at which a delay that is asked for starts.
const FAR_S: [f64; 13] = [
    -0.04, -0.02, 0.01, 0.02, 0.035, 0.05, 0.075, 0.1, 0.13, 0.16, 0.2, 0.3, 0.45,
];

/// Part of the squared torque that an unexplained joint leaves at least.
const UNEXPLAINED: f64 = 0.02;

/// Another meaning of the columns leaves less than this part of the squares: a delay or a law is rarely cured by a sign.
const OTHER_MEANING: f64 = 0.25;

/// It must leave so many times less than what was found: sizes that do as well are likelier.
const MEANING_OVER_SIZES: f64 = 1.5;

/// No sizes are sought if another meaning leaves less than this part: wrong signs leave 0.15 %, other faults 25 % or more.
pub(super) const CERTAIN_MEANING: f64 = 0.02;

/// Number of unknowns, and part of the squares that they leave, above which other meanings are tried again.
const MANY: usize = 4;
const LITTLE: f64 = 0.2;

/// The same as [`UNEXPLAINED`] for them: columns of stiff joints differ little.
const HARDLY_UNEXPLAINED: f64 = 1e-3;

/// Gains that are tried, relative to the ratio of both positions of a joint. A soft spring lets one of them move twice as far as the
/// other.
const FAR_GAINS: [f64; 7] = [0.4, 0.55, 0.75, 1.0, 1.35, 1.8, 2.5];

impl Search<'_> {
    /// Starts delays that are asked for at the best of a few sizes: tangents find delays of a few hundredths of a second only.
    pub(super) fn start_delays(&mut self, state: &mut State) -> Option<()> {
        for signal in [Signal::Link, Signal::Motor, Signal::Torque] {
            let asked: Vec<(usize, usize)> = (self.asked.iter())
                .filter_map(|&unknown| Some((unknown, self.delayed_joint(unknown, signal)?)))
                .collect();
            if asked.is_empty() {
                continue;
            }
            let now = self.left_by_joint(&state.sizes)?;
            let mut least: Vec<f64> = asked.iter().map(|(_, joint)| now[*joint]).collect();
            let mut best = state.sizes.clone();
            for size in FAR_S {
                let mut sizes = state.sizes.clone();
                for (unknown, _) in &asked {
                    sizes[*unknown] = size;
                }
                let Some(left) = self.left_by_joint(&sizes) else {
                    continue;
                };
                for (least, &(unknown, joint)) in least.iter_mut().zip(&asked) {
                    if left[joint] < *least {
                        (*least, best[unknown]) = (left[joint], size);
                    }
                }
            }
            // Later signals are searched beside it.
            state.sizes = best;
            for (unknown, _) in asked {
                // A delay that is long by its start is usual.
                let scale = &mut self.unknowns[unknown].scale;
                *scale = scale.max(state.sizes[unknown].abs());
            }
        }
        Some(())
    }

    /// Starts gains that are asked for at the best of a few sizes.
    pub(super) fn start_gains(&self, state: &mut State) -> Option<()> {
        for &unknown in &self.asked {
            let of = &self.unknowns[unknown];
            let (Kind::Gain, &[channel]) = (of.kind, of.channels()) else {
                continue;
            };
            let joint = self.channels.all[channel].joint;
            let mut least = self.left_by_joint(&state.sizes)?[joint];
            let about = self.ratio_to_other_position(channel).unwrap_or(1.0);
            for gain in FAR_GAINS.map(|gain| about * gain) {
                let mut sizes = state.sizes.clone();
                sizes[unknown] = gain - 1.0;
                let Some(left) = self.left_by_joint(&sizes) else {
                    continue;
                };
                if left[joint] < least {
                    (least, state.sizes[unknown]) = (left[joint], gain - 1.0);
                }
            }
        }
        Some(())
    }

    /// Returns the standard deviation of the other position of a joint over that of a position.
    fn ratio_to_other_position(&self, channel: usize) -> Option<f64> {
        let of = &self.channels.all[channel];
        let other = match of.quantity.signal() {
            Signal::Link => Signal::Motor,
            Signal::Motor => Signal::Link,
            _ => return None,
        };
        let other = self.channels.telling(other, of.joint)?;
        let ratio = self.excerpt.deviation(other) / self.excerpt.deviation(channel);
        (ratio.is_finite() && ratio > 0.0).then_some(ratio)
    }

    /// Returns the joint of an unknown that is the delay of one channel of a signal.
    fn delayed_joint(&self, unknown: usize, signal: Signal) -> Option<usize> {
        let unknown = &self.unknowns[unknown];
        match (unknown.kind, unknown.channels()) {
            (Kind::Delay, [channel]) => {
                let of = &self.channels.all[*channel];
                (of.quantity.signal() == signal).then_some(of.joint)
            }
            _ => None,
        }
    }

    /// Returns what the best other meaning of the columns of unexplained joints leaves of the squares that the log leaves as it is;
    /// infinite if all are explained.
    pub(super) fn left_by_other_meaning(&self) -> Option<f64> {
        self.left_by_meanings(UNEXPLAINED)
    }

    /// Returns whether many sizes explain little, and another meaning of the columns nearly all. Then further sizes do not help.
    pub(super) fn is_hopeless(&self, state: &State) -> Option<bool> {
        if state.chosen.len() < MANY {
            return Some(false);
        }
        let before = self.left_of_sizes(&vec![0.0; self.unknowns.len()])?;
        if self.left_of_sizes(&self.applied_sizes(state))? < LITTLE * before {
            return Some(false);
        }
        let left = (self.any_meaning).get_or_init(|| self.left_by_meanings(HARDLY_UNEXPLAINED));
        Some((*left)? < CERTAIN_MEANING)
    }

    /// Returns what the best other meaning of the columns of some joints leaves; infinite without such joints.
    ///
    /// - `unexplained`: part of the squares that these joints leave at least.
    fn left_by_meanings(&self, unexplained: f64) -> Option<f64> {
        let left = self.left_by_joint(&vec![0.0; self.unknowns.len()])?;
        let joints: Vec<usize> = (0..left.len())
            .filter(|&joint| left[joint] > unexplained)
            .collect();
        let meanings = Meaning::all(self.channels, &joints);
        let all = meanings.into_par_iter().filter_map(|meaning| {
            let mut blocks = self.excerpt.blocks().to_vec();
            for block in &mut blocks {
                meaning.apply(block);
            }
            let left = self.left_of(&self.excerpt.replaced(blocks))?;
            Some(left.iter().sum::<f64>())
        });
        let before = left.iter().sum::<f64>();
        Some(all.reduce(|| f64::INFINITY, f64::min) / before)
    }

    /// Returns whether another meaning of the columns explains the log much better than what was found. Then sizes mean nothing.
    ///
    /// - `left`: by the other meaning, of the squares that the log leaves as it is.
    pub(super) fn has_other_meaning(&self, left: f64, state: &State) -> Option<bool> {
        if left >= OTHER_MEANING {
            return Some(false);
        }
        let before = self.left_of_sizes(&vec![0.0; self.unknowns.len()])?;
        let found = self.left_of_sizes(&self.applied_sizes(state))?;
        Some(MEANING_OVER_SIZES * left * before < found)
    }

    /// Returns the held-out squares of each joint's rows over those of their torques, with some sizes applied.
    pub(super) fn left_by_joint(&self, sizes: &[f64]) -> Option<Vec<f64>> {
        if self.leave_log(sizes) {
            Some(self.left_in(&self.logged()?.rows))
        } else {
            self.left_of(&self.corrected(sizes))
        }
    }

    /// Returns the sum of [`Self::left_by_joint`].
    fn left_of_sizes(&self, sizes: &[f64]) -> Option<f64> {
        Some(self.left_by_joint(sizes)?.iter().sum())
    }

    fn left_of(&self, corrected: &Excerpt) -> Option<Vec<f64>> {
        let rows = self.plain_rows(&self.signals(corrected)?, &self.known())?;
        Some(self.left_in(&rows))
    }

    fn left_in(&self, rows: &[Row]) -> Vec<f64> {
        let by_torque = Some(rows.iter().map(|row| row_rms(row).recip()).collect());
        let evidence = Evidence::new(rows, &self.signs, &[], by_torque, 1.0);
        let held_out = evidence.held_out(&(0..self.free.len()).collect::<Vec<usize>>(), None);
        let all: Vec<usize> = (0..PARTS).collect();
        let of_joint = |joint: usize| {
            let rows = evidence.rows_of(joint);
            let torque: f64 = rows.iter().map(|&row| evidence.torque_squares(row)).sum();
            held_out.sum(&rows, &all) / torque.max(f64::MIN_POSITIVE)
        };
        (0..self.model.joint_count()).map(of_joint).collect()
    }
}
