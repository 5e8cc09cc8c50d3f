//! Finds the source of a log's time and its declared sampling in a description.

use super::origin::{Stream, TimeOrigin};
use crate::clock::timing::Sampling;
use crate::description::{Log, SamplingTimes, Unit};

/// Returns the source, the stream and the factor of the time.
pub(crate) fn time(log: &Log) -> Option<(TimeOrigin, Option<Stream>, f64)> {
    let named = [
        (&log.time_s, 1.0),
        (&log.time_ms, 1e-3),
        (&log.time_us, 1e-6),
        (&log.time_ns, 1e-9),
    ];
    if let Some((name, factor)) = (named.into_iter()).find_map(|(key, f)| Some((key.as_ref()?, f)))
    {
        return Some((TimeOrigin::Column(name.clone()), None, factor));
    }
    let Some(column) = &log.time else {
        let period = log.period_s?;
        return Some((TimeOrigin::Period(period), None, 1.0));
    };
    let stream = Stream::of(column);
    let stream = (stream != Stream::default()).then_some(stream);
    let factor = column.unit.map_or(1.0, Unit::size);
    match column.column.as_ref().and_then(|column| column.get(0)) {
        Some(name) => Some((TimeOrigin::Column(name), stream, factor)),
        None => Some((TimeOrigin::Messages, stream, 1.0)),
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
