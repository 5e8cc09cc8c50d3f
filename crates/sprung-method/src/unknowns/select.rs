//! Forward selection of unknowns by held-out gain.

use rayon::prelude::*;

use super::evidence::{Evidence, HeldOut, PARTS};
use super::unknown::{Kind, Place, Unknown};

/// Least size in jackknife standard errors over the parts: Student's t with 7 degrees of freedom, p = 0.0016, for about 100
/// candidates.
pub(super) const SIGNIFICANT: f64 = 5.0;

/// The same for the factor of a torque or of gravity, which parameters mimic.
const CERTAIN: f64 = 2.0 * SIGNIFICANT;

/// Least size in standard errors of an unknown that is tried in earnest.
const DOUBTFUL: f64 = 3.0;

/// Least relative fall of the held-out squares: smoothing and noise fake up to 1 %.
const LEAST_GAIN: f64 = 0.03;

/// The same for a rare fault of a sensor, which an error of the model may resemble.
const LEAST_GAIN_OF_RARE: f64 = 0.3;

/// The same for a factor that is certain: it acts in a few of the rows only.
const LEAST_GAIN_OF_TOLD: f64 = 0.01;

/// The same for a law: the smearing of the filters and torques held between samples fake one with up to 13 %.
const LEAST_GAIN_OF_LAW: f64 = 0.15;

/// Least part of a column that unknowns found before must leave. Below it the unknown is another name for them.
const LEAST_OWN: f64 = 0.1;

/// Part of a column that no parameter mimics, below which the unknown must explain more, in proportion.
const CLEAR_OWN: f64 = 0.3;

/// A rival has at least this correlation with an unknown.
const RIVAL_CORRELATION: f64 = 0.7;

/// Candidates that are fitted exactly at a time, the likeliest first.
const EXACT: usize = 8;

/// Part of the largest fall of the held-out squares that counts as as much, if what is left is as little.
const AS_MUCH: f64 = 0.9;

/// Largest size in usual sizes.
const LARGEST: f64 = 12.0;

/// A candidate that explains parts which the fit has not seen.
#[derive(Clone, Debug)]
pub(super) struct Chosen {
    pub(super) unknown: usize,
    /// Relative fall of the held-out squares of its rows.
    pub(super) gain: f64,
    /// Its size.
    size: f64,
}

/// Data of a selection.
pub(super) struct Selection<'a> {
    pub(super) evidence: &'a Evidence,
    pub(super) unknowns: &'a [Unknown],
    /// Usual size of each unknown, with those of laws.
    pub(super) scales: &'a [f64],
    /// Part of the log in which each unknown begins, if it does.
    pub(super) begins: &'a [Option<usize>],
}

impl Selection<'_> {
    pub(super) fn column(&self, unknown: usize) -> usize {
        self.evidence.free + unknown
    }

    pub(super) fn columns(&self, chosen: &[usize]) -> Vec<usize> {
        (0..self.evidence.free)
            .chain(chosen.iter().map(|&unknown| self.column(unknown)))
            .collect()
    }

    /// Returns the rows by which an unknown is judged.
    fn rows(&self, unknown: usize, joint_of: impl Fn(usize) -> usize) -> Vec<usize> {
        match self.unknowns[unknown].place {
            Place::Channel(channel) => self.evidence.rows_of(joint_of(channel)),
            Place::Joint(joint) => self.evidence.rows_of(joint),
            Place::All(_) | Place::Robot => (0..self.evidence.row_count()).collect(),
        }
    }

    /// Returns the parts by which an unknown is judged: the others cannot foretell the part in which it begins.
    fn parts(&self, unknown: usize) -> Vec<usize> {
        (0..PARTS)
            .filter(|part| self.begins[unknown] != Some(*part))
            .collect()
    }

    /// Returns the best further unknown, if one explains enough.
    ///
    /// - `joint_of`: joint of a channel.
    pub(super) fn best(
        &self,
        chosen: &[usize],
        joint_of: &(dyn Fn(usize) -> usize + Sync),
    ) -> Option<Chosen> {
        let columns = self.columns(chosen);
        let before = self.evidence.held_out(&columns, None);
        let screened = self.screened(chosen, &before, joint_of);
        for likeliest in screened.chunks(EXACT) {
            let judged: Vec<Option<(f64, Chosen)>> = likeliest
                .par_iter()
                .map(|(_, unknown)| self.judged(*unknown, &columns, &before, joint_of))
                .collect();
            let judged: Vec<(f64, Chosen)> = judged.into_iter().flatten().collect();
            let most = judged.iter().map(|(fall, _)| *fall).fold(0.0, f64::max);
            // Of unknowns that explain as much: the timing of the torques, no early channel, and the first of the catalogue. An
            // eccentric encoder over a short arc has a wrong gain.
            let best = judged.iter().max_by(|a, b| a.0.total_cmp(&b.0));
            let left = best.map_or(1.0, |(_, chosen)| 1.0 - chosen.gain);
            let alike = judged.iter().filter(|(fall, chosen)| {
                *fall >= AS_MUCH * most && AS_MUCH * (1.0 - chosen.gain) <= left
            });
            let rank = |chosen: &Chosen| {
                let unknown = &self.unknowns[chosen.unknown];
                let is_expected = chosen.size.abs() <= unknown.expected;
                let is_early = unknown.kind == Kind::Delay && chosen.size < 0.0;
                (!is_expected, is_early, chosen.unknown)
            };
            if let Some((_, first)) = alike.min_by_key(|(_, chosen)| rank(chosen)) {
                return Some(first.clone());
            }
        }
        None
    }

    /// Returns the unknowns that lower the held-out squares, each with the fall by a fit that is not exact, the likeliest first.
    fn screened(
        &self,
        chosen: &[usize],
        before: &HeldOut,
        joint_of: &(dyn Fn(usize) -> usize + Sync),
    ) -> Vec<(f64, usize)> {
        let columns = self.columns(chosen);
        let fits = self.evidence.fits(&columns);
        let parameters: Vec<usize> = (0..self.evidence.free).collect();
        let alone = self.evidence.directions(&parameters);
        let is_open = |unknown: usize| {
            let column = self.column(unknown);
            let is_new = !chosen.contains(&unknown) && !self.is_taken(unknown, chosen, joint_of);
            is_new
                && !self.evidence.is_empty(column, self.scales[unknown])
                && (chosen.is_empty()
                    || fits.whole.own(self.evidence, column)
                        >= LEAST_OWN * alone.own(self.evidence, column))
        };
        let mut screened: Vec<(f64, usize)> = (0..self.unknowns.len())
            .into_par_iter()
            .filter(|&unknown| is_open(unknown))
            .filter_map(|unknown| {
                let after = fits.with(self.column(unknown))?;
                Some((self.gain(unknown, (before, &after), joint_of)?.0, unknown))
            })
            .filter(|(fall, _)| *fall > 0.0)
            .collect();
        screened.sort_by(|a, b| b.0.total_cmp(&a.0));
        screened
    }

    /// Returns delays that lower the held-out squares but are less significant than [`SIGNIFICANT`], the likeliest first: the tangent
    /// at zero is a poor column of a long delay.
    pub(super) fn doubtful_delays(
        &self,
        chosen: &[usize],
        joint_of: &(dyn Fn(usize) -> usize + Sync),
    ) -> Vec<usize> {
        let columns = self.columns(chosen);
        let before = self.evidence.held_out(&columns, None);
        let screened = self.screened(chosen, &before, joint_of);
        let is_doubtful = |unknown: usize| {
            let fits = self
                .evidence
                .held_out(&[&columns[..], &[self.column(unknown)]].concat(), None);
            let (mean, error) = fits.mean_and_error(self.column(unknown), &self.parts(unknown));
            mean.abs() > DOUBTFUL * error
        };
        (screened.into_iter().take(EXACT))
            .map(|(_, unknown)| unknown)
            .filter(|&unknown| self.unknowns[unknown].kind == Kind::Delay && is_doubtful(unknown))
            .collect()
    }

    /// Returns the fall of the held-out squares of an unknown's rows and this fall relative to them; `None` if the squares of
    /// all rows rise.
    fn gain(
        &self,
        unknown: usize,
        (before, after): (&HeldOut, &HeldOut),
        joint_of: &dyn Fn(usize) -> usize,
    ) -> Option<(f64, f64)> {
        let (rows, parts) = (self.rows(unknown, joint_of), self.parts(unknown));
        let all: Vec<usize> = (0..self.evidence.row_count()).collect();
        let first = before.sum(&rows, &parts);
        let fall = first - after.sum(&rows, &parts);
        let falls = after.sum(&all, &parts) < before.sum(&all, &parts);
        falls.then_some((fall, fall / first.max(f64::MIN_POSITIVE)))
    }

    /// Returns the fall of the held-out squares of an unknown, if it explains enough.
    fn judged(
        &self,
        unknown: usize,
        columns: &[usize],
        before: &HeldOut,
        joint_of: &dyn Fn(usize) -> usize,
    ) -> Option<(f64, Chosen)> {
        let (column, scale) = (self.column(unknown), self.scales[unknown]);
        // What one phase of a wave leaves makes its size uncertain.
        let other_phase = self.other_phase(unknown).map(|other| self.column(other));
        let other_phase = other_phase.filter(|other| !columns.contains(other));
        let with: Vec<usize> = (columns.iter().copied())
            .chain([column])
            .chain(other_phase)
            .collect();
        let after = self.evidence.held_out(&with, None);
        let (fall, gain) = self.gain(unknown, (before, &after), joint_of)?;
        let (mean, error) = after.mean_and_error(column, &self.parts(unknown));
        let least_error = if self.evidence.is_white {
            self.evidence
                .directions(columns)
                .error(self.evidence, column)
        } else {
            1e-3 * scale
        };
        let significance = mean.abs() / error.max(least_error);
        let is_expected = mean.abs() <= self.unknowns[unknown].expected;
        let is_resolved =
            self.evidence.is_white || mean.abs() >= self.unknowns[unknown].least_size(scale);
        let is_possible = mean.abs() < LARGEST * scale && self.unknowns[unknown].can_have(mean);
        let significant = if self.evidence.is_white {
            // The same probability of a false one as of three standard errors in a single test.
            (9.0 + 2.0 * (self.unknowns.len().max(1) as f64).ln()).sqrt()
        } else {
            SIGNIFICANT
        };
        if significance <= significant || !is_possible || !is_resolved {
            return None;
        }
        if is_expected || self.evidence.is_white {
            return Some((
                fall,
                Chosen {
                    unknown,
                    gain,
                    size: mean,
                },
            ));
        }
        // A law is a parameter of the model, so it may resemble others.
        let is_law = self.unknowns[unknown].added().is_some();
        // The factor of a torque or of gravity is one of the parameters but for those that rows share, so these tell it.
        let is_told = self.unknowns[unknown].is_factor() && significance > CERTAIN;
        let least = match (is_law, self.unknowns[unknown].is_rare) {
            (true, _) => LEAST_GAIN_OF_LAW,
            // Each phase as much as a fault.
            (false, true) if other_phase.is_some() => {
                1.0 - (1.0 - LEAST_GAIN_OF_RARE) * (1.0 - LEAST_GAIN_OF_RARE)
            }
            (false, true) => LEAST_GAIN_OF_RARE,
            (false, false) if is_told => LEAST_GAIN_OF_TOLD,
            (false, false) => LEAST_GAIN,
        };
        if gain <= least {
            return None;
        }
        // Parameters at their bounds mimic nothing.
        let used = |column: &usize| after.values.iter().any(|values| values[*column] != 0.0);
        let free: Vec<usize> = columns.iter().copied().filter(used).collect();
        let own = self.evidence.directions(&free).own(self.evidence, column);
        let needed = (least * (CLEAR_OWN / (own + 1e-9)).max(1.0)).min(0.5);
        (is_law || is_told || gain > needed).then_some((
            fall,
            Chosen {
                unknown,
                gain,
                size: mean,
            },
        ))
    }

    /// Returns the other phase of a wave.
    fn other_phase(&self, unknown: usize) -> Option<usize> {
        let wave = self.unknowns[unknown].wave()?;
        let mut all = 0..self.unknowns.len();
        all.find(|&other| other != unknown && self.unknowns[other].wave() == Some(wave))
    }

    /// Returns whether an unknown is chosen in another form, or its joint has another rare fault already: a second one is unlikely,
    /// and an error of the model needs several. Only both phases of a wave are one fault.
    fn is_taken(
        &self,
        unknown: usize,
        chosen: &[usize],
        joint_of: &dyn Fn(usize) -> usize,
    ) -> bool {
        let this = &self.unknowns[unknown];
        // Another velocity of the same law.
        if (chosen.iter()).any(|&other| other != unknown && self.unknowns[other].id == this.id) {
            return true;
        }
        let joint = |unknown: &Unknown| match unknown.place {
            Place::Channel(channel) => Some(joint_of(channel)),
            Place::Joint(joint) => Some(joint),
            Place::All(_) | Place::Robot => None,
        };
        let is_other_wave = |other: &Unknown| this.wave().is_some() && other.wave() == this.wave();
        this.is_rare
            && (chosen.iter().map(|&other| &self.unknowns[other]))
                .any(|other| other.is_rare && joint(other) == joint(this) && !is_other_wave(other))
    }

    /// Returns the unknowns that may stand for a chosen one.
    pub(super) fn rivals(
        &self,
        unknown: usize,
        chosen: &[usize],
        sizes: &[f64],
    ) -> Vec<(usize, f64)> {
        let rest: Vec<usize> = chosen
            .iter()
            .copied()
            .filter(|other| *other != unknown)
            .collect();
        let others = self.columns(&rest);
        let column = self.column(unknown);
        let beyond = self.evidence.directions(&others);
        let all_rows: Vec<usize> = (0..self.evidence.row_count()).collect();
        let parts: Vec<usize> = (0..PARTS).collect();
        let present = self
            .evidence
            .held_out(&self.columns(chosen), None)
            .sum(&all_rows, &parts);
        let mut rivals: Vec<(usize, f64)> = (0..self.unknowns.len())
            .into_par_iter()
            .filter(|other| !chosen.contains(other))
            .filter_map(|other| {
                let rival = self.column(other);
                if self.evidence.is_empty(rival, self.scales[other]) {
                    return None;
                }
                let correlation = beyond.correlation(self.evidence, column, rival);
                if correlation.abs() < RIVAL_CORRELATION {
                    return None;
                }
                let with: Vec<usize> = others.iter().copied().chain([rival]).collect();
                let fixed = Some((column, -sizes[unknown]));
                let left = self.evidence.held_out(&with, fixed).sum(&all_rows, &parts);
                (left < (1.0 + 2.0 * LEAST_GAIN) * present).then_some((other, correlation))
            })
            .collect();
        rivals.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
        rivals
    }
}
