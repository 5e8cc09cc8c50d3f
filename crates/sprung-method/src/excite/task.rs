//! Input of a design: the robot, its values, limits and sensors, and the frequencies of the motion.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::bounds::Bounds;
use super::fourier::MOST_MULTIPLE;
use super::information_matrix::Information;
use super::kinematics::Kinematics;
use super::noise::{Errors, Fastest};
use crate::description::{Controller, Excite};
use crate::model::{Model, Parameter, Theta};

/// What is to be designed.
#[derive(Clone, Debug)]
pub struct Task<'a> {
    /// The robot's equations.
    pub model: &'a Model,
    /// Its values as far as they are known, \[p\].
    pub theta: &'a [f64],
    /// Other robots for which the motion must keep its limits, \[robots\]\[p\].
    pub robots: &'a [Theta],
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

/// Most free numbers of a search.
const MOST_FREE: usize = 140;

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
        let base = settings
            .base_frequency_hz
            .unwrap_or(1.0 / settings.duration_s);
        let periods = (settings.duration_s * base + 1e-9).floor().max(1.0) as usize;
        let n = task.model.joint_count();
        let resonances = Fastest::of(task.model, task.theta).resonances;
        let most = (MOST_FREE / n / 2).max(3);
        let wanted = settings.harmonics.unwrap_or_else(|| {
            let by_limits = (task.bounds.joints.iter()).filter_map(|joint_bounds| {
                let [_, velocity, acceleration, _] = joint_bounds.orders;
                (velocity.is_limited() && acceleration.is_limited())
                    .then(|| 2.0 * acceleration.half / velocity.half / TAU)
            });
            let top = by_limits
                .chain(resonances.iter().map(|hz| 1.2 * hz))
                .fold(1.0, f64::max);
            ((top / base).ceil() as usize).clamp(4, most.clamp(4, 40))
        });
        let mut harmonics: Vec<usize> = (1..=wanted).collect();
        if settings.resonances {
            for hz in resonances {
                let middle = (hz / base).round() as usize;
                harmonics.extend([middle.saturating_sub(1), middle, middle + 1]);
            }
            harmonics.retain(|harmonic| (1..=MOST_MULTIPLE).contains(harmonic));
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

/// Returns the values to which errors of the free parameters are relative: their own, but at least a part of the largest
/// one with the same unit; torques of zero, such as offsets, to a part of the largest torque of their joint.
#[must_use]
pub fn scales(model: &Model, theta: &[f64], bounds: &Bounds) -> Vec<f64> {
    let torque = |parameter: &Parameter, value: f64| match parameter.joint {
        Some((_, joint)) if value == 0.0 && parameter.unit == "N·m" => {
            let limit = bounds.joints[joint].torque;
            if limit.is_limited() {
                SMALL_PART * limit.half
            } else {
                0.0
            }
        }
        _ => 0.0,
    };
    let all: Vec<_> = model.parameters().iter().zip(theta).collect();
    let largest = |unit: &str| {
        (all.iter().filter(|(parameter, _)| parameter.unit == unit))
            .fold(0.0, |most: f64, (_, value)| most.max(value.abs()))
    };
    (all.iter())
        .filter(|(parameter, _)| parameter.fixed.is_none())
        .map(|(parameter, value)| {
            let least = (SMALL_PART * largest(parameter.unit)).max(torque(parameter, **value));
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
            // One factor for all masses keeps the robot possible.
            let of_masses = factor();
            let parameters = task.model.parameters().iter().zip(task.theta);
            parameters
                .map(
                    |(parameter, value)| match (parameter.fixed, parameter.joint) {
                        (Some(_), _) => *value,
                        (None, None) => value * of_masses,
                        (None, Some(_)) => value * factor(),
                    },
                )
                .collect()
        })
        .collect()
}

/// Returns the sets of values for which a motion must keep its limits: the given one, draws about it, and the other robots.
pub(super) fn possible_values(task: &Task<'_>) -> Vec<Vec<f64>> {
    let mut all = draws(task);
    if task.settings.value_error > 0.0 {
        all.insert(0, task.theta.to_vec());
    }
    all.extend_from_slice(task.robots);
    all
}
