//! Minimises the distance between simulated and logged positions over all windows.
//!
//! The sum over the windows is robust: a window whose motion the model does not follow, for example
//! because a stuck joint breaks away at another time, has a bounded weight. Damped Gauss-Newton steps
//! minimise it. Steps that stop a joint make it continuous, but not smooth, so the minimum is searched
//! with windows of several lengths, and their results are averaged.

use rayon::prelude::*;
use sprung_core::servo::ServoParameter;

use super::matrix::damped;
use super::window::{Normal, P, Setting, Window};
use crate::progress::{Listener, Phase, Stopped};

/// Squared residual per sample, relative to the noise, beyond which the weight of a window falls.
const TOLERANCE: f64 = 3.0;

/// Change of the sum, relative, below which a search ends.
const CONVERGED: f64 = 1e-4;

/// Values after a search, with the windows about them.
pub(super) struct Fitted {
    pub(super) values: [f64; P],
    /// One entry per window: its derivatives and its weight.
    pub(super) normals: Vec<(Normal, f64)>,
}

/// Counts the simulations of all windows.
pub(super) struct Counter<'a> {
    pub(super) listener: &'a mut dyn Listener,
    pub(super) done: u64,
    pub(super) total: u64,
}

impl Counter<'_> {
    fn next(&mut self) -> Result<(), Stopped> {
        self.done += 1;
        let total = self.total.max(self.done);
        self.listener
            .tell(Phase::FittingLoop, self.done, Some(total))
    }
}

/// Minimises the distance.
///
/// - `values`: start.
/// - `unknown`: indices of the parameters that may change.
/// - `evaluations`: largest number of simulations of all windows.
///
/// # Errors
///
/// [`Stopped`] if the listener stops the run.
pub(super) fn fit(
    values: [f64; P],
    mut windows: Vec<Window>,
    unknown: &[usize],
    setting: &Setting<'_>,
    evaluations: usize,
    counter: &mut Counter<'_>,
) -> Result<Fitted, Stopped> {
    let mut values = values;
    let mut damping = 1e-2;
    let mut cost = total(&values, &windows, setting);
    let mut used = 1;
    loop {
        let normals = normals(&values, &windows, setting);
        counter.next()?;
        used += 1;
        let mut change = None;
        while used < evaluations && damping < 1e4 {
            counter.next()?;
            used += 1;
            let tried = step(&values, &normals, unknown, damping);
            if let Some((next, step)) = tried {
                let moved = moved(&windows, &normals, &step, (damping, setting.free_start));
                let found = total(&next, &moved, setting);
                if found < cost {
                    change = Some((cost - found) / cost);
                    (values, windows, cost) = (next, moved, found);
                    damping = (0.2 * damping).max(1e-7);
                    break;
                }
            }
            damping *= 5.0;
        }
        match change {
            // No step was found, so the derivatives still hold.
            None => return Ok(Fitted { values, normals }),
            Some(change) if change < CONVERGED => {
                let normals = self::normals(&values, &windows, setting);
                return Ok(Fitted { values, normals });
            }
            Some(_) => {}
        }
    }
}

/// Returns the robust sum over the windows.
fn total(values: &[f64; P], windows: &[Window], setting: &Setting<'_>) -> f64 {
    let each: Vec<f64> = (windows.par_iter())
        .map(|window| {
            let size = TOLERANCE * window.len() as f64;
            size * (1.0 + window.cost(values, setting) / size).ln()
        })
        .collect();
    each.iter().sum()
}

/// Returns the derivatives of each window, and its weight.
fn normals(values: &[f64; P], windows: &[Window], setting: &Setting<'_>) -> Vec<(Normal, f64)> {
    (windows.par_iter())
        .map(|window| {
            let normal = window.normal(values, setting);
            let size = TOLERANCE * window.len() as f64;
            let weight = 1.0 / (1.0 + normal.cost / size);
            (normal, weight)
        })
        .collect()
}

/// Returns the sum of the weighted information of the windows and of their weighted descent, of the
/// unknown parameters, \[n × n\] and \[n\].
pub(super) fn sums(normals: &[(Normal, f64)], unknown: &[usize]) -> (Vec<f64>, Vec<f64>) {
    let n = unknown.len();
    let (mut information, mut descent) = (vec![0.0; n * n], vec![0.0; n]);
    for (normal, weight) in normals {
        for (i, &row) in unknown.iter().enumerate() {
            descent[i] += weight * normal.descent[row];
            for (j, &column) in unknown.iter().enumerate() {
                information[i * n + j] += weight * normal.information[row][column];
            }
        }
    }
    (information, descent)
}

/// Returns values after a damped step within their bounds, and the step.
fn step(
    values: &[f64; P],
    normals: &[(Normal, f64)],
    unknown: &[usize],
    damping: f64,
) -> Option<([f64; P], [f64; P])> {
    let (_, descent) = sums(normals, unknown);
    // A parameter at its bound stays there if the step points outward.
    let active: Vec<usize> = (unknown.iter().zip(&descent))
        .filter(|(i, descent)| !(is_at_zero(values, **i) && **descent <= 0.0))
        .map(|(i, _)| *i)
        .collect();
    let (information, descent) = sums(normals, &active);
    let change = damped(&information, &descent, damping)?;
    let mut next = *values;
    for (&i, change) in active.iter().zip(change) {
        next[i] = bounded(i, values[i], values[i] + change);
    }
    let step = std::array::from_fn(|i| next[i] - values[i]);
    Some((next, step))
}

/// Returns whether a parameter is at its bound zero.
pub(super) fn is_at_zero(values: &[f64; P], i: usize) -> bool {
    i != ServoParameter::ZeroOffset as usize
        && i != ServoParameter::LogStribeckVelocity as usize
        && values[i] <= 0.0
}

/// Returns a new value within the bounds of a parameter and of a step.
fn bounded(i: usize, old: f64, new: f64) -> f64 {
    match ServoParameter::ALL[i] {
        ServoParameter::TorquePerCommand | ServoParameter::Armature => {
            new.clamp(0.3 * old, 3.0 * old)
        }
        ServoParameter::LogStribeckVelocity => new.clamp(old - 0.7, old + 0.7).clamp(-7.0, 4.0),
        ServoParameter::StribeckExponent => new.clamp(0.3, 6.0),
        ServoParameter::ZeroOffset => new,
        ServoParameter::BackEmf
        | ServoParameter::Viscous
        | ServoParameter::Coulomb
        | ServoParameter::Stribeck
        | ServoParameter::LoadMotor
        | ServoParameter::LoadExternal
        | ServoParameter::LoadMotorStribeck
        | ServoParameter::LoadExternalStribeck
        | ServoParameter::LoadMotorQuadratic
        | ServoParameter::LoadExternalQuadratic => new.max(0.0),
    }
}

/// Returns the windows with the starts that belong to a step.
fn moved(
    windows: &[Window],
    normals: &[(Normal, f64)],
    step: &[f64; P],
    (damping, free_start): (f64, bool),
) -> Vec<Window> {
    let mut moved = windows.to_vec();
    if free_start {
        for (window, (normal, _)) in moved.iter_mut().zip(normals) {
            let of_start = normal.start_step(step, damping);
            for (start, step) in window.start.iter_mut().zip(of_start) {
                *start += step;
            }
        }
    }
    moved
}
