//! From the end of a descent to the result.

use sprung_core::linear::dot;
use std::collections::BTreeMap;

use super::channel_updates::{ChannelUpdate, channel_updates};
use super::descent::Descent;
use super::dynamics::Dynamics;
use super::effects::TorquesTiming;
use super::effects::{Filtered, of_delays};
use super::filter::{Keep, SegmentRun, Sums, run};
use super::hold_out::PARTS;
use super::levels::Levels;
use super::noisy_torque::{NoiseBias, NoiseSource};
use super::parts::{
    Alone, Fold, alone, between, deviation, folds, possible_alone, values_alone, widened,
    without_folds,
};
use super::problem::{Problem, add_prior};
use super::refined::{
    FoundChannels, FoundNoise, FrictionScale, OfParts, Read, Refined, RowLevel, Search,
    SensorLevel, SensorOffset,
};
use super::sandwich::{Influence, widening};
use super::solve::covariance as covariance_of;
use super::unknowns::Unknowns;
use super::vector::add;
use crate::model::{Model, Theta};
use crate::regression::Reading;

/// Parts from which a point of the trace is averaged.
const PARTS_OF_POINT: usize = 6;

/// Returns the result of a descent. Returns `None` if the filter does not follow the log or the log
/// does not determine all unknowns.
///
/// - `estimated`: channels whose delays are to be estimated, and the treatment of that of all torques.
pub(super) fn finish(
    problem: &Problem<'_>,
    reading: &Reading,
    estimated: (&[usize], TorquesTiming),
    descent: &Descent,
) -> Option<Refined> {
    let (model, measurements) = (problem.model, problem.measurements);
    let effects = of_delays(
        &Filtered::of_channels(model, reading.channels(), measurements),
        estimated,
    );
    let unknowns = problem.unknowns.clone().with_effects(effects);
    let (sums, bias) = last_run(problem, &unknowns, (&descent.z, &descent.levels))?;
    // Estimated delays are unknowns, so they increase the standard errors of the parameters.
    let (channels, torques) = estimated;
    let count = unknowns.values()
        + channels.len()
        + usize::from(torques == TorquesTiming::Estimated && unknowns.has_torques_delay());
    let mut normal = sums.normal.clone();
    add_prior(problem.unknowns, &descent.z, &mut normal);
    let influence = covariance_of(&normal.first(count).information, count)?;
    let duration = measurements.duration();
    let information = with_noise_of_score(&influence, count, &bias);
    let rows: Vec<Influence> = (influence.chunks(count).enumerate())
        .map(|(at, row)| Influence {
            row: row.to_vec(),
            variance: information[at * (count + 1)],
        })
        .collect();
    let widening = widening(&rows.iter().collect::<Vec<_>>(), &sums.gradients, duration);
    let folds = folds(problem, &sums);
    // The factors already contain the scatter between the logs.
    let logs = each_log(problem, descent, &sums);
    let of_folds: Option<Vec<Alone>> = (folds.iter())
        .map(|fold| alone(problem, descent, &fold.normal))
        .collect();
    let of_folds = widened(of_folds.unwrap_or_default(), &widening);
    let sampling = |place: usize| widening[place] * information[place * (count + 1)].sqrt();
    let without = without_folds(&sums.normal, &folds, |part| {
        values_alone(problem, descent, part)
    });
    let between = |place: usize| {
        let of_folds = between(&of_folds, place).min(deviation(&without, place));
        of_folds.max(between(&logs, place))
    };
    let factors: Vec<f64> = (0..count)
        .map(|place| widening[place] * (between(place) / sampling(place)).hypot(1.0))
        .collect();
    let covariance: Vec<f64> = (information.iter().enumerate())
        .map(|(at, entry)| entry * factors[at / count] * factors[at % count])
        .collect();
    let error = |place: usize| covariance[place * (count + 1)].sqrt();
    let free = unknowns.free.clone();
    let width = free.len();
    let mut moved: Vec<(usize, f64)> = free.iter().copied().zip(descent.moved.clone()).collect();
    moved.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    let updates = channel_updates(
        &unknowns,
        (&normal, &sums.gradients),
        &influence,
        &folds.iter().map(|fold| &fold.normal).collect::<Vec<_>>(),
        duration,
        (reading.channels(), reading.delays()),
    );
    let (torques_delay, delays): (Vec<ChannelUpdate>, _) =
        (updates.into_iter()).partition(ChannelUpdate::is_of_torques);
    let (unconstrained, possible_without) =
        apart(problem, &unknowns, descent, &sums, (&folds, &without))?;
    Some(Refined {
        covariance: (0..width * width)
            .map(|at| covariance[at / width * count + at % width])
            .collect(),
        theta: unknowns.theta(&descent.z),
        standard_error: standard_errors(model, &free, error),
        between_parts: standard_errors(model, &free, between),
        search: Search {
            ending: descent.ending,
            runs: descent.runs,
            moved,
            loss: sums.loss,
            cost: sums.cost / sums.measurements.max(1) as f64,
        },
        read: Read {
            measurements: sums.measurements,
            samples: measurements.samples(),
            duration,
            left_out: measurements.left_out,
        },
        noise: found_noise(problem, &unknowns, &descent.levels),
        scales: friction_scales(&unknowns, &descent.z, error),
        channels: FoundChannels {
            offsets: sensor_offsets(problem, &unknowns, &descent.z, error),
            delays,
            torques_delay: torques_delay.into_iter().next(),
        },
        by_noise: moves_by_noise(&influence, count, &bias, width),
        unconstrained,
        parts: OfParts {
            trace: trace(problem, descent, &sums),
            without: (possible_without.into_iter())
                .map(|(end, z)| (end, unknowns.theta(&z)))
                .collect(),
            logs,
        },
        free,
    })
}

/// Runs the filter at the end of a descent, with derivatives by all unknowns and delays. Returns the
/// sums, corrected for the noise of the logged torque, and the correction.
pub(super) fn last_run(
    problem: &Problem<'_>,
    unknowns: &Unknowns,
    (z, levels): (&[f64], &Levels),
) -> Option<(Sums, NoiseBias)> {
    let dynamics = Dynamics::new(problem.model, &unknowns.theta(z));
    let measurements = problem.measurements;
    let part = (measurements.samples()).div_ceil(PARTS * PARTS_OF_POINT);
    let keep = Keep {
        linearization: true,
        part: Some(part),
        parts_of_fold: PARTS_OF_POINT,
    };
    let starts = measurements.starts();
    let noise = NoiseSource::new(problem, (z, levels));
    let (run, biases) = run(
        measurements,
        &dynamics,
        unknowns,
        (z, levels),
        keep,
        |index, of_segment| {
            let before = (starts[index].0, measurements.segments[index].burn_in);
            let bias = BiasOfParts::new(problem, &noise, (index, of_segment), before, part);
            *of_segment = SegmentRun::default();
            bias
        },
    )?;
    let none = NoiseBias::zero(unknowns.values());
    let mut of_points = vec![none.clone(); run.sums.growing.len() + 1];
    let mut of_parts = vec![vec![0.0; unknowns.values()]; run.sums.gradients.len() + 1];
    let mut of_logs = vec![none.clone(); run.sums.logs.len()];
    for (segment, bias) in measurements.segments.iter().zip(&biases) {
        for (at, point) in &bias.points {
            of_points[*at].add(point);
            if let Some(log) = of_logs.get_mut(segment.log) {
                log.add(point);
            }
        }
        for (at, gradient) in &bias.gradients {
            add(&mut of_parts[*at], 1.0, gradient);
        }
    }
    let mut sums = run.sums;
    let mut whole = none.clone();
    for point in &of_points {
        whole.add(point);
    }
    let limit = whole.limit(&sums.normal);
    whole.scale_information(limit);
    whole.correct(&mut sums.normal);
    let mut up_to = none;
    for ((_, normal), point) in sums.growing.iter_mut().zip(&mut of_points) {
        point.scale_information(limit);
        up_to.add(point);
        up_to.correct(normal);
    }
    let mut up_to = vec![0.0; unknowns.values()];
    for (gradient, part) in sums.gradients.iter_mut().zip(&of_parts) {
        add(&mut up_to, 1.0, part);
        add(gradient, -1.0, &up_to);
    }
    for (normal, log) in sums.logs.iter_mut().zip(&mut of_logs) {
        log.scale_information(limit);
        log.correct(normal);
    }
    Some((sums, whole))
}

/// Bias by noise of the logged torque in the parts of a segment.
struct BiasOfParts {
    /// By the index of the point of the trace.
    points: BTreeMap<usize, NoiseBias>,
    /// Gradients by the index of the part.
    gradients: BTreeMap<usize, Vec<f64>>,
}

impl BiasOfParts {
    /// Samples that do not count belong to the first part of their segment.
    ///
    /// - `before`, `burn_in`: number of samples that count before the segment, and of those at its
    ///   beginning that do not count; `part`: samples of a part.
    fn new(
        problem: &Problem<'_>,
        noise: &NoiseSource<'_>,
        (segment, run): (usize, &SegmentRun),
        (before, burn_in): (usize, usize),
        part: usize,
    ) -> Self {
        let values = problem.unknowns.values();
        let mut all = Self {
            points: BTreeMap::new(),
            gradients: BTreeMap::new(),
        };
        noise.visit(segment, run, |sample, bias| {
            let at = (before + sample.saturating_sub(burn_in)) / part;
            let gradient = all.gradients.entry(at).or_insert_with(|| vec![0.0; values]);
            add(gradient, 1.0, &bias.gradient);
            let point =
                (all.points.entry(at / PARTS_OF_POINT)).or_insert_with(|| NoiseBias::zero(values));
            point.add(bias);
        });
        all
    }
}

/// Returns the offsets of sensors.
///
/// - `error`: standard error of an unknown, by its place.
fn sensor_offsets(
    problem: &Problem<'_>,
    unknowns: &Unknowns,
    z: &[f64],
    error: impl Fn(usize) -> f64,
) -> Vec<SensorOffset> {
    let width = unknowns.free.len();
    (unknowns.offsets.iter().enumerate())
        .map(|(i, offset)| SensorOffset {
            joint: offset.joint,
            channel: problem.measurements.sensors[offset.sensor].channel,
            value: z[width + i],
            standard_error: error(width + i),
        })
        .collect()
}

/// Unknowns without each fold, with the end of the fold as a fraction of the samples.
type WithoutFolds = Vec<(f64, Vec<f64>)>;

/// Returns the parameters of the likeliest robot, possible or not, and the unknowns without each fold of the likeliest
/// robot that can exist.
///
/// - `without`: the unknowns without each fold, without constraints.
fn apart(
    problem: &Problem<'_>,
    unknowns: &Unknowns,
    descent: &Descent,
    sums: &Sums,
    (folds, without): (&[Fold], &WithoutFolds),
) -> Option<(Option<Theta>, WithoutFolds)> {
    if problem.robots.is_none() {
        return Some((None, without.clone()));
    }
    let likeliest = unknowns.theta(&values_alone(problem, descent, &sums.normal)?);
    let possible = without_folds(&sums.normal, folds, |part| {
        possible_alone(problem, descent, part)
    });
    Some((Some(likeliest), possible))
}

/// Returns the covariance of the estimates by the information, `M⁻¹ (M + A_n) M⁻¹`: the score varies
/// by the whole information, and the estimates follow it by the information M without the noise of
/// the logged torque.
///
/// - `influence`: M⁻¹, \[count × count\].
fn with_noise_of_score(influence: &[f64], count: usize, bias: &NoiseBias) -> Vec<f64> {
    let values = bias.gradient.len();
    let noise = |i: usize, j: usize| bias.information[i.max(j) * values + i.min(j)];
    let mut covariance = influence.to_vec();
    let mut moved = vec![0.0; values];
    for i in 0..count {
        let row = &influence[i * count..][..values];
        for (j, moved) in moved.iter_mut().enumerate() {
            *moved = row
                .iter()
                .enumerate()
                .map(|(k, entry)| entry * noise(k, j))
                .sum();
        }
        for k in 0..count {
            let column = &influence[k * count..][..values];
            covariance[i * count + k] += dot(&moved, column);
        }
    }
    covariance
}

/// Returns the changes of the refined parameters by the correction for noise, \[free\].
fn moves_by_noise(influence: &[f64], count: usize, bias: &NoiseBias, free: usize) -> Vec<f64> {
    let rows = influence.chunks(count).take(free);
    rows.map(|row| dot(&row[..bias.gradient.len()], &bias.gradient))
        .collect()
}

/// Returns the standard error of each parameter, \[p\].
///
/// - `error`: standard error of a refined parameter, by its position in `free`.
fn standard_errors(model: &Model, free: &[usize], error: impl Fn(usize) -> f64) -> Vec<f64> {
    let mut errors: Vec<f64> = (model.parameters().iter())
        .map(|parameter| match parameter.fixed {
            Some(_) => 0.0,
            None => f64::INFINITY,
        })
        .collect();
    for (place, &index) in free.iter().enumerate() {
        errors[index] = error(place);
    }
    errors
}

/// Returns the parameter vectors for growing parts of the logs.
fn trace(problem: &Problem<'_>, descent: &Descent, sums: &Sums) -> Vec<(f64, Theta)> {
    (sums.growing.iter())
        .filter_map(|(time, so_far)| {
            let z = values_alone(problem, descent, so_far)?;
            Some((*time, problem.unknowns.theta(&z)))
        })
        .collect()
}

/// Returns the estimate from each log alone.
fn each_log(problem: &Problem<'_>, descent: &Descent, sums: &Sums) -> Vec<Alone> {
    (sums.logs.iter())
        .filter_map(|log| alone(problem, descent, log))
        .collect()
}

/// Returns the scales of friction laws.
///
/// - `error`: standard error of an unknown, by its place.
fn friction_scales(
    unknowns: &Unknowns,
    z: &[f64],
    error: impl Fn(usize) -> f64,
) -> Vec<FrictionScale> {
    let first = unknowns.free.len() + unknowns.offsets.len();
    (unknowns.scales(z).enumerate())
        .map(|(i, of)| FrictionScale {
            joint: of.joint,
            scale: of.scale,
            value: of.value,
            // The unknown is the logarithm.
            standard_error: of.value * error(first + i),
        })
        .collect()
}

fn found_noise(problem: &Problem<'_>, unknowns: &Unknowns, levels: &Levels) -> FoundNoise {
    FoundNoise {
        rows: row_levels(problem, levels),
        corner: levels.corner,
        sensors: sensor_levels(problem, levels),
        presliding: (unknowns.presliding.iter())
            .map(|level| (level.joint, level.side, level.level))
            .collect(),
    }
}

fn row_levels(problem: &Problem<'_>, levels: &Levels) -> Vec<RowLevel> {
    (0..levels.disturbance.len())
        .map(|row| RowLevel {
            torque_noise: levels.torque_noise[row],
            reversal_noise: levels.reversal_noise[row],
            disturbance: levels.disturbance[row],
            torque: problem.measurements.torque_scale[row],
            // Only the disturbance is checked. White noise that the log does not determine may
            // reach its bound too, and an effect that the model lacks is slower than white noise.
            at_bound: problem.levels.disturbance_at_bound(levels, row),
        })
        .collect()
}

fn sensor_levels(problem: &Problem<'_>, levels: &Levels) -> Vec<SensorLevel> {
    (problem
        .measurements
        .sensors
        .iter()
        .zip(&levels.sensor_noise))
    // Levels of torque sensors have another unit.
    .filter(|(sensor, level)| **level > 0.0 && sensor.spring.is_none())
    .map(|(sensor, level)| SensorLevel {
        channel: sensor.channel,
        noise: *level,
        scale: sensor.scale,
    })
    .collect()
}
