//! The second step: reads the logs once and reduces them to their equations and figures.

use super::log_info::log_names;
use super::prepare::Ready;
use crate::check::OfLog;
use crate::estimate::errors::IdentifyError;
use crate::estimate::estimators::lsff::Lsff;
use crate::estimate::estimators::lsff::OnLine;
use crate::estimate::result::LogInfo;
use crate::frequency::Record;
use crate::log::LogSource;
use crate::progress::{Listener, Phase};
use crate::regression::{System, read_through};

/// The logs of one robot after they were read once.
pub(in crate::estimate) struct ReadLogs {
    /// The reduced system of all logs.
    pub(in crate::estimate) system: System,
    /// First and last time of each log on their common time axis, s.
    pub(in crate::estimate) spans: Vec<[f64; 2]>,
    /// Figures of each log.
    pub(in crate::estimate) infos: Vec<LogInfo>,
    /// Findings about each log alone.
    pub(in crate::estimate) examined: Vec<OfLog>,
    /// The on-line estimator if it ran, and its computing time, s.
    pub(in crate::estimate) lsff: Option<(Lsff, f64)>,
    /// Samples of the logs for spectra.
    pub(in crate::estimate) record: Record,
}

/// Reads the logs once and feeds every consumer of samples.
///
/// # Errors
///
/// [`IdentifyError`] if a log cannot be read or does not fit the filters, or the caller stops the run.
pub(in crate::estimate) fn pass(
    ready: &Ready,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<ReadLogs, IdentifyError> {
    let prepared = &ready.prepared;
    let (reading, log) = (prepared.reading(), prepared.experiment().log.as_ref());
    let (model, channels) = (reading.model(), reading.channels());
    let names = log_names(log, prepared.names());
    let labels: Vec<String> = sources.iter().map(LogSource::label).collect();
    let on_line = OnLine::new(model, reading.settings());
    let mut observers = (on_line, Record::new(model.joint_count()));
    let passed = read_through(reading, sources, &mut observers, Phase::Reading, progress)?;
    let (on_line, record) = observers;
    let lsff = on_line.lsff.transpose()?;
    let logs = passed.logs.iter();
    Ok(ReadLogs {
        infos: (logs.clone().zip(&names))
            .map(|(figures, name)| LogInfo::of(name, figures))
            .collect(),
        examined: (logs.zip(&labels))
            .map(|(figures, label)| OfLog::new(label, channels, model, figures))
            .collect(),
        system: passed.system,
        spans: passed.spans,
        lsff: lsff.map(|lsff| (lsff, on_line.seconds)),
        record,
    })
}
