//! Estimates from the parts of the logs, compared with each other.

use crate::estimate::result::PartResult;
use crate::fit::{Fitted, PartFit, fit_of_log, fits_of_quarters};
use crate::model::Model;
use crate::regression::System;

/// Estimates from parts of the logs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Parts {
    /// Whether each part is one log.
    pub(crate) are_logs: bool,
    /// The parts in their order: first and last time, s, and the estimate.
    parts: Vec<([f64; 2], PartFit)>,
}

impl Parts {
    /// Estimates the parameters from each of several logs, or from the quarters of one log.
    ///
    /// - `(system, spans)`: the reduced logs, and first and last time of each log, s.
    pub(crate) fn new(
        model: &Model,
        (system, spans): (&System, &[[f64; 2]]),
        fitted: &Fitted,
    ) -> Self {
        if let [span] = spans {
            let fits = fits_of_quarters(model, fitted);
            let length = (span[1] - span[0]) / fits.len().max(1) as f64;
            let at = |i: usize| [i, i + 1].map(|i| span[0] + i as f64 * length);
            return Self {
                are_logs: false,
                parts: (fits.into_iter().enumerate())
                    .map(|(i, fit)| (at(i), fit))
                    .collect(),
            };
        }
        let model = &model.with_known_changes(&fitted.theta);
        Self {
            are_logs: true,
            parts: (spans.iter().enumerate())
                .filter_map(|(log, span)| Some((*span, fit_of_log(model, system, log, fitted)?)))
                .collect(),
        }
    }

    /// Returns value and standard error of a parameter from each part; `None` if fewer than two
    /// parts determine it.
    pub(crate) fn of(&self, index: usize) -> Option<Vec<(f64, f64)>> {
        let values: Vec<(f64, f64)> = (self.parts.iter())
            .filter_map(|(_, fit)| fit.values[index])
            .collect();
        (values.len() >= 2).then_some(values)
    }

    /// Returns value and standard error of a parameter from each part, with larger errors, since
    /// those of a part come from few segments.
    pub(crate) fn cautious(&self, index: usize) -> Option<Vec<(f64, f64)>> {
        let values: Vec<(f64, f64)> = (self.parts.iter())
            .filter_map(|(_, fit)| {
                let (value, error) = fit.values[index]?;
                Some((value, fit.error_factor() * error))
            })
            .collect();
        (values.len() >= 2).then_some(values)
    }

    /// Returns the parts in the form of the results.
    pub(crate) fn described(&self) -> Vec<PartResult> {
        (self.parts.iter())
            .map(|(span, fit)| PartResult {
                from_s: span[0],
                to_s: span[1],
                values: fit.values.clone(),
            })
            .collect()
    }
}
