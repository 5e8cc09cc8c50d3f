//! Least squares of all logs, with its checks.

use super::cross_checks::{Route, cross_checks};
use super::held_out_ratio::HeldOutRatio;
use super::parts::Parts;
use super::possible::possible;
use super::uncertainty::widened;
use crate::description::{Constraints, Physical};
use crate::fit::{Fitted, fit, fit_weighted, residual, row_weights};
use crate::model::{Model, Theta};
use crate::prepare::{Prepared, rms_speeds};
use crate::regression::System;

/// Peak of a motion over its root mean square: between that of a sine and that of normal noise.
const PEAK: f64 = 2.0;

/// Result of least squares, which stands beside other results.
pub(in crate::estimate) struct Linear {
    /// The fit of all logs, over robots that can exist unless the settings say otherwise. Its standard errors contain
    /// the bias and the changes between parts.
    pub(in crate::estimate) fitted: Fitted,
    /// Parameters of the same equations without constraints, \[p\]; `None` if there are none in the settings.
    pub(in crate::estimate) unconstrained: Option<Theta>,
    /// Largest speed of each joint, rad/s (m/s), \[n\].
    pub(in crate::estimate) speeds: Vec<f64>,
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
        let (reading, excerpt) = (prepared.reading(), prepared.excerpt());
        let settings = reading.settings();
        let plain = fit(model, system, reading.memory()).filter(is_finite)?;
        let held_out = HeldOutRatio::new(model, system, &plain.theta);
        let fitted = match settings.constraints {
            Constraints::None => plain,
            Constraints::Possible => {
                let weights = row_weights(model, system, &plain.theta);
                fit_weighted(model, system, reading.memory(), weights).filter(is_finite)?
            }
        };
        let routes = cross_checks(model, system);
        let parts = Parts::new(model, (system, spans), &fitted);
        let fitted = widened(prepared, fitted, &routes, &parts);
        let speeds: Vec<f64> = (rms_speeds(reading, excerpt).into_iter())
            .map(|speed| PEAK * speed)
            .collect();
        let mut linear = Self {
            held_out,
            fitted,
            unconstrained: None,
            speeds,
            routes,
            parts,
        };
        match settings.constraints {
            Constraints::None => (),
            Constraints::Possible => linear.constrain(model, &settings.physical, system),
        }
        Some(linear)
    }

    /// Replaces the parameters by those of the best robot that can exist. Limits that contradict each other leave them;
    /// a finding about the bodies of the result names the limits.
    fn constrain(&mut self, model: &Model, settings: &Physical, system: &System) {
        if let Some(theta) = possible(model, settings, system, &self.fitted, &self.speeds) {
            self.unconstrained = Some(std::mem::replace(&mut self.fitted.theta, theta));
        }
    }
}
