//! Findings about joints at rest, where friction may have any value between both bounds of its law.

use crate::estimate::statistics::LARGE_SHARE;
use crate::finding::{Finding, Severity};
use crate::model::Model;
use crate::numbers::in_percent;
use crate::prepare::Prepared;
use crate::preprocess::SignalBlock;
use crate::regression::{System, signals};

/// Fraction of the samples at rest below which presliding is not searched.
const MIN_REST_SHARE: f64 = 0.02;

/// Duration of a window in which position and torque are compared, s.
const WINDOW_S: f64 = 0.5;

/// Largest argument of `tanh(beta v)` in a window at rest.
const REST_ARGUMENT: f64 = 0.3;

/// Least correlation of position and torque in a window of presliding.
const MIN_CORRELATION: f64 = 0.9;

/// Least number of such windows, and their least fraction of the windows at rest.
const MIN_WINDOWS: usize = 4;

/// Least fraction of the windows at rest that show presliding; fewer may be chance.
const MIN_WINDOW_SHARE: f64 = 0.3;

/// Returns findings about joints that are nearly always at rest, and about presliding.
pub(in crate::estimate) fn at_rest(prepared: &Prepared, system: &System) -> Vec<Finding> {
    let reading = prepared.reading();
    let model = reading.model();
    let shares: Vec<f64> = (0..model.joint_count())
        .map(|joint| system.share_at_rest(model.torque_row(joint)))
        .collect();
    let mut findings: Vec<Finding> = (shares.iter().enumerate())
        .filter(|(_, share)| **share >= 1.0 - LARGE_SHARE)
        .map(|(joint, share)| nearly_always(model, joint, *share))
        .collect();
    if shares.iter().all(|share| *share < MIN_REST_SHARE) {
        return findings;
    }
    let excerpt = prepared.excerpt();
    let period = excerpt.period();
    let segments = signals(reading, period, excerpt.blocks()).unwrap_or_default();
    for (joint, share) in shares.iter().enumerate() {
        if *share < MIN_REST_SHARE {
            continue;
        }
        if let Some(found) = presliding(&segments, joint, model.sharpness(joint), period) {
            findings.push(found.finding(&model.joints()[joint], *share >= 1.0 - LARGE_SHARE));
        }
    }
    findings
}

fn nearly_always(model: &Model, joint: usize, share: f64) -> Finding {
    Finding::new(
        Severity::Warning,
        "at-rest",
        format!(
            "{}: the motor stands still in {:.0} % of the samples; at rest the friction is anywhere \
             between both bounds of its law, so these samples count little and the other samples \
             determine the parameters",
            model.joints()[joint],
            in_percent(share)
        ),
        "record a motion of this joint, or fix its parameters",
    )
}

/// Elastic motion of a joint at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Presliding {
    /// Median of the torque per position, N·m/rad (N/m).
    stiffness: f64,
    windows: usize,
    at_rest: usize,
}

impl Presliding {
    fn finding(&self, joint: &str, always: bool) -> Finding {
        let all = if always {
            "; the joint hardly ever slides, so the log shows presliding alone and does not determine \
             its friction"
        } else {
            ""
        };
        Finding::new(
            if always {
                Severity::Warning
            } else {
                Severity::Info
            },
            "presliding",
            format!(
                "{joint}: in {} of {} windows of {WINDOW_S} s at rest the position follows the torque \
                 like a spring of {:.3e} N·m/rad (N/m): friction deforms before it slides, which no \
                 friction law of sprung contains{all}",
                self.windows, self.at_rest, self.stiffness
            ),
            "samples at rest count little in least squares; a motion that slides determines the \
             friction",
        )
    }
}

/// Compares position and torque of a motor in windows at rest; `None` without presliding.
fn presliding(
    segments: &[SignalBlock],
    joint: usize,
    sharpness: f64,
    period: f64,
) -> Option<Presliding> {
    let length = ((WINDOW_S / period) as usize).max(4);
    let (mut slopes, mut at_rest, mut against) = (Vec::new(), 0, 0);
    for segment in segments {
        let all = (segment.phi[joint].chunks_exact(length))
            .zip(segment.dphi[joint].chunks_exact(length))
            .zip(segment.tau[joint].chunks_exact(length));
        for ((position, velocity), torque) in all {
            if velocity
                .iter()
                .any(|v| (sharpness * v).abs() > REST_ARGUMENT)
            {
                continue;
            }
            at_rest += 1;
            let of = moments(position, torque);
            let correlation = of.both / (of.first * of.second).sqrt();
            if correlation >= MIN_CORRELATION {
                slopes.push(of.both / of.first);
            } else if correlation <= -MIN_CORRELATION {
                against += 1;
            }
        }
    }
    let windows = slopes.len();
    // A slow drift is correlated with a slow torque too, but with either sign.
    let few = windows < MIN_WINDOWS.max(MIN_WINDOWS * against);
    if few || (windows as f64) < MIN_WINDOW_SHARE * at_rest as f64 {
        return None;
    }
    slopes.sort_by(f64::total_cmp);
    Some(Presliding {
        stiffness: slopes[windows / 2],
        windows,
        at_rest,
    })
}

/// Sums of squares of two signals about their means, and the sum of their products.
#[derive(Default)]
struct Moments {
    first: f64,
    second: f64,
    both: f64,
}

fn moments(a: &[f64], b: &[f64]) -> Moments {
    let count = a.len() as f64;
    let mean = |x: &[f64]| x.iter().sum::<f64>() / count;
    let (of_a, of_b) = (mean(a), mean(b));
    a.iter().zip(b).fold(Moments::default(), |sums, (a, b)| {
        let (a, b) = (a - of_a, b - of_b);
        Moments {
            first: sums.first + a * a,
            second: sums.second + b * b,
            both: sums.both + a * b,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A joint at rest under a torque that changes with 0.7 Hz; its position is `position(torque)`.
    fn segment(position: impl Fn(f64, f64) -> f64) -> Vec<SignalBlock> {
        let mut block = SignalBlock::new(1);
        for k in 0..10_000 {
            let t = f64::from(k) * 1e-3;
            let torque = 2.0 * (4.4 * t).sin();
            block.time.push(t);
            block.tau[0].push(torque);
            block.phi[0].push(position(torque, t));
            block.dphi[0].push(1e-4);
        }
        vec![block]
    }

    #[test]
    fn positions_that_follow_the_torque_at_rest_are_presliding() {
        let found = presliding(&segment(|torque, _| 0.3 + torque / 5e4), 0, 100.0, 1e-3).unwrap();
        assert!((found.stiffness / 5e4 - 1.0).abs() < 1e-9);
        assert_eq!((found.windows, found.at_rest), (20, 20));
        assert!(
            found
                .finding("joint1", true)
                .text
                .contains("presliding alone")
        );
    }

    #[test]
    fn still_and_sliding_joints_show_no_presliding() {
        let still = segment(|_, _| 0.3);
        assert_eq!(presliding(&still, 0, 100.0, 1e-3), None);
        let creeping = segment(|_, t| 1e-4 * t);
        assert_eq!(presliding(&creeping, 0, 100.0, 1e-3), None);
        let mut sliding = segment(|torque, _| torque / 5e4);
        sliding[0].dphi[0].fill(0.1);
        assert_eq!(presliding(&sliding, 0, 100.0, 1e-3), None);
    }
}
