//! Estimates with several cut-offs of the position filter, and the choice among them by blocked
//! hold-out.

use rayon::prelude::*;

use super::excerpt::Excerpt;
use super::smoothed::CUTOFF_STEP;
use crate::fit::HoldOut;
use crate::model::Theta;
use crate::regression::Reading;

/// Lowest cut-off that can be chosen, Hz. The sweep continues one step below it, so that each
/// candidate has two neighbours.
const LOWEST_HZ: f64 = 5.0;

/// Number of parts of the beginning of a log, each of which is held out once.
const HOLD_OUT_PARTS: usize = 8;

/// A lower cut-off replaces the one that the noise asks for if its held-out residual is below this
/// fraction of that one's residual.
const BETTER_SHARE: f64 = 0.98;

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
}

/// Sweeps the cut-off of a reading and chooses among the lower cut-offs; `None` if the beginning of
/// the log is too short for the filters.
///
/// - `free`: whether a lower cut-off may be chosen. If not, the sweep has only the neighbours of
///   the cut-off.
///
/// Each part of the beginning of the log is predicted by a fit of the other parts. The cut-off
/// filters only positions, and the filter pair alone filters the torque. So all cut-offs predict
/// the same torque, and no cut-off gains by removing a part of it. Rows without a torque do not
/// count, because a lower cut-off shrinks both of their sides.
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
    if let Some(own) = points[noise].held_out.filter(|_| free) {
        let candidates = (points[..noise].iter().enumerate())
            .filter(|(_, point)| point.cutoff_hz > 0.999 * LOWEST_HZ)
            .filter_map(|(i, point)| Some((i, point.held_out?)));
        chosen = candidates
            .filter(|(_, residual)| *residual < BETTER_SHARE * own)
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map_or(noise, |(i, _)| i);
    }
    Some(Sweep { points, chosen })
}

fn estimate(reading: &Reading, excerpt: &Excerpt, cutoff_hz: f64) -> Option<CutoffAt> {
    // The beginning of a log hardly shows slow covariates.
    let none = vec![0.0; reading.model().parameters().len()];
    let model = &reading.model().with_known_changes(&none);
    // The noise of a velocity grows with the power 1.5 of the cut-off.
    let noise = (cutoff_hz / reading.position_cutoff_hz()).powf(1.5);
    let mut own = reading.with_position_cutoff(cutoff_hz);
    if let Some(weights) = reading.weights() {
        own = own.with_weights(weights.clone().with_noise(noise));
    }
    let system = excerpt.smoothed(&own)?.thinned(reading).reduce(&own)?;
    let hold_out = HoldOut::new(model, &system, HOLD_OUT_PARTS);
    Some(CutoffAt {
        cutoff_hz,
        theta: hold_out.fit_determined()?,
        held_out: hold_out
            .missed_by_fits()
            .and_then(|missed| missed.of_torque_rows()),
    })
}
