//! Finds the source of a log's time and its declared sampling in a description.

use super::origin::{Stream, TimeOrigin};
use crate::clock::timing::Sampling;
use crate::description::{Log, SamplingTimes, Unit};

/// Where the time of a log comes from.
pub(crate) struct TimeSource {
    pub(crate) origin: TimeOrigin,
    pub(crate) stream: Option<Stream>,
    /// Seconds per unit.
    pub(crate) factor: f64,
}

/// Returns the source of the time; `None` if the description names none.
pub(crate) fn time(log: &Log) -> Option<TimeSource> {
    let source = |origin, stream, factor| TimeSource {
        origin,
        stream,
        factor,
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
