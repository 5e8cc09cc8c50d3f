//! Positions at the edges of an encoder's counts.

/// Standard deviation of an edge's place, in counts: encoder lines are not more even.
const EDGE_DEVIATION_COUNTS: f64 = 0.05;

/// Samples without an edge after which a joint is taken to rest within a count.
const REST_SAMPLES: usize = 100;

/// What a counter says.
#[derive(Clone, Copy, Debug)]
pub(super) struct EdgePosition {
    /// Place among the samples.
    pub(super) sample: f64,
    /// Position, rad (m).
    pub(super) value: f64,
    /// Its variance, rad² (m²).
    pub(super) variance: f64,
    /// Acceleration there, rad/s² (m/s²).
    pub(super) acceleration: f64,
}

/// Visits the positions that a counter's edges and rests say.
///
/// Where the counter changes, the position halfway between two samples is the mean
/// of both, whatever the number of counts between them: of all positions that lead
/// to so many counts at this velocity it is the centre, and they span one count
/// less the part by which the number differs from what the velocity says. The later
/// value would be wrong by up to half a count towards the motion, which looks like
/// friction.
///
/// - `values`: of a channel, rad (m); `velocity`: of the smoothed values, rad/s (m/s).
/// - `count`: rad (m); `period`: s.
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
        // A rest says once where the joint was, however long it was.
        if k - since >= REST_SAMPLES {
            let middle = usize::midpoint(since, k);
            visit(EdgePosition {
                sample: middle as f64,
                value: values[middle],
                variance: count * count / 12.0,
                acceleration: 0.0,
            });
        }
        since = k + 1;
        if let (Some(next), Some(ahead)) = (values.get(k + 1), velocity.get(k + 1)) {
            let moved = 0.5 * (velocity[k] + ahead) * period / count;
            let width = (1.0 - (counts - moved).abs()).max(0.0);
            let uneven = EDGE_DEVIATION_COUNTS * EDGE_DEVIATION_COUNTS;
            // The mean of two positions lies ahead of the one between them in time.
            let gained = ahead - velocity[k];
            visit(EdgePosition {
                sample: k as f64 + 0.5,
                value: 0.5 * (values[k] + next) - gained * period / 8.0,
                variance: (width * width / 12.0 + uneven) * count * count,
                acceleration: gained / period,
            });
        }
    }
}
