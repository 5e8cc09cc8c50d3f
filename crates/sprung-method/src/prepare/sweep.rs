//! Estimates with several cut-offs of the position filter, and the choice among them by blocked
//! cross-validation.

use rayon::prelude::*;

use super::excerpt::Excerpt;
use super::smoothed::CUTOFF_STEP;
use crate::fit::{HoldOut, Missed, student_95};
use crate::model::Theta;
use crate::regression::Reading;

/// Lowest cut-off that can be chosen, Hz. The sweep continues one step below it, so each candidate
/// has two neighbours.
const LOWEST_HZ: f64 = 5.0;

/// Number of parts of the beginning of a log, each of which is held out once.
const HOLD_OUT_PARTS: usize = 8;

/// Standard errors by which the held-out residual of a cut-off may exceed the least one. Higher cut-offs smear less, so
/// the highest of those without a significant difference is used.
///
/// # Source
///
/// Breiman, Friedman, Olshen and Stone, "Classification and regression trees", 1984, section 3.4.3: the rule of one
/// standard error.
const BY_CHANCE: f64 = 1.0;

/// Excess of the held-out residual that is irrelevant for any standard error.
const SMALL_EXCESS: f64 = 0.02;

/// Estimates with several cut-offs.
#[derive(Clone, Debug)]
pub(crate) struct Sweep {
    /// The cut-offs, in ascending order.
    pub(crate) points: Vec<CutoffAt>,
    /// Index of the cut-off in use.
    pub(crate) chosen: usize,
}

/// Estimate with one cut-off.
#[derive(Clone, Debug)]
pub(crate) struct CutoffAt {
    /// Cut-off, Hz.
    pub(crate) cutoff_hz: f64,
    /// Estimate from the beginning of the log, \[p\].
    pub(crate) theta: Theta,
    /// Residual of the filtered torque of each part with the estimate of the other parts, relative
    /// to the torque.
    pub(crate) held_out: Option<f64>,
    /// The same without each part in turn.
    without_each: Vec<f64>,
    /// Estimates without each part in turn; empty if a part determines a parameter alone.
    thetas: Vec<Theta>,
}

impl CutoffAt {
    /// Returns half of the 95 % interval of the difference between the estimates of a parameter with two cut-offs, by the
    /// jackknife over the parts; zero if it cannot be formed.
    pub(crate) fn change_by_chance(&self, other: &Self, parameter: usize) -> f64 {
        let differences: Vec<f64> = (self.thetas.iter().zip(&other.thetas))
            .map(|(theta, other)| theta[parameter] - other[parameter])
            .collect();
        student_95(differences.len().saturating_sub(1)) * jackknife(&differences)
    }

    /// Returns whether the held-out residual exceeds another one by a relevant and significant amount: by the scatter
    /// of the ratio of both without each part in turn.
    fn is_worse_than(&self, other: &Self) -> bool {
        let (Some(held_out), Some(least)) = (self.held_out, other.held_out) else {
            return true;
        };
        let ratios: Vec<f64> = (self.without_each.iter().zip(&other.without_each))
            .map(|(held_out, least)| held_out / least)
            .collect();
        held_out / least - 1.0 > SMALL_EXCESS.max(BY_CHANCE * jackknife(&ratios))
    }
}

/// Returns the standard error of a quantity from its values without each part in turn; zero without values.
fn jackknife(values: &[f64]) -> f64 {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    ((count - 1.0) / count * squares).sqrt()
}

/// Sweeps the cut-off of a reading and chooses among the lower cut-offs; `None` if the beginning of
/// the log is too short for the filters.
///
/// - `free`: whether a lower cut-off may be chosen. If not, the sweep has only the neighbours of
///   the cut-off.
///
/// Each part of the beginning of the log is predicted by a fit of the other parts. The cut-off
/// filters only positions, and the filter pair alone filters the torque. So all cut-offs predict
/// the same torque, and no cut-off has an advantage by removing a part of it. Rows without a torque
/// do not count, because a lower cut-off shrinks both of their sides.
pub(crate) fn sweep(reading: &Reading, excerpt: &Excerpt, free: bool) -> Option<Sweep> {
    let from_noise = reading.position_cutoff_hz();
    let lowest = if free {
        LOWEST_HZ.min(from_noise) / CUTOFF_STEP
    } else {
        from_noise / CUTOFF_STEP
    };
    let highest = from_noise * CUTOFF_STEP;
    let all = std::iter::successors(Some(highest), |cutoff| Some(cutoff / CUTOFF_STEP));
    let cutoffs: Vec<f64> = all.take_while(|cutoff| *cutoff > 0.999 * lowest).collect();
    let estimates = cutoffs.par_iter().rev();
    let points: Vec<CutoffAt> = estimates
        .filter_map(|&cutoff| estimate(reading, excerpt, cutoff))
        .collect();
    let noise =
        (points.iter()).position(|point| (point.cutoff_hz / from_noise - 1.0).abs() < 1e-3)?;
    let mut chosen = noise;
    if free && points[noise].held_out.is_some() {
        let is_candidate = |i: &usize| *i == noise || points[*i].cutoff_hz > 0.999 * LOWEST_HZ;
        let candidates: Vec<usize> = (0..=noise).filter(is_candidate).collect();
        let residual = |i: usize| points[i].held_out.unwrap_or(f64::INFINITY);
        let best =
            (candidates.iter().copied()).min_by(|&a, &b| residual(a).total_cmp(&residual(b)))?;
        let as_good = |i: &&usize| !points[**i].is_worse_than(&points[best]);
        chosen = candidates
            .iter()
            .rev()
            .find(as_good)
            .copied()
            .unwrap_or(best);
    }
    Some(Sweep { points, chosen })
}

fn estimate(reading: &Reading, excerpt: &Excerpt, cutoff_hz: f64) -> Option<CutoffAt> {
    // The beginning of a log hardly shows slow covariates.
    let none = vec![0.0; reading.model().parameters().len()];
    let model = &reading.model().with_known_changes(&none);
    // The noise of a velocity grows with the power 1.5 of the cut-off.
    let noise = (cutoff_hz / reading.position_cutoff_hz()).powf(1.5);
    let mut filtered = reading.with_position_cutoff(cutoff_hz);
    if let Some(weights) = reading.weights() {
        filtered = filtered.with_weights(weights.clone().with_noise(noise));
    }
    let system = excerpt
        .smoothed(&filtered)?
        .thinned(reading)
        .reduce(&filtered)?;
    let hold_out = HoldOut::new(model, &system, HOLD_OUT_PARTS);
    let theta = hold_out.fit_determined()?;
    let thetas: Option<Vec<Theta>> = hold_out.fits_without_each().into_iter().collect();
    let thetas = thetas.unwrap_or_default();
    let missed: Vec<Missed> = (thetas.iter().enumerate())
        .map(|(part, fit)| hold_out.missed(part, fit))
        .collect();
    let without = |left_out: Option<usize>| {
        let kept = (missed.iter().enumerate()).filter(|(part, _)| Some(*part) != left_out);
        let sum = kept.fold(Missed::default(), |sum, (_, missed)| sum.with(missed));
        sum.of_torque_rows()
    };
    Some(CutoffAt {
        cutoff_hz,
        theta,
        held_out: without(None),
        without_each: (0..missed.len())
            .filter_map(|part| without(Some(part)))
            .collect(),
        thetas,
    })
}
