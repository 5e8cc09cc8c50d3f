//! Comparison of the described controller with the real one in the log.

use super::record::Record;
use crate::description::Controller;
use crate::estimate::statistics::CERTAIN_SIGMAS;
use crate::model::{Model, Theta};
use crate::prepare::white_noise;
use crate::preprocess::RawBlock;
use crate::simulate::ClosedLoop;

/// Largest shift of the logged torque that is tried, samples.
const MAX_SHIFT_SAMPLES: usize = 2;

/// Logged torque of a joint compared with the controller's torque.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TorqueMatch {
    /// Difference beyond white noise relative to the logged torque, root mean squares.
    pub(super) relative: f64,
    /// Ratio of the logged torque to the controller's torque, by least squares.
    pub(super) gain: f64,
    /// Standard error of the gain, from the white noise of the difference.
    pub(super) gain_error: f64,
    /// Number of samples by which the logged torque is late; 0 unless the shift explains most of
    /// the difference.
    pub(super) late: i32,
}

/// Replays the controller on the logged positions and compares its torques with the logged ones.
///
/// - `theta`: parameters of the loop's plant, \[p\]. The plant does not move here.
///
/// Returns one entry per joint; `None` if the controller gives no torque for the joint.
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

/// Returns the torques of the controller on the logged positions, \[n\] vectors.
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
        late: lateness(logged, commanded, noise),
    })
}

/// Returns the shift with the smallest squared difference. Returns 0 unless the squared difference
/// decreases by more than half of the squared change of the controller's torque, and this change is
/// above the noise.
fn lateness(logged: &[f64], commanded: &[f64], noise: f64) -> i32 {
    let shifted = |k: usize, late: i32| commanded[(k as i64 - i64::from(late)) as usize];
    let sum = |of: &dyn Fn(usize) -> f64| -> f64 {
        let inner = MAX_SHIFT_SAMPLES
            ..logged
                .len()
                .saturating_sub(MAX_SHIFT_SAMPLES)
                .max(MAX_SHIFT_SAMPLES);
        inner.map(|k| of(k).powi(2)).sum()
    };
    let squares = |late: i32| sum(&|k| logged[k] - shifted(k, late));
    let change = |late: i32| sum(&|k| commanded[k] - shifted(k, late));
    let reach = MAX_SHIFT_SAMPLES as i32;
    let best = (-reach..=reach).min_by(|a, b| squares(*a).total_cmp(&squares(*b)));
    let clear = |late: &i32| {
        let change = change(*late);
        squares(0) - squares(*late) > 0.5 * change && change > (CERTAIN_SIGMAS * noise).powi(2)
    };
    best.filter(clear).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    use super::*;

    /// Number of samples, and deviation of the white noise of the logged torque, N·m.
    const SAMPLES: u32 = 5000;
    const NOISE: f64 = 0.01;

    /// The noise over the root mean square of the torque.
    fn relative_noise() -> f64 {
        NOISE / (0.5 * (1.0_f64 + 0.25)).sqrt()
    }

    /// Four relative standard errors of a variance by all samples.
    fn variance_limit() -> f64 {
        4.0 * (2.0 / f64::from(SAMPLES)).sqrt()
    }

    fn torque(t: f64) -> f64 {
        (7.0 * t).sin() + 0.5 * (23.0 * t).cos()
    }

    /// Compares a controller's torque with a logged torque made from it, with white noise.
    fn torques(logged: impl Fn(&dyn Fn(f64) -> f64, f64) -> f64) -> TorqueMatch {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let time = || (0..SAMPLES).map(|k| f64::from(k) * 1e-3);
        let commanded: Vec<f64> = time().map(torque).collect();
        let logged: Vec<f64> = time()
            .map(|t| logged(&torque, t) + NOISE * rng.sample::<f64, _>(StandardNormal))
            .collect();
        compare(&logged, &commanded).unwrap()
    }

    #[test]
    fn the_same_controller_matches() {
        let found = torques(|torque, t| torque(t));
        // The variance of the noise is subtracted; the scatter of the variance stays.
        let limit = relative_noise() * variance_limit().sqrt();
        assert!(found.relative < limit, "{found:?}");
        assert!(
            (found.gain - 1.0).abs() < 4.0 * found.gain_error,
            "{found:?}"
        );
        assert_eq!(found.late, 0);
    }

    #[test]
    fn another_scale_is_measured() {
        let found = torques(|torque, t| 0.98 * torque(t));
        assert!(
            (found.gain - 0.98).abs() < 4.0 * found.gain_error,
            "{found:?}"
        );
        let expected = relative_noise() / f64::from(SAMPLES).sqrt();
        assert!(
            (found.gain_error / expected - 1.0).abs() < variance_limit(),
            "{found:?}"
        );
        // The square of the difference has the scatter of the noise's variance and of its product with the difference.
        let expected = 0.02 / 0.98;
        let by_noise = variance_limit() * relative_noise().powi(2);
        let by_product = 4.0 * 2.0 * expected * relative_noise() / f64::from(SAMPLES).sqrt();
        let off = found.relative.powi(2) - expected * expected;
        assert!(off.abs() < by_noise.hypot(by_product), "{found:?}");
    }

    #[test]
    fn a_late_torque_is_seen() {
        for late in [-1, 2] {
            let found = torques(|torque, t| torque(t - 1e-3 * f64::from(late)));
            assert_eq!(found.late, late, "{found:?}");
        }
    }

    #[test]
    fn another_torque_is_seen() {
        // The logged torque saturates at a third of its peak.
        let found = torques(|torque, t| torque(t).clamp(-0.5, 0.5));
        let squares = |of: fn(f64) -> f64| -> f64 {
            let torques = (0..SAMPLES).map(|k| of(torque(f64::from(k) * 1e-3)));
            torques.map(|torque| torque * torque).sum()
        };
        let clipped = |torque: f64| torque.clamp(-0.5, 0.5);
        let cut_off = |torque: f64| torque - torque.clamp(-0.5, 0.5);
        let expected = (squares(cut_off) / squares(clipped)).sqrt();
        // The noise is 1 %.
        assert!((found.relative / expected - 1.0).abs() < 0.01, "{found:?}");
        assert_eq!(compare(&[1.0, 2.0, 3.0, 4.0, 5.0], &[0.0; 5]), None);
    }
}
