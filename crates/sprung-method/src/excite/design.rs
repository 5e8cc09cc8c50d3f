//! The search for a motion: random starts, and continuation of the best.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use faer::Mat;
use rayon::prelude::*;

use super::assemble::problem;
use super::bounds::Limited;
use super::fourier::Series;
use super::information_matrix::Information;
use super::problem::Problem;
use super::search::{BARRIERS, Found, search};
use super::starts::{NoPose, inside, random_start, worst};
use super::task::{Frequencies, Task};
use crate::progress::{Listener, Phase};

/// Part of the steps after which only the best searches continue, and their number.
const FIRST_PART: usize = 5;
const GO_ON: usize = 2;

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

/// Returns the seed of a start; those of other seeds are others.
fn seed_of(seed: u64, start: usize) -> u64 {
    seed.wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .wrapping_add(start as u64)
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
    let first = if starts > GO_ON {
        settings.steps / FIRST_PART
    } else {
        0
    };
    let total = (starts * first + starts.min(GO_ON) * (settings.steps - first)) as u64;
    let done = AtomicU64::new(0);
    let stopped = AtomicBool::new(progress.tell(Phase::Designing, 0, Some(total)).is_err());
    let listener = Mutex::new(progress);
    let go_on = || {
        let count = done.fetch_add(1, Ordering::Relaxed) + 1;
        if let Ok(mut listener) = listener.lock()
            && listener
                .tell(Phase::Designing, count.min(total), Some(total))
                .is_err()
        {
            stopped.store(true, Ordering::Relaxed);
        }
        !stopped.load(Ordering::Relaxed)
    };
    let run = |problem: &mut Problem, x: &[f64], steps: usize, barriers: &[f64]| {
        let steps = if stopped.load(Ordering::Relaxed) {
            0
        } else {
            steps
        };
        let found = search(problem, x, steps, barriers, &mut |_| go_on());
        found.ok_or_else(|| {
            let no = worst(problem, x);
            // If a start is within the limits and has no value, the loop is unstable.
            if no.place < 1.0 {
                NoPose {
                    place: f64::INFINITY,
                    ..no
                }
            } else {
                no
            }
        })
    };
    let begun: Vec<Result<Found, NoPose>> = (0..starts)
        .into_par_iter()
        .map(|start| {
            let mut problem = problem.clone();
            let x = match from {
                Some(series) => {
                    let x = problem.free(series);
                    inside(&mut problem, &x, series)
                }
                None => random_start(&mut problem, seed_of(settings.seed, start)),
            }?;
            run(&mut problem, &x, first, &BARRIERS[..1])
        })
        .collect();
    let mut good: Vec<Found> = Vec::new();
    let mut last = None;
    for result in begun {
        match result {
            Ok(found) => good.push(found),
            Err(no) => last = Some(no),
        }
    }
    good.sort_by(|a, b| a.objective.total_cmp(&b.objective));
    let barriers = if from.is_some() {
        &BARRIERS[2..]
    } else {
        &BARRIERS[..]
    };
    let gone_on: Vec<Found> = (good.par_iter().take(GO_ON))
        .map(|begun| {
            let mut problem = problem.clone();
            match run(&mut problem, &begun.x, settings.steps - first, barriers) {
                Ok(found) if found.objective < begun.objective => found,
                Ok(_) | Err(_) => begun.clone(),
            }
        })
        .collect();
    for (start, found) in good.iter_mut().zip(gone_on) {
        *start = found;
    }
    good.sort_by(|a, b| a.objective.total_cmp(&b.objective));
    match (good.first(), last) {
        (Some(best), _) => Ok(Designed {
            series: problem.series(&best.x),
            objective: best.objective,
            of_starts: good.iter().map(|start| start.objective).collect(),
        }),
        (None, Some(no)) => Err(no),
        (None, None) => Err(NoPose {
            what: Limited::Position,
            joint: 0,
            place: f64::INFINITY,
        }),
    }
}

/// Returns the information of a motion about the free parameters by the surrogate of the search.
#[must_use]
pub fn information(
    task: &Task<'_>,
    frequencies: &Frequencies,
    series: &Series,
) -> Option<Information> {
    let free = task
        .model
        .parameters()
        .iter()
        .filter(|parameter| parameter.fixed.is_none());
    Information(matrix(task, frequencies, series)?).of_first(free.count())
}

/// Returns the information of a motion; nuisance parameters follow the free ones.
fn matrix(task: &Task<'_>, frequencies: &Frequencies, series: &Series) -> Option<Mat<f64>> {
    let mut problem = problem(task, frequencies, &[1.0; Limited::ALL.len()]);
    let scenario = problem.scenarios.first_mut()?;
    let moved = scenario.follows.run(&series.joints)?;
    Some(scenario.weighting.columns(&moved.entries).matrix)
}

/// Returns the value of the objective of a task for a motion; `None` if it does not determine all parameters.
#[must_use]
pub fn value_of(task: &Task<'_>, frequencies: &Frequencies, series: &Series) -> Option<f64> {
    let problem = problem(task, frequencies, &[1.0; Limited::ALL.len()]);
    let matrix = matrix(task, frequencies, series)?;
    problem.aim.judge(&matrix).map(|judged| judged.value)
}
