//! The estimators, selected by name.

use super::describe::Linear;
use super::error::IdentifyError;
use super::found::{Criterion, Found};
use super::inputs::EstimatorInputs;
use super::least_squares::least_squares;
use super::lsff::Lsff;
use super::on_line::on_line;
use super::output_error::output_error;
use super::prediction_error::{Before, prediction_error};
use crate::description::Estimator;
use crate::finding::{Finding, Severity};
use crate::frequency::Record;
use crate::log::LogSource;
use crate::prepare::{PrepareError, Prepared};
use crate::progress::Listener;
use crate::regression::System;

/// Inputs of the estimators.
pub(super) struct Basis<'a> {
    pub(super) prepared: &'a Prepared,
    pub(super) system: &'a System,
    /// Result of least squares. Other estimators start from it and return it if they fail.
    pub(super) linear: &'a Linear,
    /// Time spent on reading the logs and on the fit, s.
    pub(super) fit_seconds: f64,
    /// The on-line estimator if it ran, and its computing time, s.
    pub(super) lsff: Option<(&'a Lsff, f64)>,
    pub(super) inputs: &'a EstimatorInputs<'a>,
    /// Findings about the logs.
    pub(super) about_logs: &'a [Finding],
    /// Samples of the logs for spectra.
    pub(super) record: &'a Record,
}

impl Basis<'_> {
    /// Runs one estimator. Every estimator has an arm here.
    ///
    /// # Errors
    ///
    /// [`IdentifyError`] if a log cannot be read again or the caller stops the run.
    pub(super) fn run(
        &self,
        estimator: Estimator,
        sources: &mut [LogSource<'_>],
        progress: &mut dyn Listener,
    ) -> Result<Found, IdentifyError> {
        let (reading, excerpt) = (self.prepared.reading(), self.prepared.excerpt());
        let fitted = &self.linear.fitted;
        Ok(match estimator {
            Estimator::LeastSquares => {
                least_squares(reading.model(), self.system, fitted, self.fit_seconds)
            }
            Estimator::Lsff => on_line(self.lsff.ok_or(PrepareError::NoLog)?, fitted),
            Estimator::OutputError => {
                let controller = self.inputs.controller.ok_or(PrepareError::NoLog)?;
                output_error(reading, controller, excerpt, fitted, progress)?
            }
            Estimator::PredictionError if sources.iter().any(|own| own.payload().is_some()) => {
                let mut found =
                    least_squares(reading.model(), self.system, fitted, self.fit_seconds);
                found.numbers.criterion = Criterion::Likelihood(None);
                found.findings.push(payload_not_refined());
                found
            }
            Estimator::PredictionError => {
                let before = Before {
                    experiment: self.prepared.experiment(),
                    excerpt,
                    system: self.system,
                    fitted,
                    nominal: self.inputs.nominal.as_deref(),
                    about_logs: self.about_logs,
                };
                prediction_error(reading, sources, before, progress)?
            }
        })
    }
}

fn payload_not_refined() -> Finding {
    Finding::new(
        Severity::Info,
        "payload-not-refined",
        "some logs carried a known payload, and the refinement follows one robot for all logs. These are \
         the values of least squares"
            .to_owned(),
        "to refine them, identify the logs without payload alone",
    )
}
