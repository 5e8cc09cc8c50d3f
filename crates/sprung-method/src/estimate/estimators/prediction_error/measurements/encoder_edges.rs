//! Positions at the edges of an encoder's counts.

use super::sensor::uniform_variance;

/// Standard deviation of the position of an encoder edge, in counts, because encoder lines are uneven. Half the value
/// moves an estimate by 0.3 standard errors, twice the value by 0.7 and nearly doubles a standard error.
const EDGE_DEVIATION_COUNTS: f64 = 0.05;

/// Motion per sample, in counts, above which samples are measurements instead of edges. Above it the errors of
/// successive samples are independent. The velocity decides, because a choice by the change of the count would prefer
/// samples just after an encoder edge. Half the value moves an estimate by 0.5 standard errors, twice the value by 0.1.
const MIN_COUNTS_OF_SAMPLES: f64 = 2.0;

/// Number of samples without an edge after which the joint counts as resting within a count. Half or twice the value
/// moves an estimate by 0.1 standard errors.
const REST_SAMPLES: usize = 100;

/// A position measured by an incremental encoder.
#[derive(Clone, Copy, Debug)]
pub(super) struct EdgePosition {
    /// Time of the position, in samples.
    pub(super) sample: f64,
    /// Position, rad (m).
    pub(super) value: f64,
    /// Variance of the position, rad² (m²).
    pub(super) variance: f64,
    /// Acceleration at this time, rad/s² (m/s²).
    pub(super) acceleration: f64,
}

/// Visits the positions that an encoder's counts show: edges, rests, and the samples of a fast
/// motion.
///
/// If the count changes between two samples, the position halfway between them is the mean of both
/// values, for one count as for several. The mean is the centre of all positions that give this
/// number of counts at this velocity. Their range is one count minus the difference between the
/// number of counts and the motion at this velocity. The later value would be wrong by up to half a
/// count in the direction of the motion, an error that resembles friction.
///
/// In a fast motion every period has an edge, and two successive means share a sample, so their
/// errors are not independent. There each sample is a measurement with an error of one count's
/// uniform distribution.
///
/// - `values`: positions of a channel, rad (m); `velocity`: velocity of the smoothed values, rad/s
///   (m/s).
/// - `count`: size of a count, rad (m); `period`: s.
pub(super) fn encoder_edges(
    values: &[f64],
    velocity: &[f64],
    count: f64,
    period: f64,
    mut visit: impl FnMut(EdgePosition),
) {
    let mut since = 0;
    for k in 0..values.len() {
        let counts = match values.get(k + 1) {
            Some(next) => (next - values[k]) / count,
            None => f64::INFINITY,
        };
        if counts.abs() < 0.5 {
            continue;
        }
        // A rest gives a single measurement, no matter how long it lasts.
        if k - since >= REST_SAMPLES {
            let middle = usize::midpoint(since, k);
            visit(EdgePosition {
                sample: middle as f64,
                value: values[middle],
                variance: uniform_variance(count),
                acceleration: 0.0,
            });
        }
        since = k + 1;
        if let (Some(next), Some(ahead)) = (values.get(k + 1), velocity.get(k + 1)) {
            let velocity_change = ahead - velocity[k];
            let expected_counts = 0.5 * (velocity[k] + ahead) * period / count;
            if expected_counts.abs() > MIN_COUNTS_OF_SAMPLES {
                visit(EdgePosition {
                    sample: (k + 1) as f64,
                    value: *next,
                    variance: uniform_variance(count),
                    acceleration: velocity_change / period,
                });
                continue;
            }
            let width = (1.0 - (counts - expected_counts).abs()).max(0.0);
            let uneven = EDGE_DEVIATION_COUNTS * EDGE_DEVIATION_COUNTS;
            // The mean of two positions exceeds the position halfway between them by a h²/8.
            visit(EdgePosition {
                sample: k as f64 + 0.5,
                value: 0.5 * (values[k] + next) - velocity_change * period / 8.0,
                variance: (uniform_variance(width) + uneven) * count * count,
                acceleration: velocity_change / period,
            });
        }
    }
}
