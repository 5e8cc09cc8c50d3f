//! From a task to the problem that a search solves.

use std::f64::consts::TAU;

use super::bounds::Limited;
use super::followed::Followed;
use super::follows::Follows;
use super::fourier::Basis;
use super::information::{Grid, Weighting};
use super::noise::Fastest;
use super::objective::Aim;
use super::physics::Physics;
use super::problem::{Problem, Scenario};
use super::simulated::{Simulated, Steps};
use super::task::{Frequencies, Task, draws, scales};

/// Frequencies of the information, as a multiple of the highest one of the reference and of the fastest resonance.
const LINES_PER_HARMONIC: f64 = 3.0;
const LINES_PER_RESONANCE: f64 = 1.5;

/// Most frequencies of the information.
const MOST_LINES: usize = 250;

/// Returns the problem of a task.
pub(super) fn problem(
    task: &Task<'_>,
    frequencies: &Frequencies,
    parts: &[f64; Limited::ALL.len()],
) -> Problem {
    let model = task.model;
    let n = model.joint_count();
    let Frequencies {
        rate,
        harmonics,
        periods,
    } = frequencies;
    let bounds = task.bounds.narrowed(parts);
    let bases = (0..n)
        .map(|joint| {
            let orders = &bounds.joints[joint].orders;
            let size = |multiple: usize| {
                let rate = rate * multiple as f64;
                let limits = orders.iter().enumerate();
                let by_limits =
                    limits.map(|(order, interval)| interval.half / rate.powi(order as i32));
                by_limits.fold(1.0 / multiple as f64, f64::min)
            };
            let sizes: Vec<f64> = harmonics.iter().map(|&multiple| size(multiple)).collect();
            Basis::new(harmonics, &sizes, orders[0].half.min(1.0))
        })
        .collect();
    let speeds = Fastest::of(model, task.theta);
    let most = harmonics.last().copied().unwrap_or(1);
    let fast = speeds
        .resonances
        .iter()
        .fold(0.0, |most: f64, hz| most.max(*hz));
    // A loop is simulated over some periods, because it begins at rest; further periods add no information.
    let simulated = (*periods).min((MOST_LINES / most).max(1));
    let length = if task.controller.is_some() {
        simulated
    } else {
        1
    };
    let period = TAU / rate * length as f64;
    let repeats = *periods as f64 / length as f64;
    let top = (LINES_PER_HARMONIC * most as f64 * rate / TAU).max(LINES_PER_RESONANCE * fast);
    let lines = ((top * period).ceil() as usize + 1).clamp(8, MOST_LINES.max(2 * most * length));
    let samples = (5 * lines / 2).max(16 * most * length).next_multiple_of(2);
    let free = (model.parameters().iter())
        .filter(|parameter| parameter.fixed.is_none())
        .count();
    let chosen = if task.chosen.is_empty() {
        (0..free).collect()
    } else {
        task.chosen.to_vec()
    };
    let poses = vec![
        (0..n)
            .map(|joint| bounds.joints[joint].orders[0].middle)
            .collect::<Vec<f64>>(),
    ];
    let scales = scales(model, task.theta, task.bounds);
    let scenarios = (draws(task).into_iter())
        .map(|theta| {
            let grid = Grid {
                samples,
                duration: period,
                lines,
            };
            let weighting = Weighting::new(model, &theta, task.errors, &poses, &grid, repeats);
            let known = task.known.map(|information| &information.0);
            Scenario {
                follows: follows(task, frequencies, &speeds, &theta, (samples, period)),
                weighting: weighting.with_known(known, &scales),
                theta,
            }
        })
        .collect();
    Problem::new(
        model,
        (*rate, harmonics.clone()),
        bases,
        bounds,
        scenarios,
        task.kinematics.cloned(),
        Aim {
            objective: task.settings.objective,
            scales,
            chosen,
        },
        (samples, period / samples as f64),
    )
}

/// Returns how a robot with some values follows its reference.
fn follows(
    task: &Task<'_>,
    frequencies: &Frequencies,
    speeds: &Fastest,
    theta: &[f64],
    (samples, period): (usize, f64),
) -> Follows {
    let (rate, harmonics) = (frequencies.rate, frequencies.harmonics.as_slice());
    let Some(controller) = task.controller else {
        let physics = Physics::new(task.model, theta);
        return Follows::Exactly(Followed::new(physics, rate, harmonics, samples));
    };
    let physics = Physics::new(&speeds.softened(task.model), theta);
    let sample = period / samples as f64;
    let every = (sample / speeds.step).ceil().max(1.0) as usize;
    let steps = Steps {
        step: sample / every as f64,
        every,
        samples,
    };
    Follows::Loop(Simulated::new(
        physics,
        controller,
        (rate, harmonics),
        steps,
    ))
}
