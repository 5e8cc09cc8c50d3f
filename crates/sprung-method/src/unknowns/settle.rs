//! Finds the unknowns of a log: regress, select, apply, until nothing is left.

use std::collections::BTreeMap;

use rayon::prelude::*;
use sprung_core::parameters::JointParameter;

use super::evidence::{Evidence, PARTS, Prior};
use super::kinds::{Catalogued, catalogue, lost_counts};
use super::meanings::Meaning;
use super::rows::{Direction, Row, RowOf, Rows, row_cutoff};
use super::select::{Chosen, Competing, SIGNIFICANT, Selection};
use super::unknown::{Effect, Place, Samples, Unknown};
use crate::description::Delay;
use crate::log::{Channels, LogBlock, Signal};
use crate::model::Model;
use crate::prepare::{Excerpt, Smoothed};
use crate::preprocess::{Butterworth, SignalBlock};
use crate::regression::Reading;

/// Largest cut-off of positions and torques, Hz. Delays, gains and zeros show in slow motion, and the noise is fast.
const CUTOFF_HZ: f64 = 15.0;

/// Rate of the filtered signals, Hz.
const RATE_HZ: f64 = 200.0;

/// Most rounds, and most unknowns that a round adds: columns move with the state.
const MAX_ROUNDS: usize = 10;
const ADDED_IN_A_ROUND: usize = 2;

/// Most unknowns.
const MAX_UNKNOWNS: usize = 8;

/// Step of a size for its column, in usual sizes.
const STEP: f64 = 0.05;

/// Sizes of a delay, s, at which a search far from zero starts; part of the squared torque that a joint leaves unexplained for such a
/// search; and part of this that the start must leave at most.
const FAR_S: [f64; 13] = [
    -0.04, -0.02, 0.01, 0.02, 0.035, 0.05, 0.075, 0.1, 0.13, 0.16, 0.2, 0.3, 0.45,
];
const UNEXPLAINED: f64 = 0.04;
const FAR_SHARE: f64 = 0.5;

/// Another meaning of the columns leaves less than this part of the squares: a delay or a law is rarely cured by a sign.
const OTHER_MEANING: f64 = 0.25;

/// A rival takes the place of an unknown if it leaves less than this part of the held-out squares.
const REPLACES: f64 = 0.97;

/// The same for a late channel in the place of an early one.
const LATE_FOR_EARLY: f64 = 1.05;

/// Rivals of an unknown that are applied in earnest.
const RIVALS: usize = 3;

/// An unknown that was found.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Found {
    /// Stable name, as in `delay q1_rad`.
    pub(crate) id: String,
    /// Kind, as in `delay`.
    pub(crate) kind: &'static str,
    pub(crate) place: Place,
    /// Size, and its standard error.
    pub(crate) value: f64,
    pub(crate) standard_error: f64,
    pub(crate) unit: &'static str,
    /// Time at which it begins, s.
    pub(crate) begins: Option<f64>,
    /// Relative fall of the held-out squares of the torques.
    pub(crate) gain: f64,
    /// Part of its column that no parameter mimics.
    pub(crate) own: f64,
    /// Parameter that mimics most of it.
    pub(crate) mimic: Option<String>,
    /// Others that may stand for it.
    pub(crate) competing: Vec<Competing>,
}

/// What is applied.
#[derive(Clone, Debug, Default)]
struct State {
    chosen: Vec<usize>,
    /// Size of each unknown; of laws the coefficient.
    sizes: Vec<f64>,
    errors: Vec<f64>,
    gains: Vec<f64>,
    theta: Vec<f64>,
}

/// A round with its evidence.
struct Round {
    evidence: Evidence,
    scales: Vec<f64>,
    begins: Vec<Option<usize>>,
    changed: bool,
}

/// A log whose unknowns are sought.
struct Court<'a> {
    reading: Reading,
    channels: &'a Channels,
    model: &'a Model,
    excerpt: &'a Excerpt,
    span: [f64; 2],
    unknowns: Vec<Unknown>,
    rows: Vec<RowOf>,
    free: Vec<usize>,
    places: BTreeMap<usize, usize>,
    positive: Vec<bool>,
    catalogued: Catalogued<'a>,
    /// Unknowns that the description asks for.
    asked: Vec<usize>,
}

/// Finds the unknowns of the beginning of a log.
///
/// Returns `None` if the log is too short for the filters, or its robot has link positions without an encoder.
pub(crate) fn settle(reading: &Reading, excerpt: &Excerpt) -> Option<Vec<Found>> {
    let cutoff = reading.position_cutoff_hz().min(CUTOFF_HZ);
    let reading = reading.without_weights().with_position_cutoff(cutoff);
    let (model, channels) = (reading.model().clone(), reading.channels().clone());
    if channels.inertial.is_some() || !model.joints_without_link().is_empty() {
        return None;
    }
    let segmented = excerpt.in_segments();
    let court = Court::new(&reading, &channels, &model, &segmented);
    court.settle()
}

impl<'a> Court<'a> {
    fn new(
        reading: &Reading,
        channels: &'a Channels,
        model: &'a Model,
        excerpt: &'a Excerpt,
    ) -> Self {
        let free: Vec<usize> = (0..model.parameters().len())
            .filter(|&i| model.known(i).is_none())
            .collect();
        let positive = (free.iter())
            .map(|&i| {
                model.parameters()[i]
                    .joint
                    .is_some_and(|(kind, _)| kind.is_vital() || kind.is_friction())
            })
            .collect();
        let catalogued = Catalogued::new(channels, model, excerpt);
        let unknowns = catalogue(&catalogued);
        let is_asked = |unknown: &Unknown| {
            unknown.kind == "delay"
                && matches!(unknown.channels(), [channel] if channels.all[*channel].delay == Some(Delay::Estimate))
        };
        Self {
            span: catalogued.span,
            asked: (0..unknowns.len())
                .filter(|&k| is_asked(&unknowns[k]))
                .collect(),
            unknowns,
            rows: RowOf::all(model),
            places: free
                .iter()
                .enumerate()
                .map(|(place, &column)| (column, place))
                .collect(),
            free,
            positive,
            reading: reading.clone(),
            channels,
            model,
            catalogued,
            excerpt,
        }
    }

    fn settle(mut self) -> Option<Vec<Found>> {
        let mut state = State {
            sizes: vec![0.0; self.unknowns.len()],
            errors: vec![0.0; self.unknowns.len()],
            gains: vec![0.0; self.unknowns.len()],
            ..State::default()
        };
        state.chosen = self.asked.clone();
        self.start_far(&mut state)?;
        if self.has_other_meaning(&state)? {
            return None;
        }
        let mut round = None;
        for _ in 0..MAX_ROUNDS {
            let now = self.round(&mut state, true)?;
            let is_over = !now.changed;
            round = Some(now);
            if is_over {
                break;
            }
        }
        let mut round = round?;
        if !state.chosen.is_empty() {
            (state, round) = self.exchanged(state, round)?;
        }
        let mut found = self.described(&state, &round);
        found.extend(self.preloads(&state, &round));
        Some(found)
    }

    /// Starts delays that are asked for, and those of joints whose equations explain little, at the best of a few sizes. Tangents
    /// find delays of a few hundredths of a second only.
    fn start_far(&mut self, state: &mut State) -> Option<()> {
        let left = self.left_by_joint(&state.sizes)?;
        if self.asked.is_empty() && left.iter().all(|left| *left <= UNEXPLAINED) {
            return Some(());
        }
        for signal in [Signal::Link, Signal::Motor, Signal::Torque] {
            let is_of = |unknown: &Unknown| match (unknown.kind, unknown.channels()) {
                ("delay", [channel]) => self.channels.all[*channel].quantity.signal() == signal,
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
                if *at == 0.0 || *least > FAR_SHARE * left[joint] || !others.is_empty() {
                    continue;
                }
                state.sizes[k] = *at;
                if !state.chosen.contains(&k) {
                    state.chosen.push(k);
                    state.gains[k] = 1.0 - least / left[joint];
                }
            }
        }
        Some(())
    }

    /// Returns whether another meaning of the columns explains the log much better than its delays. Then sizes mean nothing.
    fn has_other_meaning(&self, state: &State) -> Option<bool> {
        let left = self.left_by_joint(&vec![0.0; self.unknowns.len()])?;
        let late = self.left_by_joint(&state.sizes)?;
        let weak: Vec<usize> = (0..left.len())
            .filter(|&joint| left[joint] > UNEXPLAINED)
            .collect();
        let (before, with_delays) = (left.iter().sum::<f64>(), late.iter().sum::<f64>());
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
        Some(best < OTHER_MEANING * before && best < with_delays)
    }

    /// Returns the held-out squares of each joint's rows over those of their torques, with some sizes applied.
    fn left_by_joint(&self, sizes: &[f64]) -> Option<Vec<f64>> {
        self.left_of(&self.corrected(sizes))
    }

    fn left_of(&self, corrected: &Excerpt) -> Option<Vec<f64>> {
        let smoothed = self.signals(&corrected)?;
        let theta: Vec<f64> = (0..self.model.parameters().len())
            .map(|i| self.model.known(i).unwrap_or_default())
            .collect();
        let rows = self.former(smoothed.period()).form(
            smoothed.segments(),
            &theta,
            &self.unknowns,
            &[],
        )?;
        let evidence = Evidence::new(&rows, (self.free.len(), &self.positive), &[], None, 1.0);
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

    /// Regresses once with all columns and changes the selection.
    ///
    /// - `grows`: whether unknowns are added and dropped.
    fn round(&mut self, state: &mut State, grows: bool) -> Option<Round> {
        let corrected = self.corrected(&state.sizes);
        let smoothed = self.signals(&corrected)?;
        let period = smoothed.period();
        let repeats = (2.0 / row_cutoff(&self.reading) / period).max(1.0);
        if state.theta.is_empty() {
            state.theta = self.first_theta(&smoothed, repeats)?;
        }
        let theta = self.floored(&state.theta, smoothed.segments(), period);
        let zero = self.zero(&corrected)?;
        let directions = self.directions(&corrected, &zero)?;
        let mut rows =
            self.former(period)
                .form(smoothed.segments(), &theta, &self.unknowns, &directions)?;
        let scales = self.scales(&rows);
        let begins: Vec<Option<usize>> = (0..self.unknowns.len())
            .map(|unknown| self.begins(unknown))
            .collect();
        let mut evidence = self.evidence(&rows, (state, &scales), None, repeats);
        let applied = self.applied_sizes(state);
        let joint_of = |channel: usize| self.channels.all[channel].joint;
        let mut added = false;
        if grows {
            let selection = Selection {
                evidence: &evidence,
                unknowns: &self.unknowns,
                scales: &scales,
                begins: &begins,
            };
            if let Some(unknown) = selection
                .superfluous(&state.chosen, &applied)
                .filter(|unknown| !self.asked.contains(unknown))
            {
                state.chosen.retain(|other| *other != unknown);
                state.sizes[unknown] = 0.0;
                return Some(Round {
                    evidence,
                    scales,
                    begins,
                    changed: true,
                });
            }
            for _ in 0..ADDED_IN_A_ROUND {
                if state.chosen.len() >= MAX_UNKNOWNS {
                    break;
                }
                let selection = Selection {
                    evidence: &evidence,
                    unknowns: &self.unknowns,
                    scales: &scales,
                    begins: &begins,
                };
                let Some(Chosen { unknown, gain, .. }) = selection.best(&state.chosen, &joint_of)
                else {
                    break;
                };
                if self.unknowns[unknown].kind == "lost-counts"
                    && !self.unknowns[unknown].has_rate()
                {
                    let weights = evidence.weights.clone();
                    self.meet_the_time(
                        unknown,
                        (state, &scales),
                        (&corrected, &zero),
                        (&mut rows, &theta, &smoothed),
                        (&weights, repeats),
                    )?;
                    evidence = self.evidence(&rows, (state, &scales), Some(weights), repeats);
                }
                state.chosen.push(unknown);
                state.gains[unknown] = gain;
                added = true;
            }
        }
        let selection = Selection {
            evidence: &evidence,
            unknowns: &self.unknowns,
            scales: &scales,
            begins: &begins,
        };
        let columns = selection.columns(&state.chosen);
        let x = evidence.fit(&columns);
        let held_out = evidence.held_out(&columns, None);
        let all: Vec<usize> = (0..PARTS).collect();
        let mut moved: f64 = 0.0;
        for &unknown in &state.chosen.clone() {
            let column = selection.column(unknown);
            let (_, error) = held_out.mean_and_error(column, &all);
            let floor = 1e-3 * scales[unknown];
            state.errors[unknown] = error.max(floor);
            if self.unknowns[unknown].channels().is_empty() {
                state.sizes[unknown] = x[column];
                continue;
            }
            let rescale = self.rescale(unknown, &theta, &x);
            let step = (rescale * x[column]).clamp(-3.0 * scales[unknown], 3.0 * scales[unknown]);
            state.sizes[unknown] += step;
            moved = moved.max(step.abs() / error.max(10.0 * floor));
        }
        let mut next = state.theta.clone();
        for (&column, value) in self.free.iter().zip(&x) {
            next[column] = *value;
        }
        state.theta = next;
        let changed = added || moved > 0.5;
        Some(Round {
            evidence,
            scales,
            begins,
            changed,
        })
    }

    /// Returns the sizes that the samples already contain, which are those of channels.
    fn applied_sizes(&self, state: &State) -> Vec<f64> {
        (self.unknowns.iter().zip(&state.sizes))
            .map(|(unknown, size)| {
                if unknown.channels().is_empty() {
                    0.0
                } else {
                    *size
                }
            })
            .collect()
    }

    fn evidence(
        &self,
        rows: &[Row],
        (state, scales): (&State, &[f64]),
        weights: Option<Vec<f64>>,
        repeats: f64,
    ) -> Evidence {
        let applied = self.applied_sizes(state);
        let priors: Vec<Prior> = (self.unknowns.iter().zip(scales).zip(&applied))
            .map(|((unknown, &scale), &applied)| Prior {
                scale,
                applied,
                is_positive: unknown.is_positive,
            })
            .collect();
        Evidence::new(
            rows,
            (self.free.len(), &self.positive),
            &priors,
            weights,
            repeats,
        )
    }

    /// Returns the excerpt with the corrections of some sizes.
    fn corrected(&self, sizes: &[f64]) -> Excerpt {
        let mut blocks = self.excerpt.blocks().to_vec();
        for (unknown, &size) in self.unknowns.iter().zip(sizes) {
            if size == 0.0 {
                continue;
            }
            let Effect::Channels(channels, effect) = &unknown.effect else {
                continue;
            };
            for block in &mut blocks {
                for &channel in channels {
                    let samples = self.samples(block, channel);
                    block.values[channel] = effect.perturb(&samples, size);
                }
            }
        }
        self.excerpt.replaced(blocks)
    }

    fn samples<'s>(&self, block: &'s LogBlock, channel: usize) -> Samples<'s> {
        Samples {
            time: &block.time,
            values: &block.values[channel],
            period: self.excerpt.period(),
            span: self.span,
        }
    }

    /// Returns positions, velocities and torques after the same filter without phase shift, with as few samples as it allows.
    fn signals(&self, excerpt: &Excerpt) -> Option<Smoothed> {
        let order = self.reading.settings().position_filter_order;
        let filter =
            Butterworth::new(order, self.reading.position_cutoff_hz(), excerpt.period()).ok()?;
        // A period that is a whole fraction up to rounding counts as one.
        let every = ((1.0 / (RATE_HZ * excerpt.period()) + 1e-6) as usize).max(1);
        excerpt.smoothed(&self.reading)?.continuous(&filter, every)
    }

    /// Returns the signals of a log whose channels are all zero.
    fn zero(&self, corrected: &Excerpt) -> Option<Smoothed> {
        let blocks = (corrected.blocks().iter())
            .map(|block| LogBlock {
                values: vec![vec![0.0; block.len()]; block.values.len()],
                ..block.clone()
            })
            .collect();
        self.signals(&corrected.replaced(blocks))
    }

    /// Returns the directions of all unknowns of channels. Those of one kind and signal are formed together, joint by joint.
    fn directions(&self, corrected: &Excerpt, zero: &Smoothed) -> Option<Vec<Direction>> {
        let mut passes: BTreeMap<(String, usize), Vec<usize>> = BTreeMap::new();
        let is_coupled = self.channels.position_mix.is_some() || self.channels.torque_mix.is_some();
        for (k, unknown) in self.unknowns.iter().enumerate() {
            let [channel] = unknown.channels() else {
                continue;
            };
            let of = &self.channels.all[*channel];
            let signal = match of.quantity.signal() {
                Signal::Link => 0,
                Signal::Motor => 1,
                _ => 2,
            };
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
            if unknown.channels().len() < 2 {
                continue;
            }
            let single = |direction: &&Direction| {
                let other = &self.unknowns[direction.unknown];
                other.kind == unknown.kind
                    && matches!(other.channels(), [channel] if unknown.channels().contains(channel))
            };
            let members: Vec<&Direction> = directions.iter().filter(single).collect();
            let Some(sum) = sum_of(k, &members, zero.segments()) else {
                continue;
            };
            directions.push(sum);
        }
        Some(directions)
    }

    /// Returns the directions of unknowns of different joints.
    fn pass(
        &self,
        unknowns: &[usize],
        (corrected, zero): (&Excerpt, &Smoothed),
        is_coupled: bool,
    ) -> Option<Vec<Direction>> {
        let blocks = (corrected.blocks().iter())
            .map(|block| {
                let mut values = vec![vec![0.0; block.len()]; block.values.len()];
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
                LogBlock {
                    values,
                    ..block.clone()
                }
            })
            .collect();
        let smoothed = self.signals(&corrected.replaced(blocks))?;
        let n = self.model.joint_count();
        let directions = unknowns.iter().map(|&unknown| {
            let channel = self.unknowns[unknown].channels()[0];
            let of = &self.channels.all[channel];
            let joints: Vec<usize> = if is_coupled {
                (0..n).collect()
            } else {
                vec![of.joint]
            };
            let is_torque = of.quantity.signal() == Signal::Torque;
            let segments = (smoothed.segments().iter().zip(zero.segments()))
                .map(|(signals, zero)| difference(signals, zero, &joints, is_torque))
                .collect();
            Direction {
                unknown,
                joints,
                segments,
                has_rate: self.unknowns[unknown].has_rate(),
                scales_torque: is_torque && self.unknowns[unknown].kind == "gain",
            }
        });
        Some(directions.collect())
    }

    fn former(&self, period: f64) -> Rows<'_> {
        Rows {
            model: self.model,
            reading: &self.reading,
            period,
            rows: &self.rows,
            places: &self.places,
            edge: (2.0 / self.reading.position_cutoff_hz() / period).ceil() as usize,
        }
    }

    fn first_theta(&self, smoothed: &Smoothed, repeats: f64) -> Option<Vec<f64>> {
        let mut theta: Vec<f64> = (0..self.model.parameters().len())
            .map(|i| self.model.known(i).unwrap_or_default())
            .collect();
        let rows = self.former(smoothed.period()).form(
            smoothed.segments(),
            &theta,
            &self.unknowns,
            &[],
        )?;
        let evidence = Evidence::new(&rows, (self.free.len(), &self.positive), &[], None, repeats);
        let chosen: Vec<usize> = (0..self.free.len()).collect();
        for (&column, value) in self.free.iter().zip(evidence.fit(&chosen)) {
            theta[column] = value;
        }
        Some(theta)
    }

    /// Returns the parameters with stiffnesses of at least the torque over the deflection: a fault that drives a stiffness to zero
    /// must not hide its own column.
    fn floored(&self, theta: &[f64], segments: &[SignalBlock], period: f64) -> Vec<f64> {
        let mut floored = theta.to_vec();
        let scales = self.former(period).scales(segments);
        for (joint, (scales, _)) in scales.iter().enumerate() {
            if let Some(at) = self.model.index(JointParameter::Stiffness, joint)
                && self.model.known(at).is_none()
            {
                floored[at] = floored[at].max(scales.torque / scales.deflection);
            }
        }
        floored
    }

    /// Returns the factor by which a size is wrong because its column used another stiffness than the fit gives.
    fn rescale(&self, unknown: usize, theta: &[f64], x: &[f64]) -> f64 {
        let Place::Channel(channel) = self.unknowns[unknown].place else {
            return 1.0;
        };
        let of = &self.channels.all[channel];
        if !matches!(of.quantity.signal(), Signal::Link | Signal::Motor) {
            return 1.0;
        }
        let stiffness = self.model.index(JointParameter::Stiffness, of.joint);
        let place = stiffness.and_then(|at| Some((at, *self.places.get(&at)?)));
        place.map_or(1.0, |(at, place)| {
            (theta[at] / x[place].max(1e-9)).clamp(0.2, 3.0)
        })
    }

    /// Returns the usual size of each unknown; of a law the coefficient that makes its torque as large as the row's.
    fn scales(&self, rows: &[Row]) -> Vec<f64> {
        (self.unknowns.iter().enumerate())
            .map(|(k, unknown)| {
                if unknown.scale.is_finite() {
                    return unknown.scale;
                }
                let of_row = |row: &Row| {
                    let at = row
                        .columns
                        .iter()
                        .position(|column| *column == self.free.len() + k)?;
                    let last = row.values.ncols() - 1;
                    let rms = |column: usize| -> f64 {
                        (0..row.values.nrows())
                            .map(|i| row.values[(i, column)].powi(2))
                            .sum::<f64>()
                            .sqrt()
                    };
                    let length = rms(at);
                    (length > 0.0).then(|| rms(last) / length)
                };
                rows.iter().find_map(of_row).unwrap_or(1.0)
            })
            .collect()
    }

    fn begins(&self, unknown: usize) -> Option<usize> {
        let at = self.unknowns[unknown].begins()?;
        let share = (at - self.span[0]) / self.span[1].max(f64::MIN_POSITIVE);
        Some(((share * PARTS as f64) as usize).min(PARTS - 1))
    }

    /// Moves the time of a jump to where it explains most, between the neighbouring knots.
    #[expect(clippy::type_complexity, reason = "the state of one round")]
    fn meet_the_time(
        &mut self,
        unknown: usize,
        (state, scales): (&State, &[f64]),
        (corrected, zero): (&Excerpt, &Smoothed),
        (rows, theta, smoothed): (&mut Vec<Row>, &[f64], &Smoothed),
        (weights, repeats): (&[f64], f64),
    ) -> Option<()> {
        let [channel] = *self.unknowns[unknown].channels() else {
            return None;
        };
        let id = self.unknowns[unknown].id.clone();
        let mut best = self.unknowns[unknown].begins()?;
        let knot = self.span[1] / KNOTS_OF_TIME;
        let all_rows: Vec<usize> = (0..self.rows.len()).collect();
        let all: Vec<usize> = (0..PARTS).collect();
        for (reach, is_sharp) in [(knot, false), (knot / 6.0, false), (knot / 36.0, true)] {
            let mut least = f64::INFINITY;
            let centre = best;
            for k in -TIMES..=TIMES {
                let at = centre + reach * f64::from(k) / f64::from(TIMES);
                self.unknowns[unknown] = Unknown {
                    id: id.clone(),
                    ..lost_counts::at(&self.catalogued, channel, at, is_sharp)?
                };
                let direction = self.pass(&[unknown], (corrected, zero), false)?;
                let formed = self.former(smoothed.period()).form(
                    smoothed.segments(),
                    theta,
                    &self.unknowns,
                    &direction,
                )?;
                let merged = with_column(rows, &formed, self.free.len() + unknown);
                let evidence =
                    self.evidence(&merged, (state, scales), Some(weights.to_vec()), repeats);
                let mut columns: Vec<usize> = (0..self.free.len()).collect();
                columns.extend(
                    state
                        .chosen
                        .iter()
                        .chain([&unknown])
                        .map(|other| self.free.len() + other),
                );
                let left = evidence.held_out(&columns, None).sum(&all_rows, &all);
                if left < least {
                    (least, best) = (left, at);
                }
            }
        }
        self.unknowns[unknown] = Unknown {
            id,
            ..lost_counts::at(&self.catalogued, channel, best, true)?
        };
        let direction = self.pass(&[unknown], (corrected, zero), false)?;
        let formed = self.former(smoothed.period()).form(
            smoothed.segments(),
            theta,
            &self.unknowns,
            &direction,
        )?;
        *rows = with_column(rows, &formed, self.free.len() + unknown);
        Some(())
    }

    /// Applies every rival in earnest; it takes the place of an unknown if it predicts better. Tangents alone rank near ties badly.
    fn exchanged(&mut self, state: State, round: Round) -> Option<(State, Round)> {
        let weights = round.evidence.weights.clone();
        let (mut best, mut present) = (self.left(&state, &weights)?, (state, round));
        for unknown in present.0.chosen.clone() {
            if !present.0.chosen.contains(&unknown) || self.asked.contains(&unknown) {
                continue;
            }
            let selection = Selection {
                evidence: &present.1.evidence,
                unknowns: &self.unknowns,
                scales: &present.1.scales,
                begins: &present.1.begins,
            };
            let rivals =
                selection.rivals(unknown, &present.0.chosen, &self.applied_sizes(&present.0));
            for (rival, _) in rivals.into_iter().take(RIVALS) {
                let mut trial = present.0.clone();
                trial.chosen.retain(|other| *other != unknown);
                trial.gains[rival] = trial.gains[unknown];
                trial.sizes[unknown] = 0.0;
                trial.chosen.push(rival);
                self.round(&mut trial, false)?;
                let tried = self.round(&mut trial, false)?;
                let left = self.left(&trial, &weights)?;
                // No channel is early, so a late one may predict a little less well.
                let is_early = |state: &State, unknown: usize| {
                    self.unknowns[unknown].kind == "delay" && state.sizes[unknown] < 0.0
                };
                let needed = if is_early(&present.0, unknown) && !is_early(&trial, rival) {
                    LATE_FOR_EARLY
                } else {
                    REPLACES
                };
                if left < needed * best {
                    best = left;
                    present = (trial, tried);
                    break;
                }
            }
        }
        Some(present)
    }

    /// Returns the held-out squares with everything found applied, without tangents.
    fn left(&self, state: &State, weights: &[f64]) -> Option<f64> {
        let corrected = self.corrected(&state.sizes);
        let smoothed = self.signals(&corrected)?;
        let period = smoothed.period();
        let theta = self.floored(&state.theta, smoothed.segments(), period);
        let laws: Vec<usize> = (state.chosen.iter().copied())
            .filter(|&unknown| self.unknowns[unknown].channels().is_empty())
            .collect();
        let zero = Direction {
            unknown: 0,
            joints: Vec::new(),
            segments: smoothed
                .segments()
                .iter()
                .map(|_| SignalBlock::new(0))
                .collect(),
            has_rate: false,
            scales_torque: false,
        };
        let with_laws = if laws.is_empty() {
            Vec::new()
        } else {
            vec![zero]
        };
        let rows =
            self.former(period)
                .form(smoothed.segments(), &theta, &self.unknowns, &with_laws)?;
        let scales = vec![1e9; self.unknowns.len()];
        let untouched = State {
            sizes: vec![0.0; self.unknowns.len()],
            ..state.clone()
        };
        let evidence = self.evidence(&rows, (&untouched, &scales), Some(weights.to_vec()), 1.0);
        let columns: Vec<usize> = (0..self.free.len())
            .chain(laws.iter().map(|unknown| self.free.len() + unknown))
            .collect();
        let all_rows: Vec<usize> = (0..self.rows.len()).collect();
        let all: Vec<usize> = (0..PARTS).collect();
        Some(evidence.held_out(&columns, None).sum(&all_rows, &all))
    }

    /// Returns the zeros between encoders that the description estimates with the parameters.
    fn preloads(&self, state: &State, round: &Round) -> Vec<Found> {
        let columns: Vec<usize> = (0..self.free.len())
            .chain(state.chosen.iter().map(|k| self.free.len() + k))
            .collect();
        let held_out = round.evidence.held_out(&columns, None);
        let all: Vec<usize> = (0..PARTS).collect();
        let of_joint = |joint: usize| {
            let at = |kind| self.places.get(&self.model.index(kind, joint)?).copied();
            let (stiffness, preload) =
                (at(JointParameter::Stiffness)?, at(JointParameter::Preload)?);
            let channel = self.channels.telling(Signal::Link, joint)?;
            let offsets: Vec<f64> = (held_out.values.iter())
                .map(|values| values[preload] / values[stiffness])
                .collect();
            let mean = offsets.iter().sum::<f64>() / PARTS as f64;
            let squares: f64 = offsets.iter().map(|offset| (offset - mean).powi(2)).sum();
            let error = ((PARTS as f64 - 1.0) / PARTS as f64 * squares).sqrt();
            (mean.is_finite() && mean.abs() > SIGNIFICANT * error && error > 0.0).then(|| Found {
                id: format!("offset {}", self.channels.all[channel].column),
                kind: "offset",
                place: Place::Channel(channel),
                value: mean,
                standard_error: error,
                unit: if self.channels.turns[joint] {
                    "rad"
                } else {
                    "m"
                },
                begins: None,
                gain: round.evidence.gain_of(preload, &columns, (&held_out, &all)),
                own: 1.0,
                mimic: None,
                competing: Vec::new(),
            })
        };
        (0..self.model.joint_count()).filter_map(of_joint).collect()
    }

    fn described(&self, state: &State, round: &Round) -> Vec<Found> {
        let selection = Selection {
            evidence: &round.evidence,
            unknowns: &self.unknowns,
            scales: &round.scales,
            begins: &round.begins,
        };
        let applied = self.applied_sizes(state);
        (state.chosen.iter())
            .map(|&k| {
                let unknown = &self.unknowns[k];
                let rest: Vec<usize> = state
                    .chosen
                    .iter()
                    .copied()
                    .filter(|other| *other != k)
                    .collect();
                let others = selection.columns(&rest);
                let column = selection.column(k);
                let mimic = (0..self.free.len())
                    .map(|parameter| {
                        let rest: Vec<usize> =
                            others.iter().copied().filter(|c| *c != parameter).collect();
                        let beyond = round.evidence.directions(&rest);
                        (
                            parameter,
                            beyond.correlation(&round.evidence, column, parameter).abs(),
                        )
                    })
                    .max_by(|a, b| a.1.total_cmp(&b.1))
                    .map(|(parameter, _)| {
                        self.model.parameters()[self.free[parameter]].name.clone()
                    });
                Found {
                    id: unknown.id.clone(),
                    kind: unknown.kind,
                    place: unknown.place,
                    value: state.sizes[k],
                    standard_error: state.errors[k],
                    unit: unknown.unit,
                    begins: unknown.begins(),
                    gain: state.gains[k],
                    own: round
                        .evidence
                        .directions(&others)
                        .own(&round.evidence, column),
                    mimic,
                    competing: (selection.rivals(k, &state.chosen, &applied).into_iter())
                        .map(|(rival, correlation)| Competing {
                            id: self.unknowns[rival].id.clone(),
                            correlation,
                        })
                        .collect(),
                }
            })
            .collect()
    }
}

/// Parts of the span between neighbouring times of a search for a jump, and times on each side.
const KNOTS_OF_TIME: f64 = 12.0;
const TIMES: i32 = 6;

/// Returns rows with one column from others.
fn with_column(rows: &[Row], formed: &[Row], column: usize) -> Vec<Row> {
    (rows.iter().zip(formed))
        .map(|(row, new)| {
            let place = row.columns.iter().position(|c| *c == column);
            let from = new.columns.iter().position(|c| *c == column);
            let mut values = row.values.clone();
            if let (Some(place), Some(from)) = (place, from) {
                for i in 0..values.nrows() {
                    values[(i, place)] = new.values[(i, from)];
                }
            }
            Row {
                joint: row.joint,
                columns: row.columns.clone(),
                values,
                reliable: row.reliable.clone(),
            }
        })
        .collect()
}

/// Returns the change of the signals of some joints.
fn difference(
    signals: &SignalBlock,
    zero: &SignalBlock,
    joints: &[usize],
    is_torque: bool,
) -> SignalBlock {
    let n = signals.q.len();
    let mut change = SignalBlock::new(n);
    let minus =
        |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a - b).collect() };
    for &j in joints {
        if is_torque {
            change.tau[j] = minus(&signals.tau[j], &zero.tau[j]);
        } else {
            change.q[j] = minus(&signals.q[j], &zero.q[j]);
            change.dq[j] = minus(&signals.dq[j], &zero.dq[j]);
            change.phi[j] = minus(&signals.phi[j], &zero.phi[j]);
            change.dphi[j] = minus(&signals.dphi[j], &zero.dphi[j]);
        }
    }
    if is_torque {
        for j in (0..n).filter(|j| !joints.contains(j)) {
            change.tau[j] = vec![0.0; signals.len()];
        }
        for columns in [
            &mut change.q,
            &mut change.dq,
            &mut change.phi,
            &mut change.dphi,
        ] {
            for column in columns.iter_mut() {
                *column = vec![0.0; signals.len()];
            }
        }
    } else {
        change.tau.clear();
    }
    change
}

/// Returns the sum of the directions of several unknowns.
fn sum_of(unknown: usize, members: &[&Direction], segments: &[SignalBlock]) -> Option<Direction> {
    let first = members.first()?;
    let n = segments.first()?.q.len();
    let joints: Vec<usize> = (0..n)
        .filter(|j| members.iter().any(|member| member.joints.contains(j)))
        .collect();
    let summed = (segments.iter().enumerate())
        .map(|(s, segment)| {
            let zero = || vec![vec![0.0; segment.len()]; n];
            let mut sum = SignalBlock::new(n);
            (sum.q, sum.dq, sum.phi, sum.dphi) = (zero(), zero(), zero(), zero());
            sum.tau = if first.segments[s].tau.is_empty() {
                Vec::new()
            } else {
                zero()
            };
            for member in members {
                let of = &member.segments[s];
                let pairs = [
                    (&mut sum.q, &of.q),
                    (&mut sum.dq, &of.dq),
                    (&mut sum.phi, &of.phi),
                    (&mut sum.dphi, &of.dphi),
                    (&mut sum.tau, &of.tau),
                ];
                for (to, from) in pairs {
                    for (to, from) in to.iter_mut().zip(from) {
                        for (to, from) in to.iter_mut().zip(from) {
                            *to += from;
                        }
                    }
                }
            }
            sum
        })
        .collect();
    Some(Direction {
        unknown,
        joints,
        segments: summed,
        has_rate: first.has_rate,
        scales_torque: false,
    })
}
