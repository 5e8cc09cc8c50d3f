//! From logs to measurements.

use std::sync::Arc;

use super::align::align;
use super::read::RawSegment;
use super::segment::{Measurements, Segment};
use super::sensor::{Noise, Sensor, sensors};
use super::torque::{fast_noise, torque_scale};
use crate::estimate::estimators::prediction_error::reversals::Reversals;
use crate::estimate::statistics::ROUNDING;
use crate::log::Channels;
use crate::model::Model;
use crate::prepare::{Excerpt, noise as noise_of, sample_noise};
use crate::preprocess::Butterworth;
use crate::regression::{PassError, Reading};

/// Noise over that of an ideal encoder above which its edges tell less than its samples.
const NOISY: f64 = 1.25;

/// Turns raw samples into the inputs of the filter; `None` if there are too few samples.
///
/// - `excerpt`: the beginning of the first log, for the noise of its channels.
/// - `left_out`: whether the logs contain more samples.
///
/// # Errors
///
/// [`PassError`] if the filter of positions does not fit the logs.
pub(in super::super) fn build(
    reading: &Reading,
    excerpt: &Excerpt,
    raw: &[RawSegment],
    left_out: bool,
) -> Result<Option<Measurements>, PassError> {
    let (model, channels) = (reading.model(), reading.channels());
    let noise = |channel: usize| {
        let deviation = sample_noise(excerpt, channel).max(ROUNDING);
        let counts = noise_of(excerpt, channel).and_then(|(_, step)| step);
        (counts.map(Noise::Counts))
            .filter(|counts| deviation <= NOISY * counts.variance().sqrt())
            .unwrap_or(Noise::White(deviation))
    };
    let sensors = sensors(model, channels, reading.compliances(), raw, noise);
    let order = reading.settings().position_filter_order;
    let mut segments = Vec::new();
    for raw in raw {
        let filter = Butterworth::new(order, reading.position_cutoff_hz(), raw.period)?;
        let delays = reading.delays();
        let aligned = align(raw, model, channels, &sensors, delays, &filter);
        segments.extend(aligned.into_iter().flatten());
    }
    if segments.is_empty() {
        return Ok(None);
    }
    let all: usize = segments.iter().map(Segment::counted).sum();
    let mut before = 0;
    for segment in &mut segments {
        let after = before + segment.counted();
        segment.span = [before, after].map(|at| at as f64 / all as f64);
        before = after;
    }
    let speeds = joint_speeds(model, channels, &sensors, &segments);
    Ok(Some(Measurements {
        reversals: Reversals::new(model, &speeds),
        torque_scale: torque_scale(model, &segments),
        fast_noise: fast_noise(model, channels, raw),
        sensors,
        segments: Arc::new(segments),
        left_out,
    }))
}

/// Returns the same samples for a model that has more laws of friction.
pub(in super::super) fn with_laws(
    measurements: &Measurements,
    model: &Model,
    channels: &Channels,
) -> Measurements {
    let sensors = measurements.sensors.iter().map(|sensor| Sensor {
        spring: (sensor.spring.as_ref()).map(|spring| spring.of_model(model)),
        ..sensor.clone()
    });
    let speeds = joint_speeds(
        model,
        channels,
        &measurements.sensors,
        &measurements.segments,
    );
    Measurements {
        sensors: sensors.collect(),
        reversals: Reversals::new(model, &speeds),
        ..measurements.clone()
    }
}

/// Returns the root mean square velocity of each joint: the largest of its sensors, because a
/// sensor of the deflection moves less than the joint.
fn joint_speeds(
    model: &Model,
    channels: &Channels,
    sensors: &[Sensor],
    segments: &[Segment],
) -> Vec<f64> {
    let mut speeds = vec![0.0_f64; model.joint_count()];
    for (i, sensor) in sensors.iter().enumerate() {
        let speed = &mut speeds[channels.all[sensor.channel].joint];
        *speed = segments
            .iter()
            .fold(*speed, |most, segment| most.max(segment.speeds[i]));
    }
    speeds
}
