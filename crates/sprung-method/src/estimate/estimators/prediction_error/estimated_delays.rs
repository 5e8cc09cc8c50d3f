//! Delays and open Stribeck velocities, by likelihood from several starts.

use sprung_core::friction::Scale;

use super::effects::TorquesTiming;
use super::measurements::{Extent, max_samples};
use super::refine::{Refinery, Start};
use super::refined::Refined;
use super::rung::Rung;
use super::start_levels::TorqueNoise;
use crate::description::{Delay, Estimator};
use crate::estimate::statistics::{MIN_DELAY_SAMPLES, SIGNIFICANT_SIGMAS};
use crate::fit::fit;
use crate::log::LogSource;
use crate::prepare::{DelayByLikelihood, Excerpt, Likely, VelocityByLikelihood, fit_motor_rows};
use crate::progress::{Listener, Phase};
use crate::regression::{PassError, Reading};

/// Further start values of the delays, s. They are tried until two starts lead to the same delays.
/// From each start the search finds delays within about ten milliseconds.
const FURTHER_STARTS_S: [f64; 5] = [5e-3, 1e-2, 2e-2, 3.5e-2, -1e-2];

/// Start values of the Stribeck velocities relative to those by least squares, which are too low,
/// because the filter of the positions smears reversals. They are tried in turn with the delays.
const VELOCITY_STARTS: [f64; 2] = [1.0, 3.0];

/// Two scales of friction laws are equal if they differ by less than this fraction.
const SAME_SCALE_SHARE: f64 = 0.02;

/// Estimates the requested delays and the Stribeck velocities that the description leaves open, by
/// likelihood.
///
/// In the equation of a single joint a link channel that is late by a few milliseconds resembles
/// additional viscous friction. So the search uses the likelihood of the whole robot. It starts
/// from zero delay, from the delays found by least squares and from further delays, until two
/// starts lead to the same values. The values with the greatest likelihood are returned.
///
/// Returns an empty value if no delay or velocity is open, the refinement is not requested or no
/// start converges. Then the values found by least squares are used.
///
/// # Errors
///
/// [`PassError`] if a log cannot be read.
pub(in crate::estimate) fn likely(
    reading: &Reading,
    sources: &mut [LogSource<'_>],
    excerpt: &Excerpt,
    progress: &mut dyn Listener,
) -> Result<Likely, PassError> {
    let channels = reading.channels();
    let estimated: Vec<usize> = (0..channels.all.len())
        .filter(|&i| channels.all[i].delay == Some(Delay::Estimate))
        .collect();
    let open = reading.model().open_stribeck();
    let asked = (reading.settings().estimator).contains(&Estimator::PredictionError);
    if (estimated.is_empty() && open.is_empty())
        || !asked
        || !is_sound(reading, excerpt, &estimated)
    {
        return Ok(Likely::default());
    }
    let mut search = Search {
        reading,
        sources,
        excerpt,
        estimated: &estimated,
        progress,
    };
    let mut found: Vec<Refined> = Vec::new();
    for (delays, factor) in search.starts() {
        let Some(refined) = search.follow(&delays, factor)? else {
            continue;
        };
        let repeated = found
            .iter()
            .any(|other| agree(other, &refined, excerpt.period()));
        found.push(refined);
        if repeated {
            break;
        }
    }
    let converged = found.into_iter().filter(Refined::converged);
    let best = converged.min_by(|a, b| per_measurement(a).total_cmp(&per_measurement(b)));
    let Some(best) = best else {
        return Ok(Likely::default());
    };
    Ok(Likely {
        delays: (best.channels.delays.iter().filter(|delay| delay.estimated))
            .map(|delay| DelayByLikelihood {
                channel: delay.channel,
                delay: delay.value(),
                standard_error: delay.standard_error,
            })
            .collect(),
        velocities: (best.scales.iter())
            .filter(|scale| scale.scale == Scale::Stribeck)
            .map(|scale| VelocityByLikelihood {
                joint: scale.joint,
                velocity: scale.value,
                standard_error: scale.standard_error,
            })
            .collect(),
    })
}

/// Returns whether the joints concerned have positive stiffnesses by least squares. On a faulty log
/// the search takes minutes without a result.
fn is_sound(reading: &Reading, excerpt: &Excerpt, estimated: &[usize]) -> bool {
    fit_motor_rows(excerpt, &reading.without_weights()).is_some_and(|fits| {
        estimated.iter().all(|&i| {
            let joint = reading.channels().all[i].joint;
            fits[joint]
                .stiffness
                .is_none_or(|stiffness| stiffness > 0.0)
        })
    })
}

/// Returns minus the log-likelihood per measurement. A late channel reduces the number of
/// measurements.
fn per_measurement(refined: &Refined) -> f64 {
    refined.search.loss / refined.read.measurements.max(1) as f64
}

fn agree(one: &Refined, other: &Refined, period: f64) -> bool {
    let delays = one.channels.delays.iter().zip(&other.channels.delays);
    let estimated = delays.filter(|(d, _)| d.estimated);
    let same = estimated.into_iter().all(|(a, b)| {
        let difference = (a.assumed + a.correction - b.assumed - b.correction).abs();
        difference < SIGNIFICANT_SIGMAS * a.standard_error.max(MIN_DELAY_SAMPLES * period)
    });
    let scales = one.scales.iter().zip(&other.scales);
    let same_scales = scales
        .into_iter()
        .all(|(a, b)| (a.value / b.value).ln().abs() < SAME_SCALE_SHARE);
    one.converged() && other.converged() && same && same_scales
}

struct Search<'a, 's, 'p> {
    reading: &'a Reading,
    sources: &'a mut [LogSource<'s>],
    excerpt: &'a Excerpt,
    estimated: &'a [usize],
    progress: &'p mut dyn Listener,
}

impl Search<'_, '_, '_> {
    /// Returns the starts in their order: delays of the channels, s, and the factor of the Stribeck
    /// velocities.
    fn starts(&self) -> Vec<(Vec<f64>, f64)> {
        let all = |delay: f64| vec![delay; self.estimated.len()];
        let factors = match self.reading.model().open_stribeck() {
            [] => &VELOCITY_STARTS[..1],
            _ => &VELOCITY_STARTS[..],
        };
        let mut starts: Vec<(Vec<f64>, f64)> =
            factors.iter().map(|&factor| (all(0.0), factor)).collect();
        if self.estimated.is_empty() {
            return starts;
        }
        let delays = self.reading.delays();
        let searched: Vec<f64> = self.estimated.iter().map(|&i| delays[i]).collect();
        if searched != all(0.0) {
            starts.push((searched, 1.0));
        }
        starts.extend(FURTHER_STARTS_S.map(|start| (all(start), 1.0)));
        starts
    }

    /// Refines from the given delays and from the least-squares estimate with these delays.
    ///
    /// - `factor`: of the Stribeck velocities.
    fn follow(&mut self, start: &[f64], factor: f64) -> Result<Option<Refined>, PassError> {
        let mut delays = self.reading.delays().to_vec();
        for (&channel, &delay) in self.estimated.iter().zip(start) {
            delays[channel] = delay;
        }
        let reading = self.reading.with_delays(&delays).without_weights();
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
            delays: self.estimated.to_vec(),
        };
        let beginning = Extent::Beginning(max_samples(reading.model().coordinates()));
        let extent = (Phase::FindingDelays, beginning);
        let refinery = Refinery::new(&reading, self.sources, self.excerpt, &start, extent)?;
        let Some(refinery) = refinery else {
            return Ok(None);
        };
        let end = refinery.climb(Rung::Free, None, self.progress)?;
        Ok(end.map(|end| end.refined))
    }
}
