//! Watches logs of a running robot.

use std::path::PathBuf;

use super::error::SessionError;
use super::export::result_of;
use super::load::Session;
use super::logs::Logs;
use super::parameters::Parameters;
use sprung_base::progress::Listener;
use sprung_log::LogSource;
use sprung_method::estimate::Verdict;
use sprung_method::watch::{WatchEvent, WatchTask, Watched, watch};

/// What is watched.
#[derive(Clone, Debug, PartialEq)]
pub struct WatchRequest {
    /// False alarms that all joints together may have in an hour.
    pub false_alarms_per_h: f64,
    /// Index of the result, one for each estimator of the identification.
    pub set: usize,
    /// Whether values whose verdict is *unusable* are taken as well.
    pub accept_unusable: bool,
    /// Time without growth after which a file ends, s; `None` for complete files.
    pub follow_s: Option<f64>,
}

impl Default for WatchRequest {
    /// One false alarm an hour, with the first result.
    fn default() -> Self {
        Self {
            false_alarms_per_h: 1.0,
            set: 0,
            accept_unusable: false,
            follow_s: None,
        }
    }
}

impl Session {
    /// Watches files with the columns of the experiment's log; `-` is the standard input.
    ///
    /// - `parameters`: those of an identification; the experiment's logs are those of the healthy robot.
    /// - `tell`: is called with each event as soon as it has ended.
    ///
    /// # Errors
    ///
    /// [`SessionError`] if a description or a log is wrong, or the values are unusable.
    pub fn watch(
        &self,
        parameters: &Parameters,
        files: &[PathBuf],
        request: &WatchRequest,
        tell: &mut dyn FnMut(&WatchEvent),
        progress: &mut dyn Listener,
    ) -> Result<Watched, SessionError> {
        let mut logs = self.other_logs(files, request.follow_s);
        let given = (None, &mut *logs.sources());
        self.watch_with(parameters, given, request, tell, progress)
    }

    /// Watches other logs.
    ///
    /// - `healthy`: logs of the robot as it was identified, those of the experiment if absent; `watched`: the logs to watch.
    ///
    /// # Errors
    ///
    /// The errors of [`watch`](Self::watch).
    pub fn watch_with(
        &self,
        parameters: &Parameters,
        (healthy, watched): (Option<&mut [LogSource<'_>]>, &mut [LogSource<'_>]),
        request: &WatchRequest,
        tell: &mut dyn FnMut(&WatchEvent),
        progress: &mut dyn Listener,
    ) -> Result<Watched, SessionError> {
        let found = (parameters.identification.as_ref()).ok_or(SessionError::NoPosterior)?;
        let result = result_of(found, request.set)?;
        if result.verdict == Verdict::Unusable && !request.accept_unusable {
            return Err(SessionError::UnusableResult {
                estimator: result.estimator.clone(),
                because: result.decision.because.clone(),
            });
        }
        let (mut experiment, model) = self.described_by(parameters)?;
        found.log.settle(&mut experiment);
        let set = &parameters.sets[request.set];
        let task = WatchTask {
            experiment: &experiment,
            model: &model,
            set,
            result,
            chosen: &parameters.chosen(),
            false_alarms_per_h: request.false_alarms_per_h,
        };
        if let Some(healthy) = healthy {
            return Ok(watch(&task, healthy, watched, tell, progress)?);
        }
        let mut healthy: Logs<'_> = self.logs(None)?;
        Ok(watch(
            &task,
            &mut healthy.sources(),
            watched,
            tell,
            progress,
        )?)
    }
}
