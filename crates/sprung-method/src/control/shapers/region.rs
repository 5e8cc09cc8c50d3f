//! Residual vibration of a sampled sequence over the region of a mode.

use sprung_core::shaper::{Impulse, Mode, Tap, residual, sample};

/// Bins of frequency of which a search uses the points with the least and the largest damping.
const BINS: usize = 64;

/// The possible values of a mode.
#[derive(Clone, Debug)]
pub(super) struct Region {
    pub(super) points: Vec<Mode>,
    /// Part of the points that count, those with the least residuals; in (0, 1].
    pub(super) part: f64,
}

/// Residual vibration over a region, as a part of that without shaper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Residuals {
    pub(super) largest: f64,
    pub(super) median: f64,
}

impl Residuals {
    /// Returns the larger of the figures of two modes.
    pub(super) fn max(self, other: Self) -> Self {
        Self {
            largest: self.largest.max(other.largest),
            median: self.median.max(other.median),
        }
    }
}

/// Returns the smallest value that a part of the values do not exceed.
fn quantile(values: &mut [f64], part: f64) -> f64 {
    let rank = (part * values.len() as f64 - 1e-9).ceil() as usize;
    let last = values.len().saturating_sub(1);
    if values.is_empty() {
        return 0.0;
    }
    *(values.select_nth_unstable_by(rank.saturating_sub(1).min(last), f64::total_cmp)).1
}

impl Region {
    /// Returns the largest and the median of one value per point.
    pub(super) fn residuals(&self, mut values: Vec<f64>) -> Residuals {
        Residuals {
            largest: quantile(&mut values, self.part),
            median: quantile(&mut values, 0.5),
        }
    }

    /// Returns the residuals of a sampled sequence.
    pub(super) fn evaluate(&self, sampled: &[Impulse]) -> Residuals {
        let values = self.points.iter().map(|mode| residual(sampled, mode));
        self.residuals(values.collect())
    }

    /// Returns the least and the largest value of a property.
    pub(super) fn range(&self, property: impl Fn(&Mode) -> f64) -> [f64; 2] {
        let start = [f64::INFINITY, f64::NEG_INFINITY];
        (self.points.iter().map(property)).fold(start, |[low, high], value| {
            [low.min(value), high.max(value)]
        })
    }

    /// Returns a region of few points with nearly the same largest residuals.
    pub(super) fn thinned(&self) -> Self {
        if self.points.len() <= 2 * BINS {
            return self.clone();
        }
        let mut sorted = self.points.clone();
        sorted.sort_by(|a, b| {
            (a.frequency().total_cmp(&b.frequency())).then(a.damping().total_cmp(&b.damping()))
        });
        let size = sorted.len().div_ceil(BINS);
        let points = if self.part < 1.0 {
            sorted.into_iter().step_by(size.div_ceil(4)).collect()
        } else {
            let mut few = Vec::new();
            few.extend(sorted.first().copied());
            for bin in sorted.chunks(size) {
                let by_damping = |a: &&Mode, b: &&Mode| a.damping().total_cmp(&b.damping());
                few.extend(bin.iter().min_by(by_damping).copied());
                few.extend(bin.iter().max_by(by_damping).copied());
            }
            few.extend(sorted.last().copied());
            few
        };
        Self {
            points,
            part: self.part,
        }
    }
}

/// Returns a sequence at the samples of the filter; `None` if it is too long for the filter.
pub(super) fn sampled(sequence: &[Impulse], period: f64) -> Option<Vec<Impulse>> {
    let mut taps = vec![Tap::default(); 2 * sequence.len()];
    let count = sample(sequence, period, &mut taps).ok()?;
    taps.truncate(count);
    let impulse = |tap: Tap| Impulse {
        time: tap.delay as f64 * period,
        amplitude: tap.weight,
    };
    Some(taps.into_iter().map(impulse).collect())
}
