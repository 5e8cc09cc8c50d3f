//! A refinement in the form of the results.

use sprung_core::friction::Scale;

use super::findings::correlations;
use super::hold_out::HeldOut;
use super::ladder::Tried;
use super::refined::{FrictionScale, Refined};
use super::status::{Outcome, Status};
use crate::estimate::result::{
    HeldOutResidual, PreslidingPrior, RefinedDelay, RefinedOffset, RefinedSharpness,
    RefinedVelocity, Refinement, RowDisturbance, RungResult, SensorNoise,
};
use crate::log::Channels;
use crate::model::Model;

/// Returns the part of the result that describes a refinement; `None` if the rung has no result.
///
/// - `shown`: the rung that is used, or the nearest to it.
/// - `status`: outcome of the refinement.
pub(super) fn describe(
    model: &Model,
    channels: &Channels,
    shown: &Tried,
    status: &Status,
) -> Option<Refinement> {
    let refined = shown.refined()?;
    let name = |index: usize| model.parameters()[index].name.clone();
    let column = |channel: usize| channels.all[channel].column.clone();
    Some(Refinement {
        used: status.is_used(),
        rung: shown.rung.name().to_owned(),
        rungs: rungs(status),
        values: values(model, refined),
        converged: refined.converged(),
        runs: refined.search.runs,
        samples: refined.read.samples,
        duration_s: refined.read.duration,
        measurements: refined.read.measurements,
        minus_log_likelihood: refined.search.loss,
        disturbances: (refined.noise.rows.iter().enumerate())
            .map(|(row, level)| RowDisturbance {
                row: model.row_name(row),
                torque_noise_nm: level.torque_noise,
                reversal_noise_nm: level.reversal_noise,
                disturbance_nm: level.disturbance,
                torque_nm: level.torque,
                at_bound: level.at_bound,
            })
            .collect(),
        disturbance_corner_hz: refined.noise.corner,
        cost_per_measurement: refined.search.cost,
        held_out_residual: shown.held_out.and_then(residual),
        sensor_noise: (refined.noise.sensors.iter())
            .map(|sensor| SensorNoise {
                column: column(sensor.channel),
                noise_rad: sensor.noise,
                deviation_rad: sensor.scale,
            })
            .collect(),
        encoder_offsets: (refined.channels.offsets.iter())
            .map(|offset| RefinedOffset {
                joint: model.joints()[offset.joint].clone(),
                column: column(offset.channel),
                offset_rad: offset.value,
                standard_error_rad: offset.standard_error,
            })
            .collect(),
        delays: (refined.channels.delays.iter())
            .map(|delay| RefinedDelay {
                column: column(delay.channel),
                delay_s: delay.value(),
                standard_error_s: Some(delay.standard_error).filter(|e| e.is_finite()),
                used_s: delay.assumed,
            })
            .collect(),
        torques_delay_s: (refined.channels.torques_delay.as_ref())
            .filter(|delay| delay.estimated)
            .map(|delay| (delay.value(), delay.standard_error)),
        presliding_levels: (refined.noise.presliding.iter())
            .map(|(joint, side, level)| PreslidingPrior {
                joint: model.joints()[*joint].clone(),
                side: (*side).to_owned(),
                level_nm: *level,
            })
            .collect(),
        stribeck_velocities: stribeck_velocities(model, refined),
        sharpnesses: sharpnesses(model, refined),
        correlations: (correlations(refined).into_iter())
            .map(|pair| (name(pair.first), name(pair.second), pair.correlation))
            .collect(),
        each_log: (refined.parts.logs.iter())
            .map(|log| {
                let position_of = |index| refined.free.iter().position(|free| *free == index);
                (0..model.parameters().len())
                    .map(|index| position_of(index).map(|place| log[place]))
                    .collect()
            })
            .collect(),
    })
}

fn stribeck_velocities(model: &Model, refined: &Refined) -> Vec<RefinedVelocity> {
    (of_scale(refined, Scale::Stribeck))
        .map(|scale| RefinedVelocity {
            joint: model.joints()[scale.joint].clone(),
            velocity: scale.value,
            standard_error: scale.standard_error,
        })
        .collect()
}

fn sharpnesses(model: &Model, refined: &Refined) -> Vec<RefinedSharpness> {
    (of_scale(refined, Scale::Sharpness))
        .map(|scale| RefinedSharpness {
            joint: model.joints()[scale.joint].clone(),
            sharpness: scale.value,
            standard_error: scale.standard_error,
        })
        .collect()
}

fn of_scale(refined: &Refined, scale: Scale) -> impl Iterator<Item = &FrictionScale> {
    refined
        .scales
        .iter()
        .filter(move |friction_scale| friction_scale.scale == scale)
}

/// Returns the residuals of a comparison; `None` if the refinement has no finite one.
fn residual(held: HeldOut) -> Option<HeldOutResidual> {
    held.refined.is_finite().then_some(HeldOutResidual {
        refined: held.refined,
        linear: held.linear,
    })
}

/// Returns the rungs that were tried.
fn rungs(status: &Status) -> Vec<RungResult> {
    let each = status.outcomes().iter();
    each.map(|(rung, outcome)| RungResult {
        name: rung.name().to_owned(),
        used: matches!(outcome, Outcome::Used(_)),
        held_out_residual: outcome.held_out().and_then(residual),
        outcome: outcome.text(),
    })
    .collect()
}

/// Returns the refined value of each parameter with its standard error; `None` for a parameter that
/// was not refined.
fn values(model: &Model, refined: &Refined) -> Vec<Option<(f64, f64)>> {
    (0..model.parameters().len())
        .map(|index| {
            let is_free = refined.free.contains(&index);
            is_free.then(|| (refined.theta[index], refined.standard_error[index]))
        })
        .collect()
}
