//! The ladder: refinements that attribute less and less to slow disturbances, and the choice among
//! them by cross-validation.
//!
//! On a log with model error the likelihood attributes this error to slow disturbances, and then
//! only fast motions determine the parameters. A lower rung does not have this freedom.

use super::before::Before;
use super::hold_out::{Folds, HeldOut};
use super::refine::{End, Refinery};
use super::refined::Refined;
use super::retiming::{Retiming, Timing};
use super::rung::Rung;
use crate::estimate::statistics::SMALL_SHARE;
use crate::progress::Listener;
use crate::regression::PassError;

/// Held-out residuals whose ratio is below this value are equal; the earlier rung is used.
const TIE: f64 = 1.02;

/// A rung that was tried.
pub(super) struct Tried {
    pub(super) rung: Rung,
    /// Its end; `None` if the filter did not follow the log.
    pub(super) end: Option<End>,
    pub(super) held_out: Option<HeldOut>,
}

impl Tried {
    /// Returns its result; `None` if the filter did not follow the log.
    pub(super) fn refined(&self) -> Option<&Refined> {
        self.end.as_ref().map(|end| &end.refined)
    }

    /// Returns the held-out ratio if the rung can be used. If no fold can be left out, the ratio
    /// counts as 1.
    pub(super) fn passed(&self) -> Option<f64> {
        let refined = self.refined()?;
        let ratio = self.held_out.map_or(1.0, HeldOut::ratio);
        let sound = refined.converged() && !refined.at_bound();
        (sound && ratio <= 1.0 + SMALL_SHARE).then_some(ratio)
    }
}

/// End of the ladder.
pub(super) enum Climbed {
    /// The rungs that were tried.
    Tried(Vec<Tried>),
    /// The likelihood shows another timing.
    Retimed(Box<Retiming>),
}

/// Tries the rungs one after the other, until a rung passes clearly or shows another timing.
///
/// - `progress`: is called before each run of the filter.
///
/// # Errors
///
/// [`PassError`] if the filter of positions does not fit a log, or the listener requests a stop.
pub(super) fn climb(
    refinery: &Refinery<'_>,
    before: &Before<'_>,
    progress: &mut dyn Listener,
) -> Result<Climbed, PassError> {
    let mut tried: Vec<Tried> = Vec::new();
    let model = refinery.reading.model();
    let warm = match before.timing {
        Timing::Found(retiming) => retiming.end.as_ref(),
        Timing::Open => None,
    };
    let is_open = matches!(before.timing, Timing::Open);
    let mut folds: Option<Folds<'_>> = None;
    for rung in Rung::ALL {
        // A rung that predicts badly is a bad start.
        let from = (tried.last())
            .filter(|last| last.passed().is_some())
            .and_then(|last| last.end.as_ref());
        let from = from.or_else(|| warm.filter(|_| tried.is_empty()));
        let mut end = refinery.climb(rung, from, progress)?;
        if is_open
            && let Some(found) = &end
            && let Some(retiming) = refinery.retiming((rung, found), before.experiment)?
            && let Some(end) = end.take()
        {
            return Ok(Climbed::Retimed(Box::new(
                retiming.with(end, refinery.reading),
            )));
        }
        if folds.is_none()
            && let Some(end) = &end
        {
            folds = Folds::new(model, before.system, &end.refined, refinery.possible);
        }
        let held_out =
            (folds.as_ref().zip(end.as_ref())).map(|(folds, end)| folds.compare(&end.refined));
        tried.push(Tried {
            rung,
            end,
            held_out,
        });
        if is_enough(&tried) || refinery.has_run_enough() {
            break;
        }
    }
    Ok(Climbed::Tried(tried))
}

/// Returns whether the last rung predicts at least as well as least squares, so no further rung is
/// needed.
fn is_enough(tried: &[Tried]) -> bool {
    let ratio = tried.last().and_then(Tried::passed);
    ratio.is_some_and(|ratio| ratio <= 1.0)
}

/// Returns the index of the rung that is used: of the rungs whose held-out residual is at most
/// 1.05 times that of least squares, the one with the least residual; of nearly equal ones the
/// earliest. `None` if least squares stands.
pub(super) fn choose(tried: &[Tried]) -> Option<usize> {
    let ratios: Vec<Option<f64>> = tried.iter().map(Tried::passed).collect();
    let least = ratios
        .iter()
        .flatten()
        .copied()
        .fold(f64::INFINITY, f64::min);
    ratios
        .iter()
        .position(|ratio| ratio.is_some_and(|ratio| ratio <= TIE * least))
}

/// Returns the index of the rung to describe if none is used: the one with the least held-out
/// residual, else the last one with a result.
pub(super) fn nearest(tried: &[Tried]) -> Option<usize> {
    let ratio = |tried: &Tried| tried.held_out.map_or(f64::INFINITY, HeldOut::ratio);
    (tried.iter().enumerate().rev())
        .filter(|(_, tried)| tried.end.is_some())
        .min_by(|(_, a), (_, b)| ratio(a).total_cmp(&ratio(b)))
        .map(|(index, _)| index)
}
