//! Starts far from zero: long delays, and other meanings of columns.

use rayon::prelude::*;

use super::court::Court;
use super::evidence::{Evidence, PARTS, row_rms};
use super::meanings::Meaning;
use super::state::State;
use super::unknown::{Kind, Unknown};
use crate::log::Signal;
use crate::prepare::Excerpt;

/// Sizes of a delay, s, at which a search far from zero starts; part of the squared torque that a joint leaves unexplained for such a
/// search; and part of this that the start must leave at most.
const FAR_S: [f64; 13] = [
    -0.04, -0.02, 0.01, 0.02, 0.035, 0.05, 0.075, 0.1, 0.13, 0.16, 0.2, 0.3, 0.45,
];
const UNEXPLAINED: f64 = 0.04;
const FAR_SHARE: f64 = 0.7;

/// Another meaning of the columns leaves less than this part of the squares: a delay or a law is rarely cured by a sign.
const OTHER_MEANING: f64 = 0.25;

/// It must leave so many times less than what was found: sizes that do as well are likelier.
const MEANING_OVER_SIZES: f64 = 1.5;

impl Court<'_> {
    /// Starts delays that are asked for, and those of joints whose equations explain little, at the best of a few sizes. Tangents
    /// find delays of a few hundredths of a second only.
    pub(super) fn start_far(&mut self, state: &mut State) -> Option<()> {
        let left = self.left_by_joint(&state.sizes)?;
        if self.asked.is_empty() && left.iter().all(|left| *left <= UNEXPLAINED) {
            return Some(());
        }
        let mut started: Vec<(usize, f64)> = Vec::new();
        for signal in [Signal::Link, Signal::Motor, Signal::Torque] {
            let is_of = |unknown: &Unknown| match (unknown.kind, unknown.channels()) {
                (Kind::Delay, [channel]) => self.channels.all[*channel].quantity.signal() == signal,
                _ => false,
            };
            let joint_of =
                |unknown: usize| self.channels.all[self.unknowns[unknown].channels()[0]].joint;
            let tried: Vec<usize> = (0..self.unknowns.len())
                .filter(|&k| is_of(&self.unknowns[k]))
                .filter(|&k| {
                    self.asked.contains(&k)
                        || self.asked.is_empty() && left[joint_of(k)] > UNEXPLAINED
                })
                .collect();
            if tried.is_empty() {
                continue;
            }
            let mut best: Vec<(f64, f64)> =
                tried.iter().map(|&k| (left[joint_of(k)], 0.0)).collect();
            for size in FAR_S {
                let mut sizes = state.sizes.clone();
                tried.iter().for_each(|&k| sizes[k] = size);
                let Some(now) = self.left_by_joint(&sizes) else {
                    continue;
                };
                for ((least, at), &k) in best.iter_mut().zip(&tried) {
                    if now[joint_of(k)] < *least {
                        (*least, *at) = (now[joint_of(k)], size);
                    }
                }
            }
            for ((least, at), &k) in best.iter().zip(&tried) {
                let joint = joint_of(k);
                let others: Vec<usize> = state
                    .chosen
                    .iter()
                    .copied()
                    .filter(|&other| joint_of(other) == joint && state.sizes[other] != 0.0)
                    .collect();
                let is_clear = self.asked.contains(&k) || *least < FAR_SHARE * left[joint];
                if *at == 0.0 || !is_clear || !others.is_empty() {
                    continue;
                }
                state.sizes[k] = *at;
                started.push((k, at.abs()));
                if !state.chosen.contains(&k) {
                    state.chosen.push(k);
                    state.gains[k] = 1.0 - least / left[joint];
                }
            }
        }
        // A delay that is long by its start is usual.
        for (unknown, size) in started {
            let scale = &mut self.unknowns[unknown].scale;
            *scale = scale.max(size);
        }
        Some(())
    }

    /// Returns whether another meaning of the columns explains the log much better than what was found. Then sizes mean nothing.
    pub(super) fn has_other_meaning(&self, state: &State) -> Option<bool> {
        let left = self.left_by_joint(&vec![0.0; self.unknowns.len()])?;
        let weak: Vec<usize> = (0..left.len())
            .filter(|&joint| left[joint] > UNEXPLAINED)
            .collect();
        if weak.is_empty() {
            return Some(false);
        }
        let sizes = self.applied_sizes(state);
        let found = self.left_by_joint(&sizes)?.iter().sum::<f64>();
        let before = left.iter().sum::<f64>();
        let meanings = Meaning::all(self.channels, &weak);
        let best = meanings.into_par_iter().filter_map(|meaning| {
            let mut blocks = self.excerpt.blocks().to_vec();
            blocks.iter_mut().for_each(|block| meaning.apply(block));
            Some(
                self.left_of(&self.excerpt.replaced(blocks))?
                    .iter()
                    .sum::<f64>(),
            )
        });
        let best = best.reduce(|| f64::INFINITY, f64::min);
        Some(best < OTHER_MEANING * before && MEANING_OVER_SIZES * best < found)
    }

    /// Returns the held-out squares of each joint's rows over those of their torques, with some sizes applied.
    pub(super) fn left_by_joint(&self, sizes: &[f64]) -> Option<Vec<f64>> {
        self.left_of(&self.corrected(sizes))
    }

    pub(super) fn left_of(&self, corrected: &Excerpt) -> Option<Vec<f64>> {
        let smoothed = self.signals(corrected)?;
        let theta: Vec<f64> = (0..self.model.parameters().len())
            .map(|i| self.model.known(i).unwrap_or_default())
            .collect();
        let rows = self.former(smoothed.period()).form(
            smoothed.segments(),
            &theta,
            &self.unknowns,
            &[],
        )?;
        let by_torque = Some(rows.iter().map(|row| row_rms(row).recip()).collect());
        let evidence = Evidence::new(
            &rows,
            (self.free.len(), &self.positive),
            &[],
            by_torque,
            1.0,
        );
        let held_out = evidence.held_out(&(0..self.free.len()).collect::<Vec<usize>>(), None);
        let all: Vec<usize> = (0..PARTS).collect();
        Some(
            (0..self.model.joint_count())
                .map(|joint| {
                    let rows = evidence.rows_of(joint);
                    let torque: f64 = rows.iter().map(|&row| evidence.torque_squares(row)).sum();
                    held_out.sum(&rows, &all) / torque.max(f64::MIN_POSITIVE)
                })
                .collect(),
        )
    }
}
