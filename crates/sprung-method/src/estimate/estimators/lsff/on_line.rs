//! The on-line estimator during the pass over the logs.

use super::recursion::Lsff;
use crate::description::{Estimator, Identify};
use crate::estimate::errors::LsffError;
use crate::estimate::estimators::estimator_result::{Criterion, Found, Numbers};
use crate::finding::{Finding, Severity};
use crate::fit::Fitted;
use crate::model::Model;
use crate::numbers::in_percent;
use crate::preprocess::RawBlock;
use crate::regression::{Observer, Restart};
use crate::stopwatch::Stopwatch;

/// The on-line estimator during the pass over the logs, if it is requested.
pub(in crate::estimate) struct OnLine<'a> {
    model: &'a Model,
    settings: &'a Identify,
    pub(in crate::estimate) lsff: Option<Result<Lsff, LsffError>>,
    // Computing time of LSFF, s.
    pub(in crate::estimate) seconds: f64,
}

impl<'a> OnLine<'a> {
    /// Returns an observer before its first sample.
    pub(in crate::estimate) fn new(model: &'a Model, settings: &'a Identify) -> Self {
        Self {
            model,
            settings,
            lsff: None,
            seconds: 0.0,
        }
    }
}

impl Observer for OnLine<'_> {
    fn restart(&mut self, _: Restart) {
        if let Some(Ok(lsff)) = &mut self.lsff {
            lsff.restart();
        }
    }

    fn raw(&mut self, period: f64, samples: &RawBlock) {
        if !self.settings.estimator.contains(&Estimator::Lsff) {
            return;
        }
        let start = Stopwatch::start();
        let (model, settings) = (self.model, self.settings);
        let lsff = self
            .lsff
            .get_or_insert_with(|| Lsff::new(model, settings, period));
        if let Ok(running) = lsff {
            match running.check_period(period) {
                Ok(()) => running.process(samples),
                Err(error) => *lsff = Err(error),
            }
        }
        self.seconds += start.seconds();
    }

    /// LSFF forgets, so it processes the logs in sequence.
    fn of_one_log(&self) -> Option<Self> {
        (!self.settings.estimator.contains(&Estimator::Lsff))
            .then(|| Self::new(self.model, self.settings))
    }
}

/// Returns the result of LSFF.
///
/// - `elapsed`: computing time, s.
pub(in crate::estimate) fn on_line((lsff, elapsed): &(Lsff, f64), fitted: &Fitted) -> Found {
    let points = lsff.trace().iter();
    Found {
        numbers: Numbers {
            theta: lsff.theta(),
            errors: lsff.wandering(),
            error_parts: Vec::new(),
            // The standard deviation of a running estimate gives no interval.
            interval: f64::INFINITY,
            points: points.map(|(t, x)| (*t, Some(x.clone()))).collect(),
            criterion: Criterion::RecentEquations,
            elapsed: *elapsed,
            ..Numbers::of(fitted)
        },
        findings: about_lsff(lsff),
        unknowns: Vec::new(),
    }
}

fn about_lsff(lsff: &Lsff) -> Vec<Finding> {
    let mut notes = vec![Finding::new(
        Severity::Info,
        "standard-error-is-wandering",
        "the standard errors of LSFF are the standard deviations of the running estimate over its \
         memory; they do not contain the bias by noise of the on-line velocities"
            .to_owned(),
        "use least-squares on filtered positions if the whole log is available",
    )];
    if lsff.paused() > 0.0 {
        notes.push(Finding::new(
            Severity::Warning,
            "wind-up",
            format!(
                "forgetting was paused in {:.0} % of the samples, because directions without \
                 excitation wound the gain matrix up",
                in_percent(lsff.paused())
            ),
            "excite all joints",
        ));
    }
    notes
}
