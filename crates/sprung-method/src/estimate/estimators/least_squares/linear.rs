//! Least squares of all logs, with its checks.

use super::cross_checks::{Route, cross_checks};
use super::held_out_ratio::HeldOutRatio;
use super::parts::Parts;
use super::uncertainty::widened;
use crate::fit::{Fitted, fit, residual};
use crate::model::Theta;
use crate::prepare::Prepared;
use crate::regression::System;

/// Result of least squares, which stands beside other results.
pub(in crate::estimate) struct Linear {
    /// The fit of all logs. Its standard errors contain the bias and the changes between parts.
    pub(in crate::estimate) fitted: Fitted,
    /// Other routes to the parameters.
    pub(in crate::estimate) routes: Vec<(Route, Theta)>,
    /// Estimates from parts of the logs.
    pub(in crate::estimate) parts: Parts,
    /// Held-out over fitted error of each row.
    pub(in crate::estimate) held_out: HeldOutRatio,
}

impl Linear {
    /// Solves the regression of all logs by least squares, by other routes and from parts of the logs;
    /// returns `None` if the regression or its solution is not finite.
    ///
    /// - `(system, spans)`: the reduced logs, and first and last time of each log, s.
    pub(in crate::estimate) fn new(
        prepared: &Prepared,
        (system, spans): (&System, &[[f64; 2]]),
    ) -> Option<Self> {
        let model = prepared.reading().model();
        let is_finite = |fitted: &Fitted| {
            let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
            finite(&fitted.theta)
                && finite(&fitted.standard_error)
                && (residual(model, system, &fitted.theta).iter())
                    .all(|row| row.0.is_finite() && row.1.is_finite())
        };
        let fitted = fit(model, system, prepared.reading().memory()).filter(is_finite)?;
        let routes = cross_checks(model, system);
        let parts = Parts::new(model, (system, spans), &fitted);
        Some(Self {
            held_out: HeldOutRatio::new(model, system, &fitted.theta),
            fitted: widened(prepared, fitted, &routes, &parts),
            routes,
            parts,
        })
    }
}
