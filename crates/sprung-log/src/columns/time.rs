//! Finds the source of a log's time and its declared sampling in a description.

use super::origin::{Stream, TimeOrigin};
use crate::clock::timing::Sampling;
use crate::description::{Log, SamplingTimes, Unit};

/// Where the time of a log comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeSource {
    /// Column, messages or period.
    pub origin: TimeOrigin,
    /// The stream that gives the time, if it is declared.
    pub stream: Option<Stream>,
    /// Factor from the reading to the time in s.
    pub factor: f64,
    /// When samples were taken, if it is declared.
    pub sampling: Option<Sampling>,
    /// Whether times are dates.
    pub are_dates: bool,
}

/// Returns the source of the time; `None` if the description names none.
pub(crate) fn time(log: &Log) -> Option<TimeSource> {
    let source = |origin, stream, factor| TimeSource {
        origin,
        stream,
        factor,
        sampling: sampling(log),
        are_dates: are_dates(log),
    };
    let named = [
        (&log.time_s, 1.0),
        (&log.time_ms, 1e-3),
        (&log.time_us, 1e-6),
        (&log.time_ns, 1e-9),
    ];
    if let Some((name, factor)) = (named.into_iter()).find_map(|(key, f)| Some((key.as_ref()?, f)))
    {
        return Some(source(TimeOrigin::Column(name.clone()), None, factor));
    }
    let Some(column) = &log.time else {
        let period = log.period_s?;
        return Some(source(TimeOrigin::Period(period), None, 1.0));
    };
    let stream = Stream::of(column);
    let stream = (stream != Stream::default()).then_some(stream);
    let factor = column.unit.map_or(1.0, Unit::size);
    match column.column.as_ref().and_then(|column| column.get(0)) {
        Some(name) => Some(source(TimeOrigin::Column(name), stream, factor)),
        None => Some(source(TimeOrigin::Messages, stream, 1.0)),
    }
}

/// Returns when samples were taken, if the description declares it.
pub(crate) fn sampling(log: &Log) -> Option<Sampling> {
    match (log.period_s, log.sampling.unwrap_or_default()) {
        (Some(period), _) if log.has_time() => Some(Sampling::OnCycle(period)),
        (_, SamplingTimes::Auto) => None,
        (_, SamplingTimes::Even) => Some(Sampling::Even),
        (_, SamplingTimes::AsStamped) => Some(Sampling::AsStamped),
    }
}

/// Returns whether the times are dates.
pub(crate) fn are_dates(log: &Log) -> bool {
    (log.time.as_ref()).is_some_and(|time| time.unit.is_some_and(Unit::is_date))
}
