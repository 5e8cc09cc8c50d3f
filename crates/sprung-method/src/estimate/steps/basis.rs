//! Values that the steps pass to each other.

use super::pass::ReadLogs;
use super::prepare::Ready;
use crate::check::{UNEXPLAINED, beyond_resolution};
use crate::description::Estimator;
use crate::estimate::estimators::Found;
use crate::estimate::estimators::least_squares::{Linear, least_squares};
use crate::estimate::estimators::prediction_error::Timing;
use crate::estimate::result::PayloadResult;
use crate::estimate::springs::Undetermined;
use crate::estimate::sums::Sums;
use crate::finding::Finding;
use crate::fit::relative_residuals;
use crate::log::LogSource;
use crate::unknowns::{Kind, UnknownResult, UnknownStatus};

/// The logs of a robot.
pub(in crate::estimate) struct Logs<'a, 's> {
    /// Logs for the parameters of the robot.
    pub(in crate::estimate) of_robot: &'a mut [LogSource<'s>],
    /// Logs with an unknown payload.
    pub(in crate::estimate) loaded: &'a mut [LogSource<'s>],
}

impl<'a, 's> Logs<'a, 's> {
    /// Sorts logs by their purpose.
    pub(in crate::estimate) fn new(sources: &'a mut [LogSource<'s>]) -> Self {
        sources.sort_by_key(LogSource::has_unknown_payload);
        let count = sources.partition_point(|source| !source.has_unknown_payload());
        let (of_robot, loaded) = sources.split_at_mut(count);
        Self { of_robot, loaded }
    }
}

/// Results of the steps before the estimators.
pub(in crate::estimate) struct Basis<'a> {
    pub(in crate::estimate) ready: &'a Ready,
    pub(in crate::estimate) read: &'a ReadLogs,
    /// Findings about the logs.
    pub(in crate::estimate) findings: &'a [Finding],
    /// Springs that the logs do not determine.
    pub(in crate::estimate) springs: &'a Undetermined,
    /// Parameters of which the logs show only sums.
    pub(in crate::estimate) sums: &'a Sums,
    /// Result of least squares. Other estimators start from it and return it if they fail.
    pub(in crate::estimate) linear: &'a Linear<'a>,
    /// Whether the refinement may return another timing of the torques, or has found it.
    pub(in crate::estimate) timing: Timing<'a>,
    /// Time spent on reading the logs and on the fit, s.
    pub(in crate::estimate) fit_seconds: f64,
}

/// Largest residual of the torques over them, root mean square, with which rigid joints are refined by default. Of robots
/// that leave more, laws of friction are missing, so that a refinement is discarded. Rigid arms of others leave 2 to 14 %.
/// Flexible joints are refined up to [`UNEXPLAINED`]: above it the refinement of an industrial arm took over 15 minutes.
const EXPLAINED: f64 = 0.015;

impl Basis<'_> {
    /// Returns the estimators that the settings name, or those of this robot: no refinement where least squares leave too
    /// much of a torque unexplained, or where a factor contradicts the equations, which no disturbance explains.
    pub(in crate::estimate) fn estimators(&self) -> &[Estimator] {
        let reading = self.ready.prepared.reading();
        let (model, theta) = (reading.model(), &self.linear.fitted.theta);
        let system = &self.read.system;
        let residuals = relative_residuals(model, system, theta);
        let has_springs = model.has_springs();
        let limit = if has_springs { UNEXPLAINED } else { EXPLAINED };
        let is_explained = (residuals.into_iter().enumerate()).all(|(row, relative)| {
            let share = system.kept().transition_share(row).filter(|_| has_springs);
            relative.is_none_or(|all| beyond_resolution(all, share.unwrap_or(0.0)) <= limit)
        });
        let is_contradicted = self.ready.unknowns.iter().any(is_wrong_factor);
        let refines = reading.can_refine() && is_explained && !is_contradicted;
        reading.settings().estimators(refines)
    }

    /// Returns the result of least squares as an estimator.
    pub(super) fn least_squares(&self) -> Found {
        let model = self.ready.prepared.reading().model();
        least_squares(model, &self.read.system, self.linear, self.fit_seconds)
    }
}

/// Returns whether a log shows a wrong factor of a column or of the time, which all results contain.
fn is_wrong_factor(unknown: &UnknownResult) -> bool {
    let is_factor = [Kind::Gain, Kind::TimeScale]
        .map(Kind::name)
        .contains(&unknown.kind.as_str());
    is_factor && unknown.status == UnknownStatus::Found
}

/// Results of the estimators.
pub(in crate::estimate) struct Estimates {
    /// The parameters of the robot, in the order of the estimators.
    pub(in crate::estimate) robot: Vec<(Estimator, Found)>,
    /// Payloads, each with its findings.
    pub(in crate::estimate) payloads: Vec<(PayloadResult, Vec<Finding>)>,
}
