//! Descent from a start to the parameters with the greatest likelihood.
//!
//! A Gauss-Newton step holds the filter's gains. The next run computes new gains, with new levels
//! of the noise and the disturbances. At the true parameters the innovations correlate with their
//! derivatives only by noise of the logged torque. The expectation of this correlation is
//! subtracted, so the gains affect the precision of the estimate but do not bias it.

use super::constrained::step;
use super::dynamics::Dynamics;
use super::filter::{FilterRun, Keep, NormalEquations, Trajectory, replay, run};
use super::level_search::search_levels;
use super::levels::Levels;
use super::likelihood::{LevelLikelihood, Searched};
use super::noisy_torque::{MAX_NOISE_SHARE, NoiseBias, NoiseSource};
use super::problem::{Problem, add_prior};
use super::solve::length;
use super::vector::add;
use crate::estimate::estimators::damping::{Damping, MAX_TRIES};
use crate::estimate::estimators::prediction_error::state_layout::transition_size;
use crate::estimate::statistics::{
    LARGE_SHARE, MAX_ITERATIONS, MAX_ROUNDS, MIN_COST_SAVED, SHORT_STEP_SIGMAS,
};
use crate::progress::{Listener, Phase, Stopped};

/// First run whose step is taken. Start levels may be wrong by orders of magnitude, so the levels are searched first. A
/// step in the first run moves an estimate by 1.6 standard errors.
const FIRST_STEP: usize = 2;

/// Last run after which levels are searched. If the model lacks an effect, step and levels may
/// alternate without end; with the levels held, the steps become short.
const LAST_LEVEL_SEARCH: usize = 18;

/// The levels have settled if their search raises the log-likelihood by less than this value.
const SETTLED_GAIN: f64 = 0.5;

/// A descent ends if its residual in the filtered torque exceeds that of least squares by this factor in several
/// successive runs without falling, because its predictions of held-out folds will not be better. The first runs may
/// pass through such values while the levels are still wrong.
const MAX_RESIDUAL_RATIO: f64 = 1.3;

/// Successive runs above the limit, or in which noise of the logged torque explains all information in some direction;
/// one or two occur while levels are far off. With more, the search would go to zero inertia.
const MAX_RUNS_ABOVE: usize = 3;

/// Runs before it find the levels.
const FIRST_COMPARED_RUN: usize = 5;

/// Maximum number of entries of the transitions about which levels are searched. They stay in
/// memory.
const MAX_TRANSITION_NUMBERS: usize = 9_000_000;

/// While a search for levels gains more log-likelihood than this value, the levels are far from their optimum, and this
/// fraction of each searched segment suffices. Half the value moves an estimate by 0.02 standard errors, twice the
/// value has no effect.
const FAR_GAIN: f64 = 100.0;

/// Share of each segment that suffices while the levels are far from their optimum; the cost is proportional to it.
/// Half or twice the value moves an estimate by 0.05 standard errors.
const FAR_SHARE: f64 = 0.4;

/// Reason why a descent ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ending {
    /// The last step was short and the levels had settled.
    Converged,
    /// A disturbance stayed at its upper bound.
    AtBound,
    /// The parameters explained far less of the filtered torque than least squares.
    GivenUp,
    /// The noise of the logged torque explained all information in some direction.
    OnlyNoise,
    /// The filter ran [`MAX_ITERATIONS`] times.
    OutOfRuns,
}

/// End of a descent.
#[derive(Clone, Debug)]
pub(super) struct Descent {
    /// Values of the unknowns.
    pub(super) z: Vec<f64>,
    pub(super) levels: Levels,
    /// Number of runs of the filter.
    pub(super) runs: usize,
    /// Sum of the squared whitened innovations, and number of measurements.
    pub(super) cost: f64,
    pub(super) measurements: u64,
    pub(super) ending: Ending,
    /// Last move of each unknown, in standard errors.
    pub(super) moved: Vec<f64>,
}

/// A step that lowers the cost.
struct Step {
    by: Vec<f64>,
    saved: f64,
    /// Trajectories of the segments after the step, with the gains held.
    trajectories: Vec<Trajectory>,
}

/// The normal equations at the unknowns of a run, with the prior and corrected for the noise of the
/// torque.
struct Gradient {
    cost: f64,
    normal: NormalEquations,
    /// Bias by noise of the logged torque, already subtracted.
    by_noise: NoiseBias,
    /// Whether its information exceeds the whole information in some direction.
    is_only_noise: bool,
}

/// Descends from a start: run, step, levels, until step and levels have settled.
///
/// - `z`, `levels`: the start.
/// - `progress`: is called before each run of the filter, with its phase.
///
/// Returns `None` if the filter does not follow the log from the start.
///
/// # Errors
///
/// [`Stopped`] if the listener requests a stop.
pub(super) fn descend(
    problem: &Problem<'_>,
    (mut z, mut levels): (Vec<f64>, Levels),
    phase: Phase,
    progress: &mut dyn Listener,
) -> Result<Option<Descent>, Stopped> {
    let (measurements, unknowns) = (problem.measurements, problem.unknowns);
    let rows = problem.model.coordinates();
    let dynamics = Dynamics::new(problem.model, &unknowns.theta(&z));
    let samples = MAX_TRANSITION_NUMBERS / transition_size(rows);
    let searched = Searched::new(measurements, samples);
    let few = searched.beginnings(FAR_SHARE);
    let keep = Keep {
        linearization: true,
        ..Keep::default()
    };
    let mut damping = Damping::first();
    let mut search = LevelSearch::default();
    let mut moved = vec![0.0; z.len()];
    for runs in 1..=MAX_ITERATIONS {
        progress.tell(phase, runs as u64, Some(MAX_ITERATIONS as u64))?;
        let noise = NoiseSource::new(problem, (&z, &levels));
        let ran = run(
            measurements,
            &dynamics,
            unknowns,
            (&z, &levels),
            keep,
            |index, of_segment| {
                let bias = noise.bias(index, of_segment);
                if !searched.contains(index) {
                    of_segment.drop_linearization();
                }
                bias
            },
        );
        let Some((mut ran, biases)) = ran else {
            return Ok(None);
        };
        let gradient = gradient(problem, &ran, &z, &biases);
        let step = lower(problem, &dynamics, &ran, &gradient, &z, &mut damping);
        let short = match &step {
            None => true,
            Some(step) => is_short(step, &gradient.normal, &mut moved),
        };
        search.compare(problem, &z, runs);
        search.noise = if gradient.is_only_noise {
            search.noise + 1
        } else {
            0
        };
        if let Some(ending) = search.ending(short, runs) {
            return Ok(Some(Descent {
                z,
                levels,
                runs,
                cost: ran.sums.cost,
                measurements: ran.sums.measurements,
                ending,
                moved,
            }));
        }
        if let Some(step) = step.filter(|_| runs >= FIRST_STEP) {
            add(&mut z, 1.0, &step.by);
            // Levels are searched about the new trajectory. About the old one, step and levels
            // would oscillate about the optimum.
            ran.set_trajectories(step.trajectories);
        }
        if runs > LAST_LEVEL_SEARCH {
            search.settled = true;
        } else {
            levels = search.levels(problem, &ran, [&few, &searched], &levels);
        }
    }
    Ok(None)
}

/// State of the search for levels.
#[derive(Clone, Copy, Debug, Default)]
struct LevelSearch {
    /// Whether a search gained less than `FAR_GAIN`.
    near: bool,
    /// Whether the last search gained less than `SETTLED_GAIN`.
    settled: bool,
    /// Number of successive searches with a disturbance at its upper bound.
    at_bound: usize,
    /// Number of successive runs whose residual is far above that of least squares.
    above: usize,
    /// Residual of the last run over that of least squares.
    ratio: f64,
    /// Number of successive runs in which noise explains all information in some direction.
    noise: usize,
}

impl LevelSearch {
    /// Compares the residual in the filtered torque with that of least squares.
    fn compare(&mut self, problem: &Problem<'_>, z: &[f64], runs: usize) {
        let Some(guard) = problem.guard.filter(|_| runs >= FIRST_COMPARED_RUN) else {
            return;
        };
        let before = self.ratio;
        self.ratio = guard.ratio(&problem.unknowns.theta(z));
        if self.ratio <= MAX_RESIDUAL_RATIO {
            self.above = 0;
        } else if self.ratio > (1.0 - LARGE_SHARE) * before {
            // A residual that falls by more still approaches least squares.
            self.above += 1;
        }
    }

    /// Searches the levels about the trajectory of a run, at first about the beginnings of segments.
    fn levels(
        &mut self,
        problem: &Problem<'_>,
        run: &FilterRun,
        [few, all]: [&Searched; 2],
        levels: &Levels,
    ) -> Levels {
        let about = |segments| LevelLikelihood::new(problem.measurements, run, segments);
        let mut levels = levels.clone();
        if !self.near {
            let found = search_levels(&about(few), problem.levels, &levels);
            self.near = found.1 < FAR_GAIN;
            levels = found.0;
        }
        if self.near {
            let found = search_levels(&about(all), problem.levels, &levels);
            self.settled = found.1 < SETTLED_GAIN;
            levels = found.0;
        }
        let mut rows = 0..problem.model.coordinates();
        let bound = rows.any(|row| problem.levels.disturbance_at_bound(&levels, row));
        self.at_bound = if bound { self.at_bound + 1 } else { 0 };
        levels
    }

    /// Returns the reason to end the descent after a run; `None` to go on.
    ///
    /// - `short`: whether the step of this run is short.
    fn ending(&self, short: bool, runs: usize) -> Option<Ending> {
        if short && self.settled {
            Some(Ending::Converged)
        } else if self.above == MAX_RUNS_ABOVE {
            Some(Ending::GivenUp)
        } else if self.noise == MAX_RUNS_ABOVE {
            Some(Ending::OnlyNoise)
        } else if self.at_bound == MAX_ROUNDS {
            // The model lacks an effect that no disturbance can replace.
            Some(Ending::AtBound)
        } else if runs == MAX_ITERATIONS {
            Some(Ending::OutOfRuns)
        } else {
            None
        }
    }
}

/// Returns cost and normal equations at the unknowns of a run.
///
/// - `biases`: by noise of the logged torque, of each segment.
fn gradient(problem: &Problem<'_>, run: &FilterRun, z: &[f64], biases: &[NoiseBias]) -> Gradient {
    let mut by_noise = NoiseBias::zero(problem.unknowns.values());
    for bias in biases {
        by_noise.add(bias);
    }
    let mut normal = run.sums.normal.clone();
    let cost = run.sums.cost + add_prior(problem.unknowns, z, &mut normal);
    let limit = by_noise.limit(&normal);
    by_noise.scale_information(limit);
    by_noise.correct(&mut normal);
    Gradient {
        cost,
        normal,
        by_noise,
        is_only_noise: limit < MAX_NOISE_SHARE,
    }
}

/// Returns whether a step is short. Writes the move of each unknown in standard errors.
fn is_short(step: &Step, normal: &NormalEquations, moved: &mut [f64]) -> bool {
    let information = &normal.information;
    for (i, (moved, by)) in moved.iter_mut().zip(&step.by).enumerate() {
        *moved = by * information[i * (normal.count + 1)].sqrt();
    }
    let most = SHORT_STEP_SIGMAS * (step.by.len() as f64).sqrt();
    length(information, &step.by) < most || step.saved < MIN_COST_SAVED
}

/// Returns a step that lowers the cost with the gains held; `None` if no tried step does. A, g and
/// V contain the prior, A is corrected by `A_n` and g by `g_n`.
///
/// ```text
/// min ½ Δzᵀ (A + μ diag A) Δz + gᵀ Δz        saved = V(z) − V(z + Δz) + 2 g_n · Δz + Δz · A_n Δz > 0
/// ```
fn lower(
    problem: &Problem<'_>,
    dynamics: &Dynamics,
    run: &FilterRun,
    gradient: &Gradient,
    z: &[f64],
    damping: &mut Damping,
) -> Option<Step> {
    let normal = &gradient.normal;
    for _ in 0..MAX_TRIES {
        if let Some(by) = step(problem, z, normal, damping.value()) {
            let at: Vec<f64> = z.iter().zip(&by).map(|(x, d)| x + d).collect();
            let there = (problem.is_feasible(&at))
                .then(|| replay(problem.measurements, dynamics, problem.unknowns, &at, run))
                .flatten();
            if let Some((there, trajectories)) = there {
                let noise = gradient.by_noise.cost(&by);
                let saved = gradient.cost - there - problem.prior_cost(&at) + noise;
                if saved > 0.0 {
                    damping.succeeded();
                    return Some(Step {
                        by,
                        saved,
                        trajectories,
                    });
                }
            }
        }
        damping.failed();
    }
    None
}
