//! Least squares of all logs, with its checks.

use super::band::half_below;
use super::cross_checks::{Route, cross_checks};
use super::held_out::{HeldOut, Price};
use super::nuisances::nuisances;
use super::parts::Parts;
use super::possible::{Contradicted, PossibleFit};
use super::uncertainty::widened;
use crate::description::Constraints;
use crate::estimate::errors::IdentifyError;
use crate::estimate::estimators::estimator_result::Numbers;
use crate::estimate::possible::Tool;
use crate::fit::{Fitted, HoldOut, fit_values, fit_weighted, residual, row_weights};
use crate::model::{Model, Theta};
use crate::prepare::{Prepared, rms_speeds};
use crate::regression::System;

/// Peak of a motion over its root mean square: between that of a sine and that of normal noise.
const PEAK: f64 = 2.0;

/// Result of least squares, the reference of other results.
pub(in crate::estimate) struct Linear<'a> {
    /// The fit of all logs, over robots that can exist by default. Its standard errors contain the bias and the changes
    /// between parts, and are those without constraints.
    pub(in crate::estimate) fitted: Fitted,
    /// The robots that can exist; `None` without constraints.
    pub(in crate::estimate) possible: Option<PossibleFit<'a>>,
    /// Largest speed of each joint in the log, rad/s (m/s), \[n\].
    pub(in crate::estimate) speeds: Vec<f64>,
    /// Frequency below which half of the change by the constraints lies, for each torque with a high price, Hz, \[n\].
    pub(in crate::estimate) bands: Vec<Option<f64>>,
    /// Limits of masses that the logs contradict.
    pub(in crate::estimate) contradicted: Option<Contradicted>,
    /// Other routes to the parameters.
    pub(in crate::estimate) routes: Vec<(Route, Theta)>,
    /// Estimates from parts of the logs.
    pub(in crate::estimate) parts: Parts,
    /// Errors of fits on held-out parts of the logs.
    pub(in crate::estimate) held_out: HeldOut,
}

impl<'a> Linear<'a> {
    /// Solves the regression of all logs by least squares, by other methods and from parts of the logs.
    ///
    /// - `(system, spans)`: the reduced logs, and first and last time of each log, s.
    /// - `is_timed`: whether a refinement has found the timing of the torques and the sharpness of Coulomb friction.
    ///
    /// # Errors
    ///
    /// [`IdentifyError::NotFinite`] if the regression or its solution is not finite, [`IdentifyError::NoRobot`] if given
    /// values and limits exclude each other.
    pub(in crate::estimate) fn new(
        prepared: &'a Prepared,
        (system, spans): (&System, &[[f64; 2]]),
        is_timed: bool,
    ) -> Result<Self, IdentifyError> {
        let not_finite = || IdentifyError::NotFinite {
            file: prepared.names().join(", "),
        };
        let (reading, excerpt) = (prepared.reading(), prepared.excerpt());
        let (model, settings) = (reading.model(), reading.settings());
        let is_finite = |fitted: &Fitted| {
            let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
            finite(&fitted.theta)
                && finite(&fitted.standard_error)
                && (residual(model, system, &fitted.theta).iter())
                    .all(|row| row.0.is_finite() && row.1.is_finite())
        };
        let weights = match settings.constraints {
            Constraints::None => vec![1.0; model.rows()],
            Constraints::Possible => {
                let values = fit_values(model, system).ok_or_else(not_finite)?;
                row_weights(model, system, &values)
            }
        };
        let fitted = fit_weighted(model, system, reading.memory(), weights.clone())
            .filter(is_finite)
            .ok_or_else(not_finite)?;
        let routes = cross_checks(model, system);
        let parts = Parts::new(model, (system, spans), &fitted);
        let nuisances = (!is_timed)
            .then(|| nuisances(prepared, fitted.weights()))
            .flatten();
        let mut fitted = widened(prepared, fitted, (&routes, nuisances.as_deref()), &parts);
        let speeds: Vec<f64> = (rms_speeds(reading, excerpt).into_iter())
            .map(|speed| PEAK * speed)
            .collect();
        let constrained = |tool: Tool| {
            let possible = match settings.constraints {
                Constraints::None => None,
                Constraints::Possible => {
                    let motion = (speeds.as_slice(), tool);
                    PossibleFit::new(model, &settings.physical, system, &fitted, motion)
                }
            };
            Constrained::new((model, system), &weights, &fitted.theta, possible)
        };
        let (mut result, mut tool) = (constrained(Tool::InRegion)?, Tool::InRegion);
        if result.is_dear(model) {
            // A tool may be longer than the region of its link.
            let other = constrained(Tool::Anywhere)?;
            if other.held_out.error() < result.held_out.error() {
                (result, tool) = (other, Tool::Anywhere);
            }
        }
        let Constrained {
            theta,
            possible,
            held_out,
        } = result;
        fitted.theta = theta;
        let band = |joint: usize| {
            let row = model.torque_row(joint);
            held_out.price(row).filter(Price::is_dear)?;
            half_below(
                prepared,
                row,
                [&fitted.theta, &possible.as_ref()?.unconstrained],
            )
        };
        Ok(Self {
            bands: (0..model.joint_count()).map(band).collect(),
            contradicted: possible
                .as_ref()
                .and_then(|possible| possible.contradicted(&settings.physical, (&speeds, tool))),
            speeds,
            fitted,
            possible,
            routes,
            parts,
            held_out,
        })
    }
}

/// An estimate under constraints.
struct Constrained<'a> {
    theta: Theta,
    /// `None` without constraints.
    possible: Option<PossibleFit<'a>>,
    held_out: HeldOut,
}

impl<'a> Constrained<'a> {
    /// - `weights`: of rows, \[rows\]; `plain`: the fit without constraints, \[p\].
    ///
    /// # Errors
    ///
    /// [`IdentifyError::NoRobot`].
    fn new(
        (model, system): (&Model, &System),
        weights: &[f64],
        plain: &[f64],
        possible: Option<PossibleFit<'a>>,
    ) -> Result<Self, IdentifyError> {
        let best = (possible.as_ref().map(PossibleFit::best).transpose())
            .map_err(IdentifyError::NoRobot)?;
        let is_moved = best.as_ref().is_some_and(|best| *best != plain);
        let theta = best.unwrap_or_else(|| plain.to_vec());
        let without_each = (possible.as_ref().filter(|_| is_moved)).map(|possible| {
            |hold_out: &HoldOut<'_>, fits: &[Theta]| possible.without_each(hold_out, fits)
        });
        Ok(Self {
            held_out: HeldOut::new((model, system), weights, &theta, without_each),
            theta,
            possible,
        })
    }

    /// Returns whether the price of the constraints is too high in the torque of a joint of a tree.
    fn is_dear(&self, model: &Model) -> bool {
        let prices = (0..model.joint_count())
            .filter_map(|joint| self.held_out.price(model.torque_row(joint)));
        model.tree().is_some() && prices.into_iter().any(|price| price.is_dear())
    }
}

/// Returns the numbers of least squares. They are the result where a refinement fails.
///
/// - `possible`: the robots that can exist; `None` without constraints.
pub(in crate::estimate) fn linear_numbers(
    fitted: &Fitted,
    possible: Option<&PossibleFit<'_>>,
) -> Numbers {
    Numbers {
        unconstrained: possible.map(|possible| possible.unconstrained.clone()),
        ..Numbers::of(fitted)
    }
}
