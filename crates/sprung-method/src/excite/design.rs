//! The search for an experiment: its frequencies, its starts, and the best motion within the limits.

use std::f64::consts::TAU;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::prelude::*;

use super::bounds::{Bounds, Limited};
use super::followed::Followed;
use super::fourier::{Basis, Series};
use super::information::Weighting;
use super::kinematics::Kinematics;
use super::motion::Follows;
use super::noise::{Errors, Fastest};
use super::objective::judge;
use super::physics::Physics;
use super::promise::Information;
use super::problem::{Peak, Problem, Scenario};
use super::search::{BARRIERS, Found, search};
use super::simulated::Simulated;
use crate::description::{Controller, Excite};
use crate::model::{Model, Parameter};
use crate::progress::{Listener, Phase};

/// What is to be designed.
#[derive(Clone, Debug)]
pub struct Task<'a> {
    /// The robot's equations.
    pub model: &'a Model,
    /// Its values as far as they are known, \[p\].
    pub theta: &'a [f64],
    /// Settings.
    pub settings: &'a Excite,
    /// Limits, without margins.
    pub bounds: &'a Bounds,
    /// Errors of the sensors, and disturbances.
    pub errors: &'a Errors,
    /// PD controller of the motors that will run; `None` if the links follow the reference.
    pub controller: Option<&'a Controller>,
    /// Places of links and tool, if the description has lengths.
    pub kinematics: Option<&'a Kinematics>,
    /// Information of earlier experiments, \[free × free\].
    pub known: Option<&'a Information>,
    /// Free parameters that count, places among the free ones; all if empty.
    pub chosen: &'a [usize],
}

/// A motion that a search found.
#[derive(Clone, Debug)]
pub struct Designed {
    /// The motion.
    pub series: Series,
    /// Value of the objective: a logarithm of standard errors.
    pub objective: f64,
    /// Values of the objective of all searches, the best first.
    pub of_starts: Vec<f64>,
}

/// Why there is no motion within the limits.
#[derive(Clone, Debug, PartialEq)]
pub struct NoPose {
    /// The limit that the best pose breaks most.
    pub what: Limited,
    /// Its joint.
    pub joint: usize,
    /// Largest place of that pose; 1 at the limit.
    pub place: f64,
}

/// Most free numbers of a search.
const MOST_FREE: usize = 140;

/// Frequencies of the information, as a multiple of the highest one of the reference and of the fastest resonance.
const LINES_PER_HARMONIC: f64 = 3.0;
const LINES_PER_RESONANCE: f64 = 1.5;

/// Most frequencies of the information.
const MOST_LINES: usize = 250;

/// Poses tried for a search, and random motions tried for each start.
const POSES: usize = 400;
const RANDOM_MOTIONS: usize = 3;

/// Bisections of the size of a random motion.
const BISECTIONS: usize = 6;

/// Part of the steps after which only the best searches go on, and their number.
const FIRST_PART: usize = 5;
const GO_ON: usize = 2;

/// The frequencies of a motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Frequencies {
    /// Lowest angular frequency, rad/s.
    pub rate: f64,
    /// Multiples of it.
    pub harmonics: Vec<usize>,
    /// Number of periods.
    pub periods: usize,
}

impl Frequencies {
    /// Chooses the frequencies of a task.
    #[must_use]
    pub fn of(task: &Task<'_>) -> Self {
        let settings = task.settings;
        let base = settings.base_frequency_hz.unwrap_or(1.0 / settings.duration_s);
        let periods = (settings.duration_s * base + 1e-9).floor().max(1.0) as usize;
        let n = task.model.joint_count();
        let resonances = Fastest::of(task.model, task.theta).resonances;
        let most = (MOST_FREE / n / 2).max(3);
        let wanted = settings.harmonics.unwrap_or_else(|| {
            let by_limits = (task.bounds.joints.iter()).filter_map(|own| {
                let [_, velocity, acceleration, _] = own.orders;
                (velocity.is_limited() && acceleration.is_limited())
                    .then(|| 2.0 * acceleration.half / velocity.half / TAU)
            });
            let top = by_limits.chain(resonances.iter().map(|hz| 1.2 * hz)).fold(1.0, f64::max);
            ((top / base).ceil() as usize).clamp(4, most.min(40))
        });
        let mut harmonics: Vec<usize> = (1..=wanted).collect();
        if settings.resonances {
            for hz in resonances {
                let middle = (hz / base).round() as usize;
                harmonics.extend([middle.saturating_sub(1), middle, middle + 1]);
            }
            harmonics.retain(|own| *own > 0);
            harmonics.sort_unstable();
            harmonics.dedup();
        }
        Self {
            rate: TAU * base,
            harmonics,
            periods,
        }
    }

    /// Returns the length of the motion, s.
    #[must_use]
    pub fn duration(&self) -> f64 {
        TAU / self.rate * self.periods as f64
    }
}

/// Returns the problem of a task.
pub(super) fn problem(task: &Task<'_>, frequencies: &Frequencies, parts: &[f64; Limited::ALL.len()]) -> Problem {
    let model = task.model;
    let n = model.joint_count();
    let Frequencies { rate, harmonics, periods } = frequencies;
    let bounds = task.bounds.narrowed(parts);
    let bases = (0..n)
        .map(|joint| {
            let orders = &bounds.joints[joint].orders;
            let size = |multiple: usize| {
                let rate = rate * multiple as f64;
                let limits = orders.iter().enumerate();
                let by_limits = limits.map(|(order, own)| own.half / rate.powi(order as i32));
                by_limits.fold(1.0 / multiple as f64, f64::min)
            };
            let sizes: Vec<f64> = harmonics.iter().map(|&multiple| size(multiple)).collect();
            Basis::new(harmonics, &sizes, orders[0].half.min(1.0))
        })
        .collect();
    let speeds = Fastest::of(model, task.theta);
    let most = harmonics.last().copied().unwrap_or(1);
    let fast = speeds.resonances.iter().fold(0.0, |most: f64, hz| most.max(*hz));
    let period = if task.controller.is_some() { frequencies.duration() } else { TAU / rate };
    let base = 1.0 / period;
    let top = (LINES_PER_HARMONIC * most as f64 * rate / TAU).max(LINES_PER_RESONANCE * fast);
    let lines = ((top / base).ceil() as usize + 1).clamp(8, MOST_LINES.max(2 * most * periods));
    let per_period = if task.controller.is_some() { *periods } else { 1 };
    let samples = (5 * lines / 2).max(16 * most * per_period).next_multiple_of(2);
    let repeats = if task.controller.is_some() { 1 } else { *periods };
    let free = (model.parameters().iter()).filter(|own| own.fixed.is_none()).count();
    let chosen = if task.chosen.is_empty() { (0..free).collect() } else { task.chosen.to_vec() };
    let poses = vec![(0..n).map(|joint| bounds.joints[joint].orders[0].middle).collect::<Vec<f64>>()];
    let scales = scales(model, task.theta, task.bounds);
    let scenarios = draws(task)
        .into_iter()
        .map(|theta| {
            let follows = match task.controller {
                None => {
                    let physics = Physics::new(model, &theta);
                    Follows::Exactly(Followed::new(physics, *rate, harmonics, samples))
                }
                Some(controller) => {
                    let physics = Physics::new(&speeds.softened(model), &theta);
                    let sample = period / samples as f64;
                    let every = (sample / speeds.step).ceil().max(1.0) as usize;
                    Follows::Loop(Simulated::new(
                        physics,
                        controller,
                        (*rate, harmonics),
                        (sample / every as f64, every, samples),
                    ))
                }
            };
            let weighting =
                Weighting::new(model, &theta, task.errors, &poses, (samples, period, lines), repeats)
                    .with_known(task.known.map(|own| &own.0), &scales);
            Scenario { theta, follows, weighting }
        })
        .collect();
    Problem::new(
        model,
        (*rate, harmonics.clone()),
        bases,
        bounds,
        scenarios,
        task.kinematics.cloned(),
        (task.settings.objective, scales, chosen),
        (samples, period / samples as f64),
    )
}

/// Returns the values to which errors of the free parameters are relative: their own, but at least a part of the largest
/// one with the same unit; torques of zero, such as offsets, to a part of the largest torque of their joint.
#[must_use]
pub fn scales(model: &Model, theta: &[f64], bounds: &Bounds) -> Vec<f64> {
    let torque = |own: &Parameter, value: f64| match own.joint {
        Some((_, joint)) if value == 0.0 && own.unit == "N·m" => {
            let limit = bounds.joints[joint].torque;
            if limit.is_limited() { SMALL_PART * limit.half } else { 0.0 }
        }
        _ => 0.0,
    };
    let all: Vec<_> = model.parameters().iter().zip(theta).collect();
    let largest = |unit: &str| {
        (all.iter().filter(|(own, _)| own.unit == unit))
            .fold(0.0, |most: f64, (_, value)| most.max(value.abs()))
    };
    (all.iter())
        .filter(|(own, _)| own.fixed.is_none())
        .map(|(own, value)| {
            let least = (SMALL_PART * largest(own.unit)).max(torque(own, **value));
            let scale = value.abs().max(least);
            if scale > 0.0 { scale } else { 1.0 }
        })
        .collect()
}

/// Part of the largest parameter with the same unit to which the error of a smaller one is relative.
const SMALL_PART: f64 = 0.01;

/// Returns the sets of values of a task: the given one, or draws about it.
pub(super) fn draws(task: &Task<'_>) -> Vec<Vec<f64>> {
    let error = task.settings.value_error;
    if error == 0.0 {
        return vec![task.theta.to_vec()];
    }
    let mut rng = ChaCha8Rng::seed_from_u64(task.settings.seed ^ 0x0d1a);
    (0..task.settings.draws)
        .map(|_| {
            let mut factor = || (1.0 + error).powf(rng.random_range(-1.0..1.0));
            // One factor for all masses keeps them those of a robot that can exist.
            let of_masses = factor();
            let parameters = task.model.parameters().iter().zip(task.theta);
            parameters
                .map(|(own, value)| match (own.fixed, own.joint) {
                    (Some(_), _) => *value,
                    (None, None) => value * of_masses,
                    (None, Some(_)) => value * factor(),
                })
                .collect()
        })
        .collect()
}

/// Designs a motion.
///
/// # Errors
///
/// [`NoPose`] if no pose keeps the limits at rest.
pub(super) fn design(
    task: &Task<'_>,
    frequencies: &Frequencies,
    parts: &[f64; Limited::ALL.len()],
    from: Option<&Series>,
    progress: &mut dyn Listener,
) -> Result<Designed, NoPose> {
    let settings = task.settings;
    let problem = problem(task, frequencies, parts);
    let starts = if from.is_some() { 1 } else { settings.starts };
    let first = if starts > GO_ON { settings.steps / FIRST_PART } else { 0 };
    let total = (starts * first + starts.min(GO_ON) * (settings.steps - first)) as u64;
    let done = AtomicU64::new(0);
    let stopped = AtomicBool::new(progress.tell(Phase::Designing, 0, Some(total)).is_err());
    let listener = Mutex::new(progress);
    let go_on = || {
        let count = done.fetch_add(1, Ordering::Relaxed) + 1;
        if let Ok(mut listener) = listener.lock()
            && listener.tell(Phase::Designing, count.min(total), Some(total)).is_err()
        {
            stopped.store(true, Ordering::Relaxed);
        }
        !stopped.load(Ordering::Relaxed)
    };
    let run = |own: &mut Problem, x: &[f64], steps: usize, barriers: &[f64]| {
        let steps = if stopped.load(Ordering::Relaxed) { 0 } else { steps };
        let found = search(own, x, steps, barriers, &mut |_| go_on());
        found.ok_or_else(|| {
            let no = worst(own, x);
            // Within the limits no value means that the loop has no motion.
            if no.place < 1.0 { NoPose { place: f64::INFINITY, ..no } } else { no }
        })
    };
    let begun: Vec<Result<Found, NoPose>> = (0..starts)
        .into_par_iter()
        .map(|start| {
            let mut own = problem.clone();
            let x = match from {
                Some(series) => {
                    let x = own.free(series);
                    inside(&mut own, &x, series)
                }
                None => random_start(&mut own, settings.seed.wrapping_add(start as u64)),
            }?;
            run(&mut own, &x, first, &BARRIERS[..1])
        })
        .collect();
    let mut good: Vec<Found> = Vec::new();
    let mut last = None;
    for own in begun {
        match own {
            Ok(found) => good.push(found),
            Err(no) => last = Some(no),
        }
    }
    good.sort_by(|a, b| a.objective.total_cmp(&b.objective));
    let barriers = if from.is_some() { &BARRIERS[2..] } else { &BARRIERS[..] };
    let gone_on: Vec<Found> = (good.par_iter().take(GO_ON))
        .filter_map(|begun| {
            let mut own = problem.clone();
            let found = run(&mut own, &begun.x, settings.steps - first, barriers).ok()?;
            Some(if found.objective < begun.objective { found } else { begun.clone() })
        })
        .collect();
    for (own, found) in good.iter_mut().zip(gone_on) {
        *own = found;
    }
    good.sort_by(|a, b| a.objective.total_cmp(&b.objective));
    match (good.first(), last) {
        (Some(best), _) => Ok(Designed {
            series: problem.series(&best.x),
            objective: best.objective,
            of_starts: good.iter().map(|own| own.objective).collect(),
        }),
        (None, Some(no)) => Err(no),
        (None, None) => Err(NoPose {
            what: Limited::Position,
            joint: 0,
            place: f64::INFINITY,
        }),
    }
}

/// Returns the point of a series, with smaller amplitudes if it is outside.
fn inside(problem: &mut Problem, x: &[f64], series: &Series) -> Result<Vec<f64>, NoPose> {
    let mut x = x.to_vec();
    let mut factor = 1.0;
    for _ in 0..30 {
        if largest(problem, &x) < 0.995 {
            return Ok(x);
        }
        factor *= 0.97;
        x = problem.free(&series.scaled(factor));
    }
    Err(worst(problem, &x))
}

fn largest(problem: &mut Problem, x: &[f64]) -> f64 {
    problem.peaks(x).map_or(f64::INFINITY, |peaks| {
        peaks.iter().fold(0.0, |most, own| most.max(own.place.abs()))
    })
}

fn worst(problem: &mut Problem, x: &[f64]) -> NoPose {
    let none = Peak {
        what: Limited::Position,
        joint: 0,
        place: f64::INFINITY,
        time: 0.0,
    };
    let peaks = problem.peaks(x).unwrap_or_default();
    let worst = (peaks.into_iter()).max_by(|a, b| a.place.abs().total_cmp(&b.place.abs()));
    let Peak { what, joint, place, .. } = worst.unwrap_or(none);
    NoPose { what, joint, place: place.abs() }
}

/// Returns a random motion within the limits: the best of several for the objective.
fn random_start(problem: &mut Problem, seed: u64) -> Result<Vec<f64>, NoPose> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut best: Option<(f64, Vec<f64>)> = None;
    for _ in 0..RANDOM_MOTIONS {
        let x = random_motion(problem, &mut rng, 0.8)?;
        if let Some(value) = problem.value(&x, 0.01)
            && best.as_ref().is_none_or(|(least, _)| value.objective < *least)
        {
            best = Some((value.objective, x));
        }
    }
    match best {
        Some((_, x)) => Ok(x),
        None => random_motion(problem, &mut rng, 0.5),
    }
}

/// Returns a random motion whose largest place is `part` of the limits.
pub(super) fn random_motion(
    problem: &mut Problem,
    rng: &mut ChaCha8Rng,
    part: f64,
) -> Result<Vec<f64>, NoPose> {
    let count = problem.count();
    let centres = pose(problem, rng)?;
    let amplitudes: Vec<f64> = (0..count).map(|_| rng.sample(StandardNormal)).collect();
    let is_centre: Vec<bool> = (problem.bases.iter())
        .flat_map(|basis| (0..basis.count()).map(|k| k == 0))
        .collect();
    let at = |factor: f64| -> Vec<f64> {
        (0..count)
            .map(|i| if is_centre[i] { centres[i] } else { factor * amplitudes[i] })
            .collect()
    };
    let (mut low, mut high) = (0.0, 1.0);
    while largest(problem, &at(high)) < part && high < 1e3 {
        low = high;
        high *= 2.0;
    }
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if largest(problem, &at(middle)) < part {
            low = middle;
        } else {
            high = middle;
        }
    }
    Ok(at(low))
}

/// Returns a random motion whose largest place is `part` of the limits.
///
/// # Errors
///
/// [`NoPose`] if no pose keeps the limits at rest.
pub fn random(
    task: &Task<'_>,
    frequencies: &Frequencies,
    part: f64,
    seed: u64,
) -> Result<Series, NoPose> {
    let mut problem = problem(task, frequencies, &[1.0; Limited::ALL.len()]);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let x = random_motion(&mut problem, &mut rng, part)?;
    Ok(problem.series(&x))
}

/// Returns free numbers of a random pose that keeps the limits at rest.
fn pose(problem: &mut Problem, rng: &mut ChaCha8Rng) -> Result<Vec<f64>, NoPose> {
    let mut least: Option<(f64, Vec<f64>)> = None;
    for attempt in 0..POSES {
        let mut x = Vec::new();
        for joint in 0..problem.bases.len() {
            let orders = problem.bounds.joints[joint].orders;
            let span = if orders[0].is_limited() { orders[0].half } else { 1.0 };
            let part = if attempt == 0 { 0.0 } else { rng.random_range(-0.7..0.7) };
            let scale = orders[0].half.min(1.0);
            x.push((orders[0].middle + part * span) / scale);
            x.extend(std::iter::repeat_n(0.0, problem.bases[joint].count() - 1));
        }
        let place = largest(problem, &x);
        if place < 0.75 || (place < 0.98 && attempt > POSES / 4) {
            return Ok(x);
        }
        if least.as_ref().is_none_or(|(own, _)| place < *own) {
            least = Some((place, x));
        }
    }
    match least {
        Some((place, x)) if place < 0.995 => Ok(x),
        Some((_, x)) => Err(worst(problem, &x)),
        None => Ok(Vec::new()),
    }
}

/// Returns the information of a motion by the surrogate of the search; nuisance parameters follow the free ones.
#[must_use]
pub fn information(
    task: &Task<'_>,
    frequencies: &Frequencies,
    series: &Series,
) -> Option<Information> {
    let mut problem = problem(task, frequencies, &[1.0; Limited::ALL.len()]);
    let scenario = problem.scenarios.first_mut()?;
    let moved = scenario.follows.run(&series.joints)?;
    Some(Information(scenario.weighting.columns(&moved.entries).matrix))
}

/// Returns the value of the objective of a task for a motion; `None` if it does not determine all parameters.
#[must_use]
pub fn value_of(task: &Task<'_>, frequencies: &Frequencies, series: &Series) -> Option<f64> {
    let problem = problem(task, frequencies, &[1.0; Limited::ALL.len()]);
    let matrix = information(task, frequencies, series)?.0;
    judge(problem.objective, &matrix, &problem.scales, &problem.chosen).map(|own| own.value)
}
