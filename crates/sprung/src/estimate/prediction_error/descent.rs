//! From a start to the parameters of the greatest likelihood.
//!
//! A Gauss-Newton step holds the filter's gains; the next run makes them anew, and
//! the levels of the disturbances with them. At the true parameters innovations
//! correlate with their derivatives by noise of the logged torque alone, which is
//! taken off, so gains decide how precise the estimate is, not whether it is right.

use super::dynamics::Dynamics;
use super::filter::{Levels, Normal, Path, Schedule, Wanted, replay, run};
use super::levels::{Level, Search, search};
use super::likelihood::About;
use super::measurements::Record;
use super::noisy_torque::expected_gradient;
use super::solve::{damped_step, length};
use super::unknowns::Unknowns;
use crate::model::Model;
use crate::progress::{Listener, Phase, Stopped};

/// Runs of the filter, at most.
const RUNS: usize = 30;

/// Runs before levels are searched: innovations of a poor start are not noise.
const FIRST: usize = 2;

/// A step is small if it is this long in standard errors per square root of the
/// number of unknowns, or saves less than this of the cost.
const SHORT: f64 = 0.02;
const SAVED: f64 = 1e-3;

/// A search of the levels that gains less than this has ended.
const SETTLED: f64 = 0.5;

/// Searches in a row that leave a level at its upper bound before a descent ends: the
/// model lacks something, which no level of a disturbance makes good.
const BOUND: usize = 6;

/// Dampings that are tried before a step is given up.
const TRIES: usize = 8;

/// Memory that transitions take at most, in numbers.
const KEPT: usize = 6_000_000;

/// What there is to find.
pub(super) struct Problem<'a> {
    pub(super) model: &'a Model,
    pub(super) record: &'a Record,
    pub(super) unknowns: &'a Unknowns,
    pub(super) search: &'a Search,
}

/// Where a descent ended.
#[derive(Clone, Debug)]
pub(super) struct Descent {
    pub(super) z: Vec<f64>,
    pub(super) levels: Levels,
    pub(super) runs: usize,
    /// What noise of the logged torque adds to the gradient of half the cost.
    pub(super) by_noise: Vec<f64>,
    /// Sum of the squared whitened innovations, and their number.
    pub(super) cost: f64,
    pub(super) measurements: u64,
    pub(super) converged: bool,
    /// Part of its standard error by which each unknown moved last.
    pub(super) moved: Vec<f64>,
}

impl Problem<'_> {
    /// Adds what is known of the offsets before, and returns its cost.
    pub(super) fn with_prior(&self, z: &[f64], normal: &mut Normal) -> f64 {
        let first = self.unknowns.free.len();
        let mut cost = 0.0;
        for (i, offset) in self.unknowns.offsets.iter().enumerate() {
            let weight = offset.deviation.powi(-2);
            let at = first + i;
            normal.information[at * (normal.count + 1)] += weight;
            normal.gradient[at] += weight * z[at];
            cost += weight * z[at] * z[at];
        }
        cost
    }

    fn prior_cost(&self, z: &[f64]) -> f64 {
        let values = &z[self.unknowns.free.len()..];
        let offsets = self.unknowns.offsets.iter().zip(values);
        offsets
            .map(|(offset, value)| (value / offset.deviation).powi(2))
            .sum()
    }

    /// Returns whether the parameters are those of a robot, as far as can be said
    /// without moving it.
    fn feasible(&self, z: &[f64]) -> bool {
        let parameters = self.model.parameters();
        self.unknowns.free.iter().zip(z).all(|(&index, value)| {
            let vital = parameters[index].joint.is_some_and(|(kind, joint)| {
                // The link of a rigid joint may hold its rotor.
                kind.is_vital() && self.model.is_flexible(joint)
            });
            value.is_finite() && (!vital || *value > 0.0)
        })
    }

    /// Goes down from a start.
    ///
    /// - `progress`: told of each run of the filter, as part of a phase.
    ///
    /// Returns nothing if the filter does not follow the log from there.
    pub(super) fn descend(
        &self,
        z: &[f64],
        levels: &Levels,
        phase: Phase,
        progress: &mut dyn Listener,
    ) -> Result<Option<Descent>, Stopped> {
        let Self {
            model,
            record,
            unknowns,
            search: levels_of,
        } = self;
        let mut dynamics = Dynamics::new(model, &unknowns.theta(z));
        let rows = model.rows();
        let wanted = Wanted {
            transitions: KEPT / (6 * rows * rows),
            growing: 0,
        };
        let samples = wanted.transitions;
        let (mut z, mut levels) = (z.to_vec(), levels.clone());
        let mut damping = 1e-3;
        let (mut settled, mut at_bound) = (false, 0);
        let mut moved = vec![0.0; z.len()];
        for runs in 1..=RUNS {
            progress.tell(phase, runs as u64, Some(RUNS as u64))?;
            let ran = run(record, &mut dynamics, unknowns, &z, &levels, wanted);
            let Some((mut outcome, mut schedule)) = ran else {
                return Ok(None);
            };
            let by_noise = {
                let about = About::new(record, &schedule, samples);
                expected_gradient(&about, &mut dynamics, unknowns, &levels)
            };
            let cost = outcome.cost + self.with_prior(&z, &mut outcome.normal);
            super::dynamics::add(&mut outcome.normal.gradient, -1.0, &by_noise);
            let step = self.step(
                &mut dynamics,
                &z,
                &outcome.normal,
                (cost, &by_noise),
                &schedule,
                &mut damping,
            );
            let short = match &step {
                None => true,
                Some((step, saved, _)) => {
                    let information = &outcome.normal.information;
                    for (i, (moved, step)) in moved.iter_mut().zip(step).enumerate() {
                        let diagonal = information[i * (outcome.normal.count + 1)];
                        *moved = step * diagonal.sqrt();
                    }
                    length(information, step) < SHORT * (z.len() as f64).sqrt() || *saved < SAVED
                }
            };
            let converged = short && settled;
            if converged || at_bound == BOUND || runs == RUNS {
                return Ok(Some(Descent {
                    z,
                    levels,
                    runs,
                    by_noise,
                    cost: outcome.cost,
                    measurements: outcome.measurements,
                    converged,
                    moved,
                }));
            }
            if let Some((step, _, path)) = step {
                super::dynamics::add(&mut z, 1.0, &step);
                // Levels of the new trajectory: those of the old one and steps with old
                // levels would take turns.
                schedule.path = path;
            }
            if runs >= FIRST || short {
                let about = About::new(record, &schedule, samples);
                let (found, gain) = search(&about, levels_of, &levels);
                settled = gain < SETTLED;
                levels = found;
                let mut bounds = levels_of.at_bound(&levels);
                let bound = bounds.any(|level| matches!(level, Level::Drift(_)));
                at_bound = if bound { at_bound + 1 } else { 0 };
            }
        }
        Ok(None)
    }

    /// Returns a step that lowers the cost with the gains held, by how much, and where
    /// it leads; nothing if there is none.
    fn step(
        &self,
        dynamics: &mut Dynamics<'_>,
        z: &[f64],
        normal: &Normal,
        (cost, by_noise): (f64, &[f64]),
        schedule: &Schedule,
        damping: &mut f64,
    ) -> Option<(Vec<f64>, f64, Path)> {
        for _ in 0..TRIES {
            let step = damped_step(&normal.information, &normal.gradient, *damping);
            if let Some(step) = step {
                let at: Vec<f64> = z.iter().zip(&step).map(|(x, d)| x + d).collect();
                if self.feasible(&at) {
                    let there = replay(self.record, dynamics, self.unknowns, &at, schedule);
                    if let Some((there, path)) = there {
                        let expected: f64 = step.iter().zip(by_noise).map(|(d, g)| d * g).sum();
                        let saved = cost - there - self.prior_cost(&at) + 2.0 * expected;
                        if saved > 0.0 {
                            *damping = (*damping / 10.0).max(1e-9);
                            return Some((step, saved, path));
                        }
                    }
                }
            }
            *damping = (*damping * 8.0).max(1e-4);
        }
        None
    }
}
