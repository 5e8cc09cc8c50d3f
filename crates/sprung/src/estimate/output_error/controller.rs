//! Is the controller of the file the one that ran?

use super::record::Record;
use crate::description::Controller;
use crate::estimate::cutoff::white_noise;
use crate::model::{Model, Theta};
use crate::preprocess::RawBlock;
use crate::simulate::ClosedLoop;

/// Samples by which a torque may be logged late or early, at most.
const SHIFT: usize = 2;

/// Logged torque of a joint beside that of the controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TorqueMatch {
    /// Their difference beyond white noise over the torque, root mean squares.
    pub(super) relative: f64,
    /// Logged torque over the controller's, by least squares.
    pub(super) gain: f64,
    /// Standard error of that for the white noise of the difference.
    pub(super) gain_error: f64,
    /// Samples by which the logged torque comes late, if that explains most of
    /// the difference.
    pub(super) late: i32,
}

/// Feeds the controller with the logged positions and compares its torques
/// with the logged ones; `theta` is that of a plant, which stands still. One entry per joint; nothing for a joint whose
/// controller gives none.
pub(super) fn compare_torques(
    model: &Model,
    theta: &Theta,
    controller: &Controller,
    record: &Record,
) -> Vec<Option<TorqueMatch>> {
    let n = model.joint_count();
    let Some(commanded) = commands(model, theta, controller, record) else {
        return vec![None; n];
    };
    (record.samples.tau.iter().zip(&commanded))
        .map(|(logged, commanded)| compare(logged, commanded))
        .collect()
}

/// Returns the torques of the controller, \[n\] vectors.
fn commands(
    model: &Model,
    theta: &Theta,
    controller: &Controller,
    record: &Record,
) -> Option<Vec<Vec<f64>>> {
    let (q, phi) = record.start();
    let start = Some((&q[..], &phi[..]));
    let mut law = ClosedLoop::new(model, theta, controller, record.period, start).ok()?;
    let samples = &record.samples;
    let mut all = vec![Vec::with_capacity(samples.len()); model.joint_count()];
    for k in 0..samples.len() {
        let (q, phi) = (RawBlock::at(&samples.q, k), RawBlock::at(&samples.phi, k));
        let tau = law.command(samples.time[k], &q, &phi);
        for (column, value) in all.iter_mut().zip(tau) {
            column.push(value);
        }
    }
    Some(all)
}

fn compare(logged: &[f64], commanded: &[f64]) -> Option<TorqueMatch> {
    let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
        logged.iter().zip(commanded).map(|(t, c)| of(*t, *c)).sum()
    };
    let power = sum(&|_, c| c * c);
    let torque = sum(&|t, _| t * t);
    if !(power.is_finite() && power > 0.0 && torque > 0.0) {
        return None;
    }
    let difference: Vec<f64> = logged.iter().zip(commanded).map(|(t, c)| t - c).collect();
    let noise = white_noise(&difference);
    let samples = logged.len() as f64;
    let square = difference.iter().map(|d| d * d).sum::<f64>() / samples;
    Some(TorqueMatch {
        relative: ((square - noise * noise).max(0.0) * samples / torque).sqrt(),
        gain: sum(&|t, c| t * c) / power,
        gain_error: noise / power.sqrt(),
        late: lateness(logged, commanded),
    })
}

/// Returns the shift that leaves less than half of the squares of the
/// difference, or 0.
fn lateness(logged: &[f64], commanded: &[f64]) -> i32 {
    let inner = SHIFT..logged.len() - SHIFT;
    let squares = |late: i32| -> f64 {
        inner
            .clone()
            .map(|k| (logged[k] - commanded[(k as i64 - i64::from(late)) as usize]).powi(2))
            .sum()
    };
    let reach = SHIFT as i32;
    let best = (-reach..=reach).min_by(|a, b| squares(*a).total_cmp(&squares(*b)));
    best.filter(|late| squares(*late) < 0.5 * squares(0))
        .unwrap_or(0)
}
