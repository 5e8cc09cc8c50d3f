//! Combinations of one sequence per mode.

use rayon::prelude::*;
use sprung_core::shaper::{Impulse, Mode, convolve, residual};

use super::centre::Candidate;
use super::region::{Region, Residuals, sampled};

/// The regions of all modes, and the best sequences of each number of impulses for each mode.
pub(super) struct Problem<'p> {
    pub(super) regions: &'p [Region],
    pub(super) candidates: &'p [Vec<Candidate>],
    /// Allowed residual vibration.
    pub(super) level: f64,
    /// Sampling period, s.
    pub(super) period: f64,
}

/// One sequence per mode.
#[derive(Clone, Debug, PartialEq)]
struct Combination {
    /// Index of the candidate for each mode.
    members: Vec<usize>,
    /// Time of the last impulse, s.
    delay: f64,
    /// Largest residual before sampling.
    continuous: f64,
    /// Bound below the largest residual after sampling.
    at_least: f64,
}

/// A combination with the residuals of its sampled sequence.
#[derive(Clone, Debug)]
pub(super) struct Evaluated {
    pub(super) members: Vec<usize>,
    pub(super) sequence: Vec<Impulse>,
    pub(super) delay: f64,
    /// One per mode.
    pub(super) modes: Vec<Residuals>,
    /// The largest of all modes.
    pub(super) all: Residuals,
}

impl Problem<'_> {
    /// Returns the shortest combination that keeps the level, or else the one with the least residual. `None` if no
    /// combination fits into the filter.
    pub(super) fn choose(&self) -> Option<Evaluated> {
        let mut combinations = self.combinations();
        let mut possible = (combinations.iter()).filter(|one| one.at_least <= self.level);
        let kept = possible.find_map(|combination| {
            (self.evaluated(combination)).filter(|found| found.all.largest <= self.level)
        });
        kept.or_else(|| {
            combinations.sort_by(|a, b| a.continuous.total_cmp(&b.continuous));
            (combinations.iter()).find_map(|combination| self.evaluated(combination))
        })
    }

    /// Returns all combinations, from the shortest.
    fn combinations(&self) -> Vec<Combination> {
        let factors = self.factors();
        let count: usize = self.candidates.iter().map(Vec::len).product();
        let mut all: Vec<Combination> = (0..count)
            .into_par_iter()
            .map(|index| self.combination(index, &factors))
            .collect();
        all.sort_by(|a, b| {
            (a.delay.total_cmp(&b.delay)).then(a.continuous.total_cmp(&b.continuous))
        });
        all
    }

    /// Returns the residuals of each candidate at all points of all regions, one list per mode and candidate.
    fn factors(&self) -> Vec<Vec<Vec<f64>>> {
        let points: Vec<&Mode> = self
            .regions
            .iter()
            .flat_map(|region| &region.points)
            .collect();
        let factor = |candidate: &Candidate| -> Vec<f64> {
            (points.par_iter())
                .map(|mode| residual(&candidate.sequence, mode))
                .collect()
        };
        (self.candidates.iter())
            .map(|alternatives| alternatives.iter().map(factor).collect())
            .collect()
    }

    fn combination(&self, index: usize, factors: &[Vec<Vec<f64>>]) -> Combination {
        let mut rest = index;
        let members: Vec<usize> = (self.candidates.iter())
            .map(|alternatives| {
                let member = rest % alternatives.len();
                rest /= alternatives.len();
                member
            })
            .collect();
        let chosen: Vec<&Vec<f64>> = (factors.iter().zip(&members))
            .map(|(alternatives, member)| &alternatives[*member])
            .collect();
        let (mut first, mut continuous, mut at_least) = (0, 0.0_f64, 0.0_f64);
        for region in self.regions {
            let product = |at: usize| chosen.iter().map(|factor| factor[at]).product::<f64>();
            let products: Vec<f64> = (first..first + region.points.len()).map(product).collect();
            let bounds = (products.iter().zip(&region.points))
                .map(|(product, mode)| self.bound(*product, mode))
                .collect();
            first += region.points.len();
            continuous = continuous.max(region.residuals(products).largest);
            at_least = at_least.max(region.residuals(bounds).largest);
        }
        let delays = self.candidates.iter().zip(&members);
        Combination {
            delay: delays
                .map(|(alternatives, member)| alternatives[*member].delay())
                .sum(),
            members,
            continuous,
            at_least,
        }
    }

    /// Returns a bound below the residual of the sampled sequence.
    ///
    /// A linear interpolation of `exp(st)` over a period T errs by at most `|sT|²/8` of its larger end, and the last
    /// sample is at most T after the last impulse.
    fn bound(&self, continuous: f64, mode: &Mode) -> f64 {
        let angle = mode.frequency() * self.period;
        let decay = (-mode.damping() * angle).exp();
        decay * continuous - angle * angle / 8.0
    }

    fn evaluated(&self, combination: &Combination) -> Option<Evaluated> {
        let one = Impulse {
            time: 0.0,
            amplitude: 1.0,
        };
        let mut sequence = vec![one];
        for (candidates, member) in self.candidates.iter().zip(&combination.members) {
            let other = &candidates[*member].sequence;
            let mut both = vec![one; sequence.len() * other.len()];
            convolve(&sequence, other, &mut both).ok()?;
            sequence = both;
        }
        let sampled = sampled(&sequence, self.period)?;
        let modes: Vec<Residuals> = (self.regions.iter())
            .map(|region| {
                let points = region.points.par_iter();
                region.residuals(points.map(|mode| residual(&sampled, mode)).collect())
            })
            .collect();
        Some(Evaluated {
            members: combination.members.clone(),
            delay: sequence.last()?.time,
            all: modes.iter().copied().reduce(Residuals::max)?,
            sequence,
            modes,
        })
    }

    /// Returns all combinations with the residuals of their sampled sequences.
    #[cfg(test)]
    pub(super) fn all_evaluated(&self) -> Vec<Evaluated> {
        (self.combinations().iter())
            .filter_map(|combination| self.evaluated(combination))
            .collect()
    }
}
