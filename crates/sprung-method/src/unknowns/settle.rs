//! Finds the unknowns of a log: regress, select, apply, until nothing is left.

use std::collections::BTreeMap;

use sprung_core::parameters::JointParameter;

use super::evidence::{Evidence, PARTS, mean_and_error};
use super::far::CERTAIN_MEANING;
use super::found::{Competing, Found};
use super::jumps::Formed;
use super::kinds::of_gravity;
use super::rows::{Row, Rows, Wanted, row_cutoff};
use super::search::Search;
use super::select::{Chosen, SIGNIFICANT, Selection};
use super::state::State;
use super::unknown::{Effect, Kind, Place};
use crate::description::Experiment;
use crate::log::Signal;
use crate::prepare::{Doubt, Excerpt};
use crate::preprocess::SignalBlock;
use crate::regression::Reading;

/// Largest cut-off of positions and torques, Hz. Delays, gains and zeros show in slow motion, and the noise is fast.
const CUTOFF_HZ: f64 = 15.0;

/// Most rounds, and most unknowns that a round adds: columns move with the state.
const MAX_ROUNDS: usize = 10;
const ADDED_IN_A_ROUND: usize = 2;

/// Most unknowns, besides one a joint.
const MAX_UNKNOWNS: usize = 8;

/// Change of a size in standard errors above which another round follows, and least standard error in usual sizes.
const MOVED: f64 = 0.5;
const LEAST_ERROR: f64 = 1e-3;

/// A rival takes the place of an unknown if it leaves less than this part of the held-out squares.
const REPLACES: f64 = 0.97;

/// The same for a delay that its tangent does not show. A wrong clock fakes 6 %.
const IN_EARNEST: f64 = 0.9;

/// The same for a late channel in the place of an early one.
const LATE_FOR_EARLY: f64 = 1.05;

/// Usual sizes beyond which a fault is less credible than a law that explains as much.
const UNUSUAL: f64 = 3.0;

/// Rivals of an unknown that are applied in earnest.
const RIVALS: usize = 3;

/// A round with its evidence.
pub(super) struct Round {
    pub(super) evidence: Evidence,
    scales: Vec<f64>,
    begins: Vec<Option<usize>>,
    changed: bool,
}

/// Rows with the columns of what is chosen.
pub(super) struct ChosenRows {
    pub(super) rows: Vec<Row>,
    /// Parameters with which the columns were formed, \[p\].
    pub(super) theta: Vec<f64>,
    /// Number of neighbouring samples that say the same.
    pub(super) repeats: f64,
}

/// What a round adds.
#[derive(Clone, Copy)]
pub(super) enum Grows<'c> {
    No,
    /// The unknowns that explain most.
    Best,
    /// Given unknowns, with what they gain.
    Cause(&'c [usize], f64),
}

/// What a search found.
pub(crate) struct Settlement {
    pub(crate) found: Vec<Found>,
    /// Part of the torques that stays unexplained on held-out parts (root mean square over the rows).
    pub(crate) unexplained: f64,
    /// Of the log, without the faults of credible sizes that sprung finds but does not correct; `None` if it has none.
    pub(crate) faultless: Option<Excerpt>,
    /// What the errors of delays and gains add to the standard errors of parameters, by name.
    pub(crate) doubt: BTreeMap<String, Doubt>,
}

/// Finds the unknowns of the beginning of a log.
///
/// Returns `None` if the log is too short for the filters, or its robot has link positions without an encoder.
pub(crate) fn settle(
    experiment: &Experiment,
    reading: &Reading,
    excerpt: &Excerpt,
) -> Option<Settlement> {
    #[expect(
        clippy::redundant_closure_for_method_calls,
        reason = "the method itself is not general enough"
    )]
    in_search(experiment, reading, excerpt, |search| search.settle())
}

/// Runs a search in the beginning of a log.
pub(super) fn in_search<T>(
    experiment: &Experiment,
    reading: &Reading,
    excerpt: &Excerpt,
    run: impl FnOnce(Search<'_>) -> Option<T>,
) -> Option<T> {
    let model = reading.model();
    // Slow filters smear the edges of a play and of a hysteresis.
    let has_edges = (0..model.joint_count())
        .any(|joint| model.play(joint).is_some() || model.hysteresis_width(joint).is_some());
    let limit = if has_edges { f64::INFINITY } else { CUTOFF_HZ };
    let cutoff = reading.position_cutoff_hz().min(limit);
    let reading = reading.without_weights().with_position_cutoff(cutoff);
    let (model, channels) = (reading.model().clone(), reading.channels().clone());
    if channels.inertial.is_some() || !model.joints_without_link().is_empty() {
        return None;
    }
    let segmented = excerpt.in_segments();
    run(Search::new(
        (experiment, &reading),
        &channels,
        &model,
        &segmented,
    ))
}

impl Search<'_> {
    fn settle(mut self) -> Option<Settlement> {
        let mut state = State::new(self.unknowns.len());
        state.chosen.clone_from(&self.asked);
        self.start_gains(&mut state)?;
        let left_by_other_meaning = self.left_by_other_meaning()?;
        if left_by_other_meaning < CERTAIN_MEANING {
            return None;
        }
        self.start_delays(&mut state)?;
        let mut round = self.grown(&mut state)?;
        if self.has_other_meaning(left_by_other_meaning, &state)? {
            return None;
        }
        if !state.chosen.is_empty() {
            (state, round) = self.exchanged(state, round)?;
        }
        // Columns move with what is applied, so an unknown may have lost its significance.
        while let Some(unknown) = self.insignificant(&state, &round.scales) {
            state.chosen.retain(|other| *other != unknown);
            state.sizes[unknown] = 0.0;
            round = self.repeated(&mut state, false)?;
        }
        self.sized(&mut state, &round.evidence.weights)?;
        let mut found = self.described(&state, &round);
        found.extend(self.preloads(&state, &round));
        let columns = self.selection(&round).columns(&state.chosen);
        Some(Settlement {
            found,
            unexplained: round.evidence.unexplained(&columns),
            faultless: self.faultless(&state),
            doubt: (self.free.iter().zip(&state.doubt))
                .map(|(&at, doubt)| (self.model.parameters()[at].name.clone(), *doubt))
                .collect(),
        })
    }

    /// Returns the excerpt without the faults of credible sizes that sprung does not correct; `None` if it has none.
    fn faultless(&self, state: &State) -> Option<Excerpt> {
        let mut sizes = state.sizes.clone();
        for (size, unknown) in sizes.iter_mut().zip(&self.unknowns) {
            let is_unusual = size.abs() > UNUSUAL * unknown.scale;
            let is_corrected =
                matches!(unknown.effect, Effect::Channels(..)) && !unknown.kind.is_applied();
            if is_unusual || !is_corrected {
                *size = 0.0;
            }
        }
        (sizes.iter().any(|&size| size != 0.0)).then(|| self.corrected(&sizes))
    }

    pub(super) fn selection<'s>(&'s self, round: &'s Round) -> Selection<'s> {
        self.selecting(&round.evidence, &round.scales, &round.begins)
    }

    fn selecting<'s>(
        &'s self,
        evidence: &'s Evidence,
        scales: &'s [f64],
        begins: &'s [Option<usize>],
    ) -> Selection<'s> {
        Selection {
            evidence,
            unknowns: &self.unknowns,
            scales,
            begins,
        }
    }

    /// Regresses and applies until nothing changes. Returns `None` also if further sizes do not help.
    ///
    /// - `grows`: whether unknowns are added.
    pub(super) fn repeated(&mut self, state: &mut State, grows: bool) -> Option<Round> {
        let step = || if grows { Grows::Best } else { Grows::No };
        let mut round = self.round(state, step())?;
        for _ in 1..MAX_ROUNDS {
            if !round.changed {
                break;
            }
            if grows && self.is_hopeless(state)? {
                return None;
            }
            round = self.round(state, step())?;
        }
        Some(round)
    }

    /// Adds unknowns and applies them until nothing is left.
    fn grown(&mut self, state: &mut State) -> Option<Round> {
        let mut round = self.repeated(state, true)?;
        while let Some(better) = self.tried(state, &round)? {
            *state = better;
            round = self.repeated(state, true)?;
        }
        Some(round)
    }

    /// Returns whether no further unknown may be added.
    fn is_full(&self, state: &State) -> bool {
        state.chosen.len() >= MAX_UNKNOWNS + self.model.joint_count()
    }

    /// Applies delays in earnest that are less significant than others; returns the state with the first that explains much.
    #[expect(
        clippy::option_option,
        reason = "the outer one is a log that is too short"
    )]
    fn tried(&mut self, state: &State, round: &Round) -> Option<Option<State>> {
        let selection = self.selection(round);
        let joint_of = |channel: usize| self.channels.all[channel].joint;
        let delays = selection.doubtful_delays(&state.chosen, &joint_of);
        if delays.is_empty() || self.is_full(state) {
            return Some(None);
        }
        let weights = round.evidence.weights.clone();
        let before = self.left(state, &weights)?;
        for unknown in delays {
            let mut trial = state.clone();
            trial.chosen.push(unknown);
            self.refitted(&mut trial, &weights)?;
            let left = self.left(&trial, &weights)?;
            if left < IN_EARNEST * before
                && trial.sizes[unknown].abs() > SIGNIFICANT * trial.errors[unknown]
            {
                trial.gains[unknown] = 1.0 - left / before;
                return Some(Some(trial));
            }
        }
        Some(None)
    }

    /// Regresses with the columns of what is chosen, and applies it, until nothing changes.
    fn refitted(&self, state: &mut State, weights: &[f64]) -> Option<()> {
        for _ in 0..MAX_ROUNDS {
            if self.refit(state, weights)? <= MOVED {
                break;
            }
        }
        Some(())
    }

    /// Regresses once with the columns of what is chosen; returns the largest change in standard errors.
    fn refit(&self, state: &mut State, weights: &[f64]) -> Option<f64> {
        let ChosenRows {
            rows,
            theta,
            repeats,
        } = self.rows_of_chosen(state, Self::floored)?;
        let scales = self.scales(&rows);
        let evidence = self.evidence(&rows, (state, &scales), Some(weights.to_vec()), repeats);
        Some(self.applied(state, (&evidence, &scales), &theta))
    }

    /// Forms the rows with the columns of what is chosen.
    ///
    /// - `near`: gives the parameters with which columns are formed, from those of the state.
    pub(super) fn rows_of_chosen(
        &self,
        state: &State,
        near: impl Fn(&Self, &[f64], &[SignalBlock], f64) -> Vec<f64>,
    ) -> Option<ChosenRows> {
        let corrected = self.corrected(&state.sizes);
        let smoothed = self.signals_of(&corrected, &state.sizes)?;
        let period = smoothed.period();
        let theta = near(self, &state.theta, smoothed.segments(), period);
        let wanted = Wanted::These(&state.chosen);
        let directions = self.directions(&corrected, self.zero()?, wanted)?;
        let model = self.sharpened(&state.sizes);
        let former = Rows {
            wanted,
            ..self.former(&model, period)
        };
        Some(ChosenRows {
            rows: former.form(smoothed.segments(), &theta, &self.unknowns, &directions)?,
            theta,
            repeats: self.repeats(period),
        })
    }

    /// Returns the number of neighbouring samples that say the same.
    fn repeats(&self, period: f64) -> f64 {
        (2.0 / row_cutoff(&self.reading) / period).max(1.0)
    }

    /// Regresses once with all columns and changes the selection.
    pub(super) fn round(&mut self, state: &mut State, grows: Grows<'_>) -> Option<Round> {
        let corrected = self.corrected(&state.sizes);
        let smoothed = self.signals_of(&corrected, &state.sizes)?;
        let period = smoothed.period();
        let repeats = self.repeats(period);
        if state.theta.is_empty() && self.leave_log(&state.sizes) {
            state.theta = self.first_theta(&self.logged()?.rows, repeats);
        } else if state.theta.is_empty() {
            let rows = self.plain_rows(&smoothed, &self.known())?;
            state.theta = self.first_theta(&rows, repeats);
        }
        let theta = self.floored(&state.theta, smoothed.segments(), period);
        let directions = self.directions(&corrected, self.zero()?, Wanted::All)?;
        let model = self.sharpened(&state.sizes);
        let mut rows = self.former(&model, period).form(
            smoothed.segments(),
            &theta,
            &self.unknowns,
            &directions,
        )?;
        let scales = self.scales(&rows);
        let begins: Vec<Option<usize>> = (0..self.unknowns.len())
            .map(|unknown| self.begins(unknown))
            .collect();
        let mut evidence = self.evidence(&rows, (state, &scales), None, repeats);
        let joint_of = |channel: usize| self.channels.all[channel].joint;
        let mut added = false;
        let mut given = match grows {
            Grows::Cause(cause, gain) => cause.iter().map(|unknown| (*unknown, gain)).collect(),
            Grows::No | Grows::Best => Vec::new(),
        };
        if !matches!(grows, Grows::No) {
            let mut moving = 0;
            let is_given = !given.is_empty();
            while is_given || (moving < ADDED_IN_A_ROUND && !self.is_full(state)) {
                let selection = self.selecting(&evidence, &scales, &begins);
                let next = match grows {
                    Grows::Best => (selection.best(&state.chosen, &joint_of))
                        .map(|Chosen { unknown, gain, .. }| (unknown, gain)),
                    Grows::No | Grows::Cause(..) => given.pop(),
                };
                let Some((unknown, gain)) = next else {
                    break;
                };
                if self.unknowns[unknown].kind == Kind::LostCounts
                    && !self.unknowns[unknown].has_rate()
                {
                    let weights = evidence.weights.clone();
                    let formed = Formed {
                        model: &model,
                        corrected: &corrected,
                        smoothed: &smoothed,
                        theta: &theta,
                        scales: &scales,
                        weights: &weights,
                        repeats,
                    };
                    rows = self.meet_the_time(unknown, state, &formed, &rows)?;
                    evidence = self.evidence(&rows, (state, &scales), Some(weights), repeats);
                }
                // A law moves no other column.
                moving += usize::from(self.unknowns[unknown].is_applied());
                state.chosen.push(unknown);
                state.gains[unknown] = gain;
                added = true;
            }
        }
        let moved = self.applied(state, (&evidence, &scales), &theta);
        Some(Round {
            evidence,
            scales,
            begins,
            changed: added || moved > MOVED,
        })
    }

    /// Returns the columns of the parameters and of some unknowns.
    pub(super) fn columns_of(&self, chosen: &[usize]) -> Vec<usize> {
        let free = self.free.len();
        (0..free)
            .chain(chosen.iter().map(|unknown| free + unknown))
            .collect()
    }

    /// Adds the sizes of a fit to those that are applied; returns the largest change in standard errors.
    pub(super) fn applied(
        &self,
        state: &mut State,
        (evidence, scales): (&Evidence, &[f64]),
        theta: &[f64],
    ) -> f64 {
        let free = self.free.len();
        let columns = self.columns_of(&state.chosen);
        let x = evidence.fit(&columns);
        let held_out = evidence.held_out(&columns, None);
        let all: Vec<usize> = (0..PARTS).collect();
        let mut moved: f64 = 0.0;
        for &unknown in &state.chosen {
            let column = free + unknown;
            let (_, error) = held_out.mean_and_error(column, &all);
            let floor = LEAST_ERROR * scales[unknown];
            let size = state.sizes[unknown];
            state.errors[unknown] = (self.unknowns[unknown].after(size, error) - size).max(floor);
            if !self.unknowns[unknown].is_applied() {
                if let Effect::Gravity(_) = self.unknowns[unknown].effect {
                    // Its column moves with the parameters.
                    moved = moved.max((x[column] - size).abs() / error.max(10.0 * floor));
                }
                state.sizes[unknown] = x[column];
                continue;
            }
            let rescale = self.rescale(unknown, theta, &x);
            let step = (rescale * x[column]).clamp(-3.0 * scales[unknown], 3.0 * scales[unknown]);
            state.sizes[unknown] = self.unknowns[unknown].after(size, step);
            moved = moved.max(step.abs() / error.max(10.0 * floor));
        }
        for (&column, value) in self.free.iter().zip(&x) {
            state.theta[column] = *value;
        }
        moved
    }

    /// Returns the least significant unknown, if it is not significant.
    fn insignificant(&self, state: &State, scales: &[f64]) -> Option<usize> {
        let significance = |unknown: &usize| {
            state.sizes[*unknown].abs() / state.errors[*unknown].max(f64::MIN_POSITIVE)
        };
        (state.chosen.iter().copied())
            .filter(|unknown| {
                let least = self.unknowns[*unknown].least_size(scales[*unknown]);
                let size = state.sizes[*unknown];
                let is_no_cause = size.abs() < least || !self.unknowns[*unknown].can_have(size);
                (is_no_cause || significance(unknown) < SIGNIFICANT)
                    && !self.asked.contains(unknown)
            })
            .min_by(|a, b| significance(a).total_cmp(&significance(b)))
    }

    /// Applies every rival in earnest; it takes the place of an unknown if it predicts better. Tangents alone rank near ties badly.
    fn exchanged(&mut self, state: State, round: Round) -> Option<(State, Round)> {
        let weights = round.evidence.weights.clone();
        let (mut best, mut present) = (self.left(&state, &weights)?, (state, round));
        for unknown in present.0.chosen.clone() {
            if !present.0.chosen.contains(&unknown) || self.asked.contains(&unknown) {
                continue;
            }
            let selection = self.selection(&present.1);
            let rivals =
                selection.rivals(unknown, &present.0.chosen, &self.applied_sizes(&present.0));
            // The columns of laws do not move, so the selection has ranked them exactly.
            let is_law = |unknown: usize| !self.unknowns[unknown].is_applied();
            let tangents =
                (rivals.into_iter()).filter(|(rival, _)| !is_law(unknown) || !is_law(*rival));
            for (rival, _) in tangents.take(RIVALS).collect::<Vec<_>>() {
                let mut trial = present.0.clone();
                trial.chosen.retain(|other| *other != unknown);
                trial.gains[rival] = trial.gains[unknown];
                trial.sizes[unknown] = 0.0;
                trial.chosen.push(rival);
                self.refit(&mut trial, &weights)?;
                self.refit(&mut trial, &weights)?;
                let left = self.left(&trial, &weights)?;
                // No channel is early, so a late one may predict a little less well.
                let is_early = |state: &State, unknown: usize| {
                    self.unknowns[unknown].kind == Kind::Delay && state.sizes[unknown] < 0.0
                };
                let needed = if is_early(&present.0, unknown) && !is_early(&trial, rival) {
                    LATE_FOR_EARLY
                } else {
                    REPLACES
                };
                if left < needed * best {
                    best = left;
                    let tried = self.round(&mut trial, Grows::No)?;
                    present = (trial, tried);
                    break;
                }
            }
        }
        Some(present)
    }

    /// Returns the held-out squares with everything found applied, without tangents.
    pub(super) fn left(&self, state: &State, weights: &[f64]) -> Option<f64> {
        let corrected = self.corrected(&state.sizes);
        let smoothed = self.signals_of(&corrected, &state.sizes)?;
        let period = smoothed.period();
        let theta = self.floored(&state.theta, smoothed.segments(), period);
        let laws: Vec<usize> = (state.chosen.iter().copied())
            .filter(|&unknown| !self.unknowns[unknown].is_applied())
            .collect();
        let model = self.sharpened(&state.sizes);
        let former = Rows {
            wanted: Wanted::These(&laws),
            ..self.former(&model, period)
        };
        let rows = former.form(smoothed.segments(), &theta, &self.unknowns, &[])?;
        let scales = vec![1e9; self.unknowns.len()];
        let untouched = State {
            sizes: vec![0.0; self.unknowns.len()],
            ..state.clone()
        };
        let evidence = self.evidence(&rows, (&untouched, &scales), Some(weights.to_vec()), 1.0);
        let columns = self.columns_of(&laws);
        let all_rows: Vec<usize> = (0..self.rows.len()).collect();
        let all: Vec<usize> = (0..PARTS).collect();
        Some(evidence.held_out(&columns, None).sum(&all_rows, &all))
    }

    /// Returns the zeros between encoders that the description estimates with the parameters.
    fn preloads(&self, state: &State, round: &Round) -> Vec<Found> {
        let columns = self.selection(round).columns(&state.chosen);
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
            let (mean, error) = mean_and_error(&offsets);
            (mean.is_finite() && mean.abs() > SIGNIFICANT * error && error > 0.0).then(|| Found {
                id: format!("offset {}", self.channels.all[channel].column),
                kind: Kind::Offset,
                place: Place::Channel(channel),
                value: mean,
                standard_error: error,
                unit: if self.channels.turns[joint] {
                    "rad"
                } else {
                    "m"
                },
                begins: None,
                law: None,
                fall: 0.0,
                gain: round.evidence.gain_of(preload, &columns, (&held_out, &all)),
                own: 1.0,
                mimic: None,
                competing: Vec::new(),
            })
        };
        (0..self.model.joint_count()).filter_map(of_joint).collect()
    }

    pub(super) fn described(&self, state: &State, round: &Round) -> Vec<Found> {
        let selection = self.selection(round);
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
                let (value, standard_error) = match unknown.effect {
                    Effect::Sharpness(joint) => {
                        let sharpness = self.model.sharpness(joint) * state.sizes[k].exp();
                        (sharpness, sharpness * state.errors[k])
                    }
                    Effect::Gravity(_) => {
                        let scale = of_gravity(state.sizes[k]);
                        (scale, 0.5 * state.errors[k] / (1.0 + scale))
                    }
                    Effect::Channels(..) | Effect::Law { .. } | Effect::Parameters(_) => {
                        (state.sizes[k], state.errors[k])
                    }
                };
                Found {
                    id: unknown.id.clone(),
                    kind: unknown.kind,
                    place: unknown.place,
                    value,
                    standard_error,
                    unit: unknown.unit,
                    begins: unknown.begins(),
                    law: unknown.added().cloned(),
                    fall: 1.0 - (1.0 - state.gains[k]).max(0.0).sqrt(),
                    gain: state.gains[k],
                    own: round
                        .evidence
                        .directions(&others)
                        .own(&round.evidence, column),
                    mimic,
                    competing: (selection.rivals(k, &state.chosen, &applied).into_iter())
                        .filter(|(rival, _)| self.unknowns[*rival].id != unknown.id)
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
