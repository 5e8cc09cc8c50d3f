//! A refinement in the form of the results.

use super::findings::correlations;
use super::hold_out::HeldOut;
use super::refined::Refined;
use super::status::Status;
use crate::estimate::result::{
    HeldOutResidual, RefinedDelay, RefinedOffset, Refinement, RowDisturbance, SensorNoise,
};
use crate::log::Channels;
use crate::model::Model;

/// Returns the part of the result that describes a refinement.
///
/// - `status`: outcome of the refinement.
pub(super) fn describe(
    model: &Model,
    channels: &Channels,
    refined: &Refined,
    held_out: Option<HeldOut>,
    status: &Status,
) -> Refinement {
    let name = |index: usize| model.parameters()[index].name.clone();
    let column = |channel: usize| channels.all[channel].column.clone();
    Refinement {
        used: status.is_used(),
        converged: refined.converged(),
        runs: refined.runs,
        samples: refined.samples,
        duration_s: refined.duration,
        measurements: refined.measurements,
        minus_log_likelihood: refined.loss,
        disturbances: (refined.levels.iter().enumerate())
            .map(|(row, level)| RowDisturbance {
                row: model.row_name(row),
                torque_noise_nm: level.torque_noise,
                disturbance_nm: level.disturbance,
                torque_nm: level.torque,
                at_bound: level.at_bound,
            })
            .collect(),
        disturbance_corner_hz: refined.corner,
        cost_per_measurement: refined.cost,
        held_out_residual: held_out.map(|held| HeldOutResidual {
            refined: held.refined,
            linear: held.linear,
        }),
        sensor_noise: (refined.sensors.iter())
            .map(|sensor| SensorNoise {
                column: column(sensor.channel),
                noise_rad: sensor.noise,
                deviation_rad: sensor.scale,
            })
            .collect(),
        encoder_offsets: (refined.offsets.iter())
            .map(|offset| RefinedOffset {
                joint: model.joints()[offset.joint].clone(),
                column: column(offset.channel),
                offset_rad: offset.value,
                standard_error_rad: offset.standard_error,
            })
            .collect(),
        delays: (refined.delays.iter())
            .map(|delay| RefinedDelay {
                column: column(delay.channel),
                delay_s: delay.delay(),
                standard_error_s: Some(delay.standard_error).filter(|e| e.is_finite()),
                used_s: delay.assumed,
            })
            .collect(),
        correlations: (correlations(refined).into_iter())
            .map(|(a, b, correlation)| (name(a), name(b), correlation))
            .collect(),
        each_log: (refined.logs.iter())
            .map(|log| {
                let own = |index| refined.free.iter().position(|free| *free == index);
                (0..model.parameters().len())
                    .map(|index| own(index).map(|place| log[place]))
                    .collect()
            })
            .collect(),
    }
}
