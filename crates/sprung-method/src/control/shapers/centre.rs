//! The sequence of a number of impulses whose largest residual over the region of a mode is least.

use sprung_core::shaper::{Impulse, Mode};

use super::humps::extra_insensitive;
use super::region::{Region, sampled};

/// Frequencies of the grid, and steps of the searches of frequency, damping and level of the humps.
const GRID: usize = 13;
const FREQUENCY_STEPS: usize = 14;
const DAMPING_STEPS: usize = 10;
const HUMP_STEPS: usize = 12;

/// Least level of the humps, as part of the allowed residual and at all.
const LEAST_HUMP_PART: f64 = 0.02;
const LEAST_HUMP: f64 = 1e-4;

/// Searches of the level of the humps, each followed by one of the centre.
const ROUNDS: usize = 2;

/// The best sequence of a number of impulses for one mode.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    pub(super) centre: Mode,
    /// Residual vibration of the humps.
    pub(super) hump: Option<f64>,
    pub(super) sequence: Vec<Impulse>,
}

impl Candidate {
    /// Returns the time of the last impulse, s.
    pub(super) fn delay(&self) -> f64 {
        self.sequence.last().map_or(0.0, |impulse| impulse.time)
    }
}

struct ShaperSearch<'r> {
    impulses: usize,
    region: &'r Region,
    /// Sampling period, s.
    period: f64,
    frequencies: [f64; 2],
    dampings: [f64; 2],
}

/// Returns the best sequence of a number of impulses; `None` if none fits.
///
/// - `level`: allowed residual vibration.
/// - `period`: sampling period, s.
pub(super) fn best(impulses: usize, region: &Region, level: f64, period: f64) -> Option<Candidate> {
    let thinned = region.thinned();
    let search = ShaperSearch {
        impulses,
        region: &thinned,
        period,
        frequencies: region.range(Mode::frequency),
        dampings: region.range(Mode::damping),
    };
    // Without humps the region lies about the centre. From there the humps grow; a search from large humps can end with
    // the region about one zero.
    let least = (LEAST_HUMP_PART * level).max(LEAST_HUMP).min(level);
    let mut hump = least;
    let mut centre = search.centre(hump)?;
    let has_humps = impulses > 2;
    for _ in 0..if has_humps { ROUNDS } else { 0 } {
        let cost = |logarithm: f64| search.cost(centre, logarithm.exp());
        hump = minimise(cost, [least, level].map(f64::ln), HUMP_STEPS)
            .0
            .exp();
        centre = search.centre(hump)?;
    }
    let centre = Mode::new(centre[0], centre[1]).ok()?;
    let sequence = extra_insensitive(&centre, hump, impulses)?;
    sampled(&sequence, period)?;
    Some(Candidate {
        centre,
        hump: has_humps.then_some(hump),
        sequence,
    })
}

impl ShaperSearch<'_> {
    /// Returns frequency, rad/s, and damping ratio of the best centre.
    fn centre(&self, hump: f64) -> Option<[f64; 2]> {
        let damping = |frequency| {
            minimise(
                |z| self.cost([frequency, z], hump),
                self.dampings,
                DAMPING_STEPS,
            )
        };
        let [low, high] = self.frequencies;
        let step = (high - low) / (GRID - 1) as f64;
        let nearest = (0..GRID)
            .map(|k| low + k as f64 * step)
            .map(|frequency| (frequency, damping(frequency).1))
            .min_by(|a, b| a.1.total_cmp(&b.1))?
            .0;
        let about = [(nearest - step).max(low), (nearest + step).min(high)];
        let (frequency, cost) = minimise(|frequency| damping(frequency).1, about, FREQUENCY_STEPS);
        cost.is_finite().then(|| [frequency, damping(frequency).0])
    }

    /// Returns the largest residual over the region; infinite without a sequence.
    fn cost(&self, [frequency, damping]: [f64; 2], hump: f64) -> f64 {
        (Mode::new(frequency, damping).ok())
            .and_then(|centre| extra_insensitive(&centre, hump, self.impulses))
            .and_then(|sequence| sampled(&sequence, self.period))
            .map_or(f64::INFINITY, |sampled| {
                self.region.evaluate(&sampled).largest
            })
    }
}

/// Returns the argument with the least value in a golden-section search, and this value.
fn minimise(cost: impl Fn(f64) -> f64, [mut low, mut high]: [f64; 2], steps: usize) -> (f64, f64) {
    let section = 0.5 * (5_f64.sqrt() - 1.0);
    let at = |argument: f64| (argument, cost(argument));
    let mut best = at(low);
    if high - low <= f64::EPSILON * high.abs() {
        return best;
    }
    let mut keep = |point: (f64, f64)| {
        if point.1 < best.1 {
            best = point;
        }
        point
    };
    keep(at(high));
    let mut left = keep(at(high - section * (high - low)));
    let mut right = keep(at(low + section * (high - low)));
    for _ in 0..steps {
        if left.1 <= right.1 {
            (high, right) = (right.0, left);
            left = keep(at(high - section * (high - low)));
        } else {
            (low, left) = (left.0, right);
            right = keep(at(low + section * (high - low)));
        }
    }
    best
}
