//! Torques on the rows.

use super::deviation::deviation;
use super::segment::Segment;
use crate::model::Model;
use crate::prepare::white_noise;
use crate::preprocess::RawBlock;

/// Minimum scale of a joint's torque, relative to the largest scale.
const MIN_RELATIVE_TORQUE_SCALE: f64 = 1e-3;

/// Returns the standard deviation of the torque of each row's joint, N·m (N). A joint with almost
/// no torque gets a fraction of the largest value.
pub(super) fn torque_scale(model: &Model, segments: &[Segment]) -> Vec<f64> {
    let rows = model.coordinates();
    let of_row = |row: usize| {
        let torques = segments
            .iter()
            .map(|segment| segment.torque.iter().skip(row).step_by(rows));
        deviation(torques.flatten().copied())
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
            let torque = segment.torque.iter().skip(row).step_by(rows);
            white_noise(&torque.copied().collect::<Vec<f64>>())
        });
        torques.fold(0.0, f64::max)
    };
    (0..rows).map(of_row).collect()
}

/// Returns the torque on each row, held during a period, N·m (N), \[samples × rows\].
pub(super) fn torques(model: &Model, inputs: &RawBlock) -> Vec<f64> {
    let rows = model.coordinates();
    let mut torque = vec![0.0; inputs.len() * rows];
    for (joint, tau) in inputs.tau.iter().enumerate() {
        let targets = torque[model.torque_row(joint)..].iter_mut().step_by(rows);
        for (on_row, tau) in targets.zip(tau) {
            *on_row = *tau;
        }
    }
    torque
}
