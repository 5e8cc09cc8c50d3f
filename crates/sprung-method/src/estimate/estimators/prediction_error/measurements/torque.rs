//! Torques on the rows.

use super::deviation::deviation;
use super::read::RawSegment;
use super::segment::Segment;
use crate::log::{Channels, Mix, Quantity};
use crate::model::Model;
use crate::prepare::white_noise;

/// Minimum scale of a joint's torque, relative to the largest scale.
const MIN_RELATIVE_TORQUE_SCALE: f64 = 1e-3;

/// Returns the standard deviation of the torque of each row's joint, N·m (N). A joint with almost
/// no torque gets a fraction of the largest value.
pub(super) fn torque_scale(model: &Model, segments: &[Segment]) -> Vec<f64> {
    let rows = model.coordinates();
    let of_row = |row: usize| {
        let own = segments
            .iter()
            .map(|segment| segment.torque.iter().skip(row).step_by(rows));
        deviation(own.flatten().copied())
    };
    let scales: Vec<f64> = (0..rows)
        .map(|row| of_row(model.torque_row(model.joint_of(row))))
        .collect();
    let largest = scales.iter().fold(f64::MIN_POSITIVE, |m, x| x.max(m));
    scales
        .iter()
        .map(|scale| scale.max(MIN_RELATIVE_TORQUE_SCALE * largest))
        .collect()
}

/// Returns the white noise of the logged torque on each row by its differences from sample to
/// sample, N·m (N). It also contains fast changes of the acting torque, so it is an upper limit of
/// the noise of the log.
pub(super) fn fast_noise(rows: usize, segments: &[Segment]) -> Vec<f64> {
    let of_row = |row: usize| -> f64 {
        let torques = segments.iter().map(|segment| {
            let own = segment.torque.iter().skip(row).step_by(rows);
            white_noise(&own.copied().collect::<Vec<f64>>())
        });
        torques.fold(0.0, f64::max)
    };
    (0..rows).map(of_row).collect()
}

/// Returns the torque on each row, held during a period, N·m (N), \[samples × rows\].
///
/// - `delays`: delay of each channel, s; `begin`: index of the first sample.
pub(super) fn torques(
    raw: &RawSegment,
    model: &Model,
    channels: &Channels,
    delays: &[f64],
    begin: usize,
    samples: usize,
) -> Vec<f64> {
    let (n, rows) = (model.joint_count(), model.coordinates());
    let mut torque = vec![0.0; samples * rows];
    let mut joints = vec![0.0; n];
    for k in 0..samples {
        for (i, channel) in channels.all.iter().enumerate() {
            if channel.quantity == Quantity::MotorTorque {
                // With a delay of a fraction of a sample two logged torques act during a period.
                // Their mean is weighted by their durations.
                let lead = delays[i] / raw.period + begin as f64;
                let whole = (lead + 1e-9).floor();
                let part = (lead - whole).max(0.0);
                let at = k + whole.max(0.0) as usize;
                let values = &raw.values[i];
                let last = values.len() - 1;
                joints[channel.joint] =
                    (1.0 - part) * values[at.min(last)] + part * values[(at + 1).min(last)];
            }
        }
        if let Some(mix) = &channels.torque_mix {
            joints = Mix::apply(&mix.forward, &joints);
        }
        for (joint, tau) in joints.iter().enumerate() {
            torque[k * rows + model.torque_row(joint)] = *tau;
        }
    }
    torque
}
