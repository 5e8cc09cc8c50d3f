//! Torques on the rows.

use super::read::RawSegment;
use super::segment::Segment;
use crate::log::{Channels, Quantity};
use crate::model::Model;
use crate::prepare::{deviation, white_noise};
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
///
/// The noise of the logged values counts: the mean of a period, which the filter uses, is smoother.
pub(super) fn fast_noise(model: &Model, channels: &Channels, raw: &[RawSegment]) -> Vec<f64> {
    let mut of_joints = vec![0.0; model.joint_count()];
    for (i, channel) in channels.all.iter().enumerate() {
        if channel.quantity == Quantity::MotorTorque {
            let noises = raw.iter().map(|segment| white_noise(&segment.values[i]));
            of_joints[channel.joint] = noises.fold(0.0, f64::max);
        }
    }
    if let Some(mix) = &channels.torque_mix {
        let variance = |row: &Vec<f64>| -> f64 {
            let of_motors = row.iter().zip(&of_joints);
            of_motors.map(|(part, noise)| (part * noise).powi(2)).sum()
        };
        of_joints = mix.forward.iter().map(|row| variance(row).sqrt()).collect();
    }
    let mut of_rows = vec![0.0; model.coordinates()];
    for (joint, noise) in of_joints.into_iter().enumerate() {
        of_rows[model.torque_row(joint)] = noise;
    }
    of_rows
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo;
    use crate::description::{no_files, read};
    use rand::{RngExt, SeedableRng};

    #[test]
    fn the_noise_is_that_of_the_logged_torques() {
        let experiment = read("experiment.toml", demo::EXPERIMENT, &[], &mut no_files).unwrap();
        let model = Model::new(&experiment).unwrap();
        let channels = Channels::new(&experiment.robot, experiment.log.as_ref().unwrap()).unwrap();
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let width = 0.4;
        let mut column = |_| -> Vec<f64> {
            let slow = (0..4000).map(|k| (f64::from(k) / 300.0).sin());
            slow.map(|value| value + rng.random_range(-width..width))
                .collect()
        };
        let values = channels.all.iter().map(&mut column).collect();
        let raw = RawSegment {
            log: 0,
            period: 1e-3,
            begin: 0.0,
            payload: None,
            values,
        };
        let noise = fast_noise(&model, &channels, &[raw]);
        let deviation = width / 3.0_f64.sqrt();
        for (row, noise) in noise.into_iter().enumerate() {
            let is_of_motor = row == model.torque_row(model.joint_of(row));
            let expected = if is_of_motor { deviation } else { 0.0 };
            // The median of 4000 differences has an error of 2 to 3 %.
            assert!((noise - expected).abs() <= 0.1 * expected, "{row}: {noise}");
        }
    }
}
