//! What changed since an identification: the search of the catalogue with known parameters.

use super::confirmed_laws::joint;
use super::evidence::PARTS;
use super::found::{Found, Telling, with_whole_waves};
use super::gauge::relative;
use super::kinds::{CHANGE, finding};
use super::result::UnknownStatus;
use super::search::Search;
use super::searched::columns;
use super::settle::{Grows, Round, in_search};
use super::state::State;
use super::unknown::{Effect, Kind, Place, Unknown};
use sprung_core::parameters::JointParameter;

use crate::description::Experiment;
use crate::finding::Finding;
use crate::model::{Model, Theta};
use crate::prepare::Excerpt;
use crate::regression::Reading;

/// One thing that changed.
#[derive(Clone, Debug)]
pub(crate) struct FoundChange {
    pub(crate) found: Found,
    /// Joint; `None` for all of them.
    pub(crate) joint: Option<usize>,
    /// Column; `None` for a parameter of the robot and for several columns.
    pub(crate) column: Option<String>,
    /// Whole delay of its column, s; `None` for what is no delay of one column.
    pub(crate) delay: Option<f64>,
    /// Finding about a channel; `None` for a parameter of the robot.
    pub(crate) finding: Option<Finding>,
}

impl FoundChange {
    /// Returns the name of the parameter that changed; `None` for a channel.
    pub(crate) fn parameter(&self) -> Option<&str> {
        self.found.id.strip_prefix(CHANGE)
    }
}

/// What counts as an explanation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Asked {
    /// Factor by which a change lowers the product of the squared errors of all rows, at least.
    pub(crate) least_factor: f64,
    /// Whether the zeros between encoders are others than at the identification, as those of incremental encoders are.
    pub(crate) are_zeros_free: bool,
}

/// Finds the fewest changes since an identification that explain a log; `None` if none do, or the log is too short for the filters.
///
/// - `reading`: of the log, with a model whose parameters are all known; `file`: name of the log.
/// - `asked`: what counts as an explanation; `explained`: what the caller needs of corrected samples, and of the changed model and its
///   parameters, if they fit.
pub(crate) fn changes<T>(
    experiment: &Experiment,
    reading: &Reading,
    (excerpt, file): (&Excerpt, &str),
    asked: Asked,
    explained: impl Fn(&Excerpt, (&Model, &Theta)) -> Option<T>,
) -> Option<(Vec<FoundChange>, T)> {
    let (found, explained) = in_search(experiment, reading, excerpt, |search| {
        search.changed(asked, explained)
    })?;
    let (channels, names) = (reading.channels(), reading.model().joints());
    let found = with_whole_waves(relative(found, channels, excerpt.period()));
    let found = found.into_iter().map(|found| {
        let joint = joint(found.place, channels);
        let columns = columns(found.place, channels);
        let column = match columns[..] {
            [column] => Some(column.to_owned()),
            _ => None,
        };
        let telling = Telling {
            found: &found,
            columns,
            joint: joint.map_or("", |joint| &names[joint]),
            file,
            status: UnknownStatus::Found,
            is_addable: false,
            excerpt,
            gain: None,
            moves: None,
        };
        let finding = finding(&telling);
        let delay = match (found.kind, found.place) {
            (Kind::Delay, Place::Channel(channel)) => Some(reading.delays()[channel] + found.value),
            _ => None,
        };
        FoundChange {
            delay,
            column: column.filter(|_| finding.is_some()),
            finding,
            joint,
            found,
        }
    });
    let found: Vec<FoundChange> = found.collect();
    (!found.is_empty()).then_some((found, explained))
}

/// Most causes that are named together.
const MAX_CAUSES: usize = 3;

/// Causes are equally good if the products of the squared errors of all rows differ by less than this factor; that with the fewest
/// unknowns is named. A rare fault of a sensor must be better by its square.
const EQUALLY_GOOD: f64 = 1.3;

/// Standard errors from zero at which a value of a cause is named.
const SIGNIFICANT: f64 = 2.0;

/// What a cause leaves of held-out parts.
struct Judged {
    /// Logarithm of the product of the squared errors of all rows: the likelihood of rows with unknown noise.
    misfit: f64,
    /// Squared errors of all rows.
    squares: f64,
}

impl Search<'_> {
    /// Returns the fewest changes that explain the log.
    fn changed<T>(
        mut self,
        asked: Asked,
        explained: impl Fn(&Excerpt, (&Model, &Theta)) -> Option<T>,
    ) -> Option<(Vec<Found>, T)> {
        let mut state = State::new(self.unknowns.len());
        let mut round = self.repeated(&mut state, false)?;
        if asked.are_zeros_free {
            let zeros = self.all_of(&|unknown| unknown.kind == Kind::Offset);
            self.round(&mut state, Grows::Cause(&zeros, 0.0))?;
            round = self.repeated(&mut state, false)?;
        }
        let causes = self.causes();
        for _ in 0..MAX_CAUSES {
            let plain = self.judged(&[], &state, &round);
            let open = (causes.iter())
                .filter(|cause| cause.iter().all(|unknown| !state.chosen.contains(unknown)));
            let judged: Vec<(Judged, &Vec<usize>)> = open
                .map(|cause| (self.judged(cause, &state, &round), cause))
                .collect();
            let all = judged.iter().map(|(judged, _)| judged.misfit);
            let least = all.fold(plain.misfit, f64::min);
            let alike =
                (judged.iter()).filter(|(judged, _)| judged.misfit <= least + EQUALLY_GOOD.ln());
            let (best, cause) = alike.min_by_key(|(_, cause)| cause.len())?;
            if plain.misfit - best.misfit < asked.least_factor.ln() {
                return None;
            }
            let gain = 1.0 - best.squares / plain.squares;
            self.round(&mut state, Grows::Cause(cause, gain))?;
            round = self.repeated(&mut state, false)?;
            let (corrected, moved) = (self.corrected(&state.sizes), self.moved(&state));
            let model = self.loosened(&state);
            if let Some(explained) = explained(&corrected, (&model, &moved)) {
                let mut found = self.described(&state, &round);
                found.retain(|found| found.value.abs() > SIGNIFICANT * found.standard_error);
                let significance = |found: &Found| (found.value / found.standard_error).abs();
                found.sort_by(|a, b| significance(b).total_cmp(&significance(a)));
                return Some((found, explained));
            }
        }
        None
    }

    fn judged(&self, cause: &[usize], state: &State, round: &Round) -> Judged {
        let chosen = [&state.chosen[..], cause].concat();
        let columns = self.selection(round).columns(&chosen);
        let held_out = round.evidence.held_out(&columns, None);
        let all: Vec<usize> = (0..PARTS).collect();
        let squares: Vec<f64> = (0..self.rows.len())
            .map(|row| held_out.sum(&[row], &all).max(f64::MIN_POSITIVE))
            .collect();
        let is_rare = cause.iter().any(|&unknown| self.unknowns[unknown].is_rare);
        let penalty = if is_rare {
            2.0 * EQUALLY_GOOD.ln()
        } else {
            0.0
        };
        Judged {
            misfit: squares.iter().map(|squares| squares.ln()).sum::<f64>() + penalty,
            squares: squares.iter().sum(),
        }
    }

    /// Returns the parameters with the changes of a state.
    fn moved(&self, state: &State) -> Theta {
        let mut moved = self.known();
        for &unknown in &state.chosen {
            // The middle of a play stands for the preload.
            if let (Kind::Play, Place::Joint(joint)) =
                (self.unknowns[unknown].kind, self.unknowns[unknown].place)
                && let Some(preload) = self.model.index(JointParameter::Preload, joint)
            {
                moved[preload] = 0.0;
            }
            if let Effect::Parameters(by) = &self.unknowns[unknown].effect {
                for (value, by) in moved.iter_mut().zip(by) {
                    *value += state.sizes[unknown] * by;
                }
            }
        }
        moved
    }

    /// Returns the deflection of a spring without torque, rad (m).
    fn unloaded(&self, joint: usize) -> f64 {
        let known = |kind: JointParameter| {
            let index = self.model.index(kind, joint);
            index
                .and_then(|index| self.model.known(index))
                .unwrap_or_default()
        };
        let deflection = known(JointParameter::Preload) / known(JointParameter::Stiffness);
        if deflection.is_finite() {
            deflection
        } else {
            0.0
        }
    }

    /// Returns the model with the plays of a state.
    fn loosened(&self, state: &State) -> Model {
        let mut model = self.model.clone();
        for &unknown in &state.chosen {
            if let (Kind::Play, Place::Joint(joint)) =
                (self.unknowns[unknown].kind, self.unknowns[unknown].place)
            {
                let centre = self.unloaded(joint);
                model.set_play(joint, [state.sizes[unknown].max(0.0), centre]);
            }
        }
        model
    }

    /// Returns the indices of some unknowns.
    fn all_of(&self, is_meant: &dyn Fn(&Unknown) -> bool) -> Vec<usize> {
        let unknowns = self.unknowns.iter().enumerate();
        let meant = unknowns.filter(|(_, unknown)| is_meant(unknown));
        meant.map(|(index, _)| index).collect()
    }

    /// Returns the causes, each with its unknowns: friction of a joint and of all joints, the load, and all others alone.
    fn causes(&self) -> Vec<Vec<usize>> {
        let is_alone = |unknown: &Unknown| !matches!(unknown.kind, Kind::Friction | Kind::Load);
        let alone = self.all_of(&is_alone).into_iter();
        let mut causes: Vec<Vec<usize>> = alone.map(|unknown| vec![unknown]).collect();
        let is_friction = |unknown: &Unknown| unknown.kind == Kind::Friction;
        for joint in 0..self.model.joint_count() {
            let place = Place::Joint(joint);
            causes.push(self.all_of(&|unknown| is_friction(unknown) && unknown.place == place));
        }
        if self.model.joint_count() > 1 {
            causes.push(self.all_of(&is_friction));
        }
        causes.push(self.all_of(&|unknown| unknown.kind == Kind::Load));
        causes.retain(|cause| !cause.is_empty());
        causes
    }
}
