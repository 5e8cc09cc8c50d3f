//! The second step: reads the logs once and reduces them to their equations and figures.
//!
//! Several machines can share this step: each reduces some logs, and the next step takes the joined
//! equations ([`many_logs`](crate::estimate::many_logs)).

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
use crate::regression::{Observer, PassError, Reading, System, read_through};

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
    /// Samples of the logs for spectra; none if several machines read the logs.
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
    let names = log_names(log, prepared.names());
    let on_line = OnLine::new(reading.model(), reading.settings());
    let mut observers = (on_line, Record::new(reading.model().joint_count()));
    let read = reduce(reading, (sources, &names), &mut observers, progress)?;
    let (on_line, record) = observers;
    let lsff = on_line.lsff.transpose()?;
    Ok(ReadLogs {
        lsff: lsff.map(|lsff| (lsff, on_line.seconds)),
        record,
        ..read
    })
}

/// Reduces logs to their equations and figures.
///
/// - `(sources, names)`: the logs and their names in results.
///
/// # Errors
///
/// [`PassError`] if a log cannot be read or does not fit the filters, or the caller stops the run.
pub(in crate::estimate) fn reduce<O: Observer>(
    reading: &Reading,
    (sources, names): (&mut [LogSource<'_>], &[String]),
    observers: &mut O,
    progress: &mut dyn Listener,
) -> Result<ReadLogs, PassError> {
    let (model, channels) = (reading.model(), reading.channels());
    let labels: Vec<String> = sources.iter().map(LogSource::label).collect();
    let passed = read_through(reading, sources, observers, Phase::Reading, progress)?;
    let logs = passed.logs.iter();
    Ok(ReadLogs {
        infos: (logs.clone().zip(names))
            .map(|(figures, name)| LogInfo::of(name, figures))
            .collect(),
        examined: (logs.zip(&labels))
            .map(|(figures, label)| OfLog::new(label, channels, model, figures))
            .collect(),
        system: passed.system,
        spans: passed.spans,
        lsff: None,
        record: Record::new(model.joint_count()),
    })
}
