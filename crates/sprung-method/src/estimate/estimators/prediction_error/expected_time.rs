//! Expected duration of a refinement.

use std::sync::Arc;

use super::dynamics::Dynamics;
use super::filter::{Keep, run};
use super::levels::Levels;
use super::measurements::{MAX_SEARCH_WORK, Measurements, Segment};
use super::problem::Problem;
use crate::stopwatch::Stopwatch;

/// Number of samples of the filter run whose time is measured.
const SAMPLES: usize = 200;

/// Usual duration of a refinement over that of one run of the filter. A refinement runs it six to
/// twelve times, searches levels after each run, and ends with two runs with more unknowns.
const RUNS: f64 = 24.0;

/// Returns the expected duration of a refinement, s; `None` if it is short.
///
/// - `z`, `levels`: its start.
pub(super) fn expected_seconds(
    problem: &Problem<'_>,
    (z, levels): (&[f64], &Levels),
) -> Option<f64> {
    let measurements = problem.measurements;
    let samples: usize = (measurements.segments.iter()).map(Segment::samples).sum();
    if samples * problem.model.coordinates().pow(2) < MAX_SEARCH_WORK {
        return None;
    }
    let beginning = Measurements {
        segments: Arc::new(vec![measurements.segments.first()?.beginning(SAMPLES)]),
        ..measurements.without_segments()
    };
    let dynamics = Dynamics::new(problem.model, &problem.unknowns.theta(z));
    let begin = Stopwatch::start();
    run(
        &beginning,
        &dynamics,
        problem.unknowns,
        (z, levels),
        Keep::default(),
        |_, _| (),
    )?;
    let threads = rayon::current_num_threads().min(measurements.segments.len());
    let runs = samples as f64 / beginning.samples().max(1) as f64;
    Some(begin.seconds() * runs * RUNS / threads as f64)
}
