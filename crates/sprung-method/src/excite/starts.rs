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

/// Bisections of the size of a random motion.
const BISECTIONS: usize = 6;

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
            .fold(0.0, |most, own| most.max(own.place.abs()))
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
            let span = if orders[0].is_limited() {
                orders[0].half
            } else {
                1.0
            };
            let part = if attempt == 0 {
                0.0
            } else {
                rng.random_range(-0.7..0.7)
            };
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
