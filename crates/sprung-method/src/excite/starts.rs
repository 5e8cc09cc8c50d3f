//! Motions from which searches start.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::assemble::problem;
use super::bounds::Limited;
use super::fourier::Series;
use super::problem::{Peak, Problem};
use super::task::{Frequencies, Task};

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

/// Poses tried for a search, and random motions tried for each start.
const POSES: usize = 400;
const RANDOM_MOTIONS: usize = 3;

/// Poses whose neighbourhood is searched if none of those tried is good, and steps of each search.
const REFINED: usize = 4;
const STEPS: usize = 200;

/// Largest place of a pose with enough room for a motion within the limits.
const GOOD: f64 = 0.75;

/// Largest place of a pose about which the robot can move at all.
const LEAVES_ROOM: f64 = 0.97;

/// Bisections of the size of a random motion.
const BISECTIONS: usize = 6;
const MOST_BISECTIONS: usize = 30;

/// Returns the point of a series, with smaller amplitudes if it is outside.
pub(super) fn inside(
    problem: &mut Problem,
    x: &[f64],
    series: &Series,
) -> Result<Vec<f64>, NoPose> {
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
        peaks
            .iter()
            .fold(0.0, |most, peak| most.max(peak.place.abs()))
    })
}

pub(super) fn worst(problem: &mut Problem, x: &[f64]) -> NoPose {
    let none = Peak {
        what: Limited::Position,
        joint: 0,
        place: f64::INFINITY,
        time: 0.0,
    };
    let peaks = problem.peaks(x).unwrap_or_default();
    let worst = (peaks.into_iter()).max_by(|a, b| a.place.abs().total_cmp(&b.place.abs()));
    let Peak {
        what, joint, place, ..
    } = worst.unwrap_or(none);
    NoPose {
        what,
        joint,
        place: place.abs(),
    }
}

/// Returns a random motion within the limits: the best of several for the objective.
pub(super) fn random_start(problem: &mut Problem, seed: u64) -> Result<Vec<f64>, NoPose> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut best: Option<(f64, Vec<f64>)> = None;
    for _ in 0..RANDOM_MOTIONS {
        let x = random_motion(problem, &mut rng, 0.8)?;
        if let Some(value) = problem.value(&x, 0.01)
            && best
                .as_ref()
                .is_none_or(|(least, _)| value.objective < *least)
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
            .map(|i| {
                if is_centre[i] {
                    centres[i]
                } else {
                    factor * amplitudes[i]
                }
            })
            .collect()
    };
    // A pose near a limit leaves only a small motion.
    let part = part.max(0.5 * (1.0 + largest(problem, &at(0.0))));
    let (mut low, mut high) = (0.0, 1.0);
    while largest(problem, &at(high)) < part && high < 1e3 {
        low = high;
        high *= 2.0;
    }
    for bisection in 0..MOST_BISECTIONS {
        if bisection >= BISECTIONS && low > 0.0 {
            break;
        }
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
    let joints = problem.bases.len();
    let mut tried: Vec<(f64, Vec<f64>)> = Vec::new();
    for attempt in 0..POSES {
        let parts: Vec<f64> = (0..joints)
            .map(|_| match attempt {
                0 => 0.0,
                _ => rng.random_range(-0.7..0.7),
            })
            .collect();
        let x = at_rest(problem, &parts);
        let place = largest(problem, &x);
        if place < GOOD || (place < LEAVES_ROOM && attempt > POSES / 4) {
            return Ok(x);
        }
        tried.push((place, parts));
    }
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    // If few poses keep the limits, steps about the best ones find them.
    let mut best: Option<(f64, Vec<f64>)> = None;
    for from in tried.into_iter().take(REFINED) {
        let (place, parts) = refined(problem, from, rng);
        let x = at_rest(problem, &parts);
        if place < GOOD {
            return Ok(x);
        }
        if best.as_ref().is_none_or(|(least, _)| place < *least) {
            best = Some((place, x));
        }
    }
    match best {
        Some((place, x)) if place < LEAVES_ROOM => Ok(x),
        Some((_, x)) => Err(worst(problem, &x)),
        None => Ok(Vec::new()),
    }
}

/// Returns a pose near another one that keeps the limits better, and its largest place.
fn refined(
    problem: &mut Problem,
    (mut place, mut parts): (f64, Vec<f64>),
    rng: &mut ChaCha8Rng,
) -> (f64, Vec<f64>) {
    let mut step = 0.3;
    for _ in 0..STEPS {
        let near: Vec<f64> = (parts.iter())
            .map(|part| {
                let moved: f64 = rng.sample(StandardNormal);
                (part + step * moved).clamp(-0.95, 0.95)
            })
            .collect();
        let x = at_rest(problem, &near);
        let found = largest(problem, &x);
        if found < place {
            (place, parts) = (found, near);
            step *= 1.5;
        } else {
            step = (step * 0.95).max(1e-3);
        }
        if place < GOOD {
            break;
        }
    }
    (place, parts)
}

/// Returns the free numbers of a pose.
///
/// - `parts`: place of each joint between the middle of its range, 0, and its ends, ±1.
fn at_rest(problem: &Problem, parts: &[f64]) -> Vec<f64> {
    let mut x = Vec::new();
    for (joint, part) in parts.iter().enumerate() {
        let position = problem.bounds.joints[joint].orders[0];
        let span = if position.is_limited() {
            position.half
        } else {
            1.0
        };
        x.push((position.middle + part * span) / position.half.min(1.0));
        x.extend(std::iter::repeat_n(0.0, problem.bases[joint].count() - 1));
    }
    x
}
