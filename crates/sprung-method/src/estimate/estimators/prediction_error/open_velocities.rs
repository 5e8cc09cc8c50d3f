//! Open Stribeck velocities, by likelihood from several starts.

use sprung_core::friction::Scale;

use super::effects::TorquesTiming;
use super::measurements::{Extent, max_samples};
use super::refine::{Refinery, Start};
use super::refined::Refined;
use super::rung::Rung;
use super::start_levels::TorqueNoise;
use crate::fit::fit;
use crate::log::LogSource;
use crate::prepare::{Excerpt, VelocityByLikelihood};
use crate::progress::{Listener, Phase};
use crate::regression::{PassError, Reading};

/// Start values of the Stribeck velocities relative to those by least squares, which are too low,
/// because the filter of the positions smears reversals.
const VELOCITY_STARTS: [f64; 2] = [1.0, 3.0];

/// Two scales of friction laws are equal if they differ by less than this fraction.
const SAME_SCALE_SHARE: f64 = 0.02;

/// Estimates the Stribeck velocities that the description leaves open, by likelihood. The search starts from those by least squares
/// and from higher ones, until two starts lead to the same values. The values with the greatest likelihood are returned.
///
/// Returns no velocity if none is open, the refinement is not requested or no start converges.
///
/// # Errors
///
/// [`PassError`] if a log cannot be read.
pub(in crate::estimate) fn likely(
    reading: &Reading,
    sources: &mut [LogSource<'_>],
    excerpt: &Excerpt,
    progress: &mut dyn Listener,
) -> Result<Vec<VelocityByLikelihood>, PassError> {
    let open = reading.model().open_stribeck();
    if open.is_empty() || !reading.is_refined() {
        return Ok(Vec::new());
    }
    let mut search = Search {
        reading,
        sources,
        excerpt,
        progress,
    };
    let mut found: Vec<Refined> = Vec::new();
    for factor in VELOCITY_STARTS {
        let Some(refined) = search.follow(factor)? else {
            continue;
        };
        let repeated = found.iter().any(|other| agree(other, &refined));
        found.push(refined);
        if repeated {
            break;
        }
    }
    let converged = found.into_iter().filter(Refined::converged);
    let best = converged.min_by(|a, b| per_measurement(a).total_cmp(&per_measurement(b)));
    let scales = best.iter().flat_map(|best| &best.scales);
    let velocities = scales.filter(|scale| scale.scale == Scale::Stribeck);
    Ok(velocities
        .map(|scale| VelocityByLikelihood {
            joint: scale.joint,
            velocity: scale.value,
            standard_error: scale.standard_error,
        })
        .collect())
}

/// Returns minus the log-likelihood per measurement. A late channel reduces the number of
/// measurements.
fn per_measurement(refined: &Refined) -> f64 {
    refined.search.loss / refined.read.measurements.max(1) as f64
}

fn agree(one: &Refined, other: &Refined) -> bool {
    let mut scales = one.scales.iter().zip(&other.scales);
    let same = scales.all(|(a, b)| (a.value / b.value).ln().abs() < SAME_SCALE_SHARE);
    one.converged() && other.converged() && same
}

struct Search<'a, 's, 'p> {
    reading: &'a Reading,
    sources: &'a mut [LogSource<'s>],
    excerpt: &'a Excerpt,
    progress: &'p mut dyn Listener,
}

impl Search<'_, '_, '_> {
    /// Refines from other Stribeck velocities and from the least-squares estimate with them.
    ///
    /// - `factor`: of the Stribeck velocities.
    fn follow(&mut self, factor: f64) -> Result<Option<Refined>, PassError> {
        let reading = self.reading.without_weights();
        let model = reading.model();
        let faster = (model.open_stribeck().iter()).fold(model.clone(), |faster, &joint| {
            faster.with_stribeck(joint, factor * model.stribeck_velocity(joint))
        });
        let reading = reading.with_model(faster);
        let model = reading.model();
        let Some(fitted) = (self.excerpt.reduce(&reading))
            .and_then(|system| fit(model, &system, reading.memory()))
        else {
            return Ok(None);
        };
        if !fitted.theta.iter().all(|value| value.is_finite()) {
            return Ok(None);
        }
        let parameters = model.parameters().iter().zip(&fitted.identifiable);
        let free = (parameters.enumerate())
            .filter(|(_, (parameter, known))| **known && parameter.fixed.is_none())
            .map(|(i, _)| i);
        let start = Start {
            theta: &fitted.theta,
            free: free.collect(),
            torque_noise: TorqueNoise::of(reading.channels(), self.excerpt.period()),
            torques: TorquesTiming::Given,
            delays: Vec::new(),
        };
        let beginning = Extent::Beginning(max_samples(reading.model().coordinates()));
        let extent = (Phase::FindingVelocities, beginning);
        let refinery = Refinery::new(&reading, self.sources, self.excerpt, &start, extent)?;
        let Some(refinery) = refinery else {
            return Ok(None);
        };
        let end = refinery.climb(Rung::Free, None, self.progress)?;
        Ok(end.map(|end| end.refined))
    }
}
