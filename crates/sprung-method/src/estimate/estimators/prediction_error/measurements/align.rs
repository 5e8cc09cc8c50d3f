//! Alignment: raw samples become torques and measurements without their delays.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use super::encoder_edges::{EdgePosition, encoder_edges};
use super::measurement::Measurement;
use super::read::RawSegment;
use super::segment::Segment;
use super::segment_ranges::segment_ranges;
use super::sensor::{Noise, Sensor};
use super::start_state::start_state;
use super::torque::torques;
use crate::log::{Channels, Quantity};
use crate::model::Model;
use crate::preprocess::{Aligner, Butterworth, RawBlock, ZeroPhase};

/// Samples of a segment with values of all channels after the removal of delays.
struct Window<'a> {
    /// Delay of each channel, s.
    delays: &'a [f64],
    /// Sampling period, s.
    period: f64,
    /// Index of the first sample.
    begin: usize,
    samples: usize,
}

impl Window<'_> {
    /// Returns the delay of a channel in samples.
    fn shift(&self, channel: usize) -> f64 {
        self.delays[channel] / self.period
    }

    /// Returns the first sample after a position of a sensor, and the measurement at this sample;
    /// `None` if the position is outside of the window.
    fn place(
        &self,
        (index, sensor): (usize, &Sensor),
        position: EdgePosition,
    ) -> Option<(usize, Measurement)> {
        let at = position.sample - self.shift(sensor.channel) - self.begin as f64;
        let sample = (at - 1e-9).ceil();
        if sample < 0.0 || sample >= self.samples as f64 {
            return None;
        }
        let age = (sample - at).max(0.0) * self.period;
        // The observation is extrapolated back by the velocity at the sample, so the effect of the
        // acceleration is subtracted here.
        let acceleration_effect = 0.5 * position.acceleration * age * age;
        let measurement = Measurement {
            sensor: index,
            value: position.value + sensor.offset - acceleration_effect,
            variance: position.variance,
            age,
        };
        Some((sample as usize, measurement))
    }
}

/// Turns raw samples into torques and measurements, in segments that the filter processes in
/// parallel.
///
/// - `delays`: delay of each channel, s.
/// - `filter`: smooths the positions, at the period of the log.
///
/// Returns `None` if there are too few samples for the filter or the delays.
pub(super) fn align(
    raw: &RawSegment,
    model: &Model,
    channels: &Channels,
    sensors: &[Sensor],
    delays: &[f64],
    filter: &Butterworth,
) -> Option<Vec<Segment>> {
    let (period, rows) = (raw.period, model.coordinates());
    let mut aligner = Aligner::at_samples(channels, delays, period);
    let mut inputs = RawBlock::new(model.joint_count());
    let times = (0..raw.values.first()?.len()).map(|k| raw.begin + k as f64 * period);
    aligner.push_columns(times, &raw.values, &mut inputs);
    let window = Window {
        delays,
        period,
        begin: (aligner.shift() / period).round() as usize,
        samples: inputs.len(),
    };
    // Two samples show no acceleration.
    if window.samples <= 2 {
        return None;
    }
    let ranges = segment_ranges(window.samples, period);
    // An encoder gives at most one position per sample.
    let mut found: Vec<(usize, Measurement)> = Vec::with_capacity(sensors.len() * window.samples);
    // Position and velocity of each sensor at the beginning of each segment.
    let mut begins = vec![Vec::with_capacity(sensors.len()); ranges.len()];
    let mut speeds = Vec::with_capacity(sensors.len());
    let [mut links, mut motors] = [0; 2].map(|_| vec![None::<Velocity>; model.joint_count()]);
    for (index, sensor) in sensors.iter().enumerate() {
        let factor = sensor.factor();
        let values: Cow<'_, [f64]> = if sensor.spring.is_some() {
            let raw = &raw.values[sensor.channel];
            raw.iter().map(|value| factor * value).collect()
        } else {
            Cow::Borrowed(&raw.values[sensor.channel])
        };
        let velocity = velocity(&values, filter, period)?;
        positions(&values, &velocity, sensor.noise, period, |position| {
            found.extend(window.place((index, sensor), position));
        });
        let first = window.begin as f64 + window.shift(sensor.channel);
        let first = first.round().max(0.0) as usize;
        for (begins, within) in begins.iter_mut().zip(&ranges) {
            let at = (first + within.from).min(velocity.len() - 1);
            begins.push((values[at] + sensor.offset, velocity[at]));
        }
        let squares: f64 = velocity.iter().map(|v| v * v).sum();
        let channel = &channels.all[sensor.channel];
        if channel.quantity == Quantity::MotorPosition {
            motors[channel.joint] = Some((first, velocity.clone()));
        } else if channel.quantity == Quantity::LinkPosition {
            links[channel.joint] = Some((first, velocity.clone()));
        }
        speeds.push((squares / velocity.len().max(1) as f64).sqrt());
    }
    found.sort_by_key(|(sample, measurement)| (*sample, measurement.sensor));
    let torque = torques(model, &inputs);
    let excess = covariates(channels, &inputs);
    let elements = elements(model, [&links, &motors], &window);
    let of_samples = |all: &[f64], within: Range<usize>| {
        let per_sample = all.len() / window.samples;
        all[within.start * per_sample..within.end * per_sample].to_vec()
    };
    let torque_rate = rates(&torque, rows, filter, period)?;
    let moving = moving_shares(model, channels, &window);
    let first = first_of_samples(&found, window.samples);
    let change = raw
        .payload
        .as_ref()
        .map(|payload| model.change_by_payload(payload));
    let carried: Option<Arc<[f64]>> = change.flatten().map(Into::into);
    let each = ranges.iter().zip(begins).map(|(within, begins)| {
        let (start, start_deviation) = start_state(rows, sensors, &begins)?;
        let of_rows = within.from * rows..within.to * rows;
        let range = first[within.from]..first[within.to];
        Some(Segment {
            log: raw.log,
            carried: carried.clone(),
            burn_in: within.burn_in,
            span: [0.0, 1.0],
            period,
            torque: torque[of_rows.clone()].to_vec(),
            torque_rate: torque_rate[of_rows].to_vec(),
            moving: moving.clone(),
            excess: of_samples(&excess, within.from..within.to),
            elements: of_samples(&elements, within.from..within.to),
            first: (first[within.from..=within.to].iter())
                .map(|at| at - range.start)
                .collect(),
            measurements: found[range]
                .iter()
                .map(|(_, measurement)| *measurement)
                .collect(),
            start,
            start_deviation,
            speeds: speeds.clone(),
        })
    });
    each.collect()
}

/// Returns the share of each row's torque rate that acts within a period, \[rows\]; empty if the torques are held for the
/// whole period.
fn moving_shares(model: &Model, channels: &Channels, window: &Window<'_>) -> Arc<[f64]> {
    let mut shares = vec![0.0; model.coordinates()];
    let holds = channels.holds(window.delays, window.period);
    for (channel, hold) in channels.all.iter().zip(holds) {
        if channel.quantity == Quantity::MotorTorque {
            shares[model.torque_row(channel.joint)] = moving_share(hold);
        }
    }
    if shares.iter().all(|share| *share == 0.0) {
        shares.clear();
    }
    shares.into()
}

/// Returns the share of a torque's rate that acts within a period. A torque that a controller holds for a shorter time
/// rises in steps, whose first moment is that of a line with this share of their slope: 1 − (h/T)².
///
/// - `hold`: h/T, the time for which a torque is held over the period of the log.
fn moving_share(hold: f64) -> f64 {
    1.0 - hold * hold
}

/// Returns the covariates of the joints minus their references, \[samples × n × covariates\]; empty if
/// no friction depends on any.
fn covariates(channels: &Channels, inputs: &RawBlock) -> Vec<f64> {
    if channels.covariates.is_empty() {
        return Vec::new();
    }
    (0..inputs.len())
        .flat_map(|k| inputs.excess_at(k))
        .collect()
}

/// Measured velocity of a motor or link, rad/s (m/s), with the index of the first sample of a window.
type Velocity = (usize, Vec<f64>);

/// Returns the elements of presliding friction and hysteresis in the middle of each period, by the measured velocities,
/// \[samples × n × elements\]; empty if no joint has any.
fn elements(model: &Model, sides: [&[Option<Velocity>]; 2], window: &Window<'_>) -> Vec<f64> {
    let mut elements = model.elements();
    let mut all = Vec::new();
    if elements.is_empty() {
        return all;
    }
    for k in 0..window.samples {
        let travel = |side: &Option<Velocity>| {
            let velocity = side.as_ref().map(|(first, velocity)| {
                let last = velocity.len() - 1;
                velocity[(first + k).min(last)]
            });
            velocity.unwrap_or_default() * window.period
        };
        let [links, motors] = sides.map(|side| side.iter().map(travel).collect::<Vec<f64>>());
        all.extend_from_slice(elements.turn(&links, &motors));
    }
    all
}

/// Visits the positions that a channel measures.
fn positions(
    values: &[f64],
    velocity: &[f64],
    noise: Noise,
    period: f64,
    mut visit: impl FnMut(EdgePosition),
) {
    match noise {
        Noise::White(deviation) => {
            for (k, value) in values.iter().enumerate() {
                let ahead = (k + 1).min(velocity.len() - 1);
                visit(EdgePosition {
                    sample: k as f64,
                    value: *value,
                    variance: deviation * deviation,
                    acceleration: (velocity[ahead] - velocity[k]) / period,
                });
            }
        }
        Noise::Counts(count) => encoder_edges(values, velocity, count, period, visit),
    }
}

/// Returns the index of the first measurement of each sample, then the number of measurements.
fn first_of_samples(found: &[(usize, Measurement)], samples: usize) -> Vec<usize> {
    let mut first = Vec::with_capacity(samples + 1);
    let mut next = 0;
    for sample in 0..=samples {
        while next < found.len() && found[next].0 < sample {
            next += 1;
        }
        first.push(next);
    }
    first
}

/// Returns the velocity of the smoothed values.
fn velocity(values: &[f64], filter: &Butterworth, period: f64) -> Option<Vec<f64>> {
    let mut smooth = Vec::with_capacity(values.len());
    let mut running = ZeroPhase::new(filter.clone());
    running.push(values, &mut smooth);
    if !running.finish(&mut smooth) {
        return None;
    }
    let last = smooth.len() - 1;
    Some(
        (0..=last)
            .map(|k| {
                let (before, after) = (k.saturating_sub(1), (k + 1).min(last));
                (smooth[after] - smooth[before]) / ((after - before) as f64 * period)
            })
            .collect(),
    )
}

/// Returns the rates of the smoothed torques, \[samples × rows\].
fn rates(torque: &[f64], rows: usize, filter: &Butterworth, period: f64) -> Option<Vec<f64>> {
    let mut rates = vec![0.0; torque.len()];
    for row in 0..rows {
        let series: Vec<f64> = torque.iter().skip(row).step_by(rows).copied().collect();
        let smooth = velocity(&series, filter, period)?;
        for (rate, value) in rates[row..].iter_mut().step_by(rows).zip(smooth) {
            *rate = value;
        }
    }
    Some(rates)
}

#[cfg(test)]
mod tests {
    use super::moving_share;
    use crate::description::TorqueHold;

    #[test]
    fn stairs_have_the_first_moment_of_a_line_with_this_share_of_their_slope() {
        // Steps of a controller in a period of the log; the torque acts half a step after its stamp.
        for steps in [1_u32, 2, 4, 10] {
            let n = f64::from(steps);
            let delay = 0.5 - 0.5 / n;
            let middle = |k: u32| (f64::from(k) + 0.5) / n - 0.5;
            // ∫ s u(s) ds over the period, with u of slope 1 at the middles of the steps; 1/12 for a line.
            let moment: f64 = (0..steps).map(|k| middle(k).powi(2) / n).sum();
            assert!(
                (moving_share(TorqueHold::hold_by_delay(delay)) - 12.0 * moment).abs() < 1e-12,
                "{steps}"
            );
        }
        for delay in [1.0, 1.6] {
            assert!(moving_share(TorqueHold::hold_by_delay(delay)).abs() < 1e-12);
        }
    }
}
