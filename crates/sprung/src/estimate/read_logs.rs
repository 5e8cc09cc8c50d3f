//! The logs after they were read once: their equations and figures.

use super::about_logs::{LogInfo, log_names};
use crate::check::OfLog;
use crate::prepare::Prepared;
use crate::regression::{Passed, System};

/// The logs of one robot after they were read once.
pub(super) struct ReadLogs {
    /// The reduced system of all logs.
    pub(super) system: System,
    /// First and last time of each log on their common time axis, s.
    pub(super) spans: Vec<[f64; 2]>,
    /// Figures of each log.
    pub(super) infos: Vec<LogInfo>,
    /// Findings about each log alone.
    pub(super) examined: Vec<OfLog>,
}

impl ReadLogs {
    /// Returns the logs of a pass.
    pub(super) fn new(prepared: &Prepared, passed: Passed) -> Self {
        let log = prepared.experiment().log.as_ref();
        Self {
            infos: (passed.logs.iter().zip(&log_names(log, prepared.names())))
                .map(|(figures, name)| LogInfo::of(name, figures))
                .collect(),
            examined: OfLog::of_each(prepared, &passed.logs),
            system: passed.system,
            spans: passed.spans,
        }
    }
}
