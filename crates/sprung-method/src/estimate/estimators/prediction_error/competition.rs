//! Competition of the effects that the model lacks: one after the other, the effect that explains most of the rest.
//!
//! One effect often resembles several. A lag of all torques resembles a lag of each torque, and sharper Coulomb
//! friction resembles Stribeck friction. So each effect is tested beside those that explain more, and the size of its
//! gain comes from held-out folds of the log.
//!
//! # Source
//!
//! Rao, Proc. Camb. Phil. Soc. 1948: the score test, also called the Lagrange multiplier test.

use sprung_core::linear::dot;

use super::filter::NormalEquations;
use super::sandwich::widening_of;
use super::solve::covariance;
use crate::estimate::statistics::{MAX_ITERATIONS, SIGNIFICANT_SIGMAS, between_parts};

/// An effect is tested if at least this fraction of its information is independent of other unknowns.
const RELATIVE_INFORMATION: f64 = 1e-6;

/// An effect counts beside another one of its joint, or one of all joints beside any other, if it gains at least this
/// fraction of the other's gain. The step describes an effect only to the first order, and the rest resembles smaller
/// effects.
const LEAST_SHARE_OF_GAIN: f64 = 0.1;

/// An effect that takes part.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Entrant {
    /// Joint; `None` for an effect of all joints.
    pub(super) joint: Option<usize>,
    /// One column, or both phases of a wave.
    pub(super) columns: Vec<usize>,
}

/// The sums of a run with a column for each effect.
pub(super) struct Evidence<'a> {
    /// With the priors.
    pub(super) normal: &'a NormalEquations,
    /// Gradients after growing parts of equal length, \[parts × columns\].
    pub(super) gradients: &'a [Vec<f64>],
    /// Normal equations of folds of the log, without the priors.
    pub(super) folds: &'a [&'a NormalEquations],
    /// s.
    pub(super) duration: f64,
}

/// An effect that explains more than the others.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Winner {
    /// Index of the effect.
    pub(super) effect: usize,
    /// Estimate by one Gauss-Newton step; of an effect with two columns the amplitude.
    pub(super) value: f64,
    /// Contains the scatter of the score over segments of the log, and the changes between folds.
    pub(super) standard_error: f64,
    /// Moves of the unknowns with the effect, \[columns\].
    pub(super) moves: Vec<f64>,
    /// Gain of the log-likelihood of held-out folds.
    pub(super) gain: f64,
}

impl Winner {
    /// Returns the estimate in standard errors.
    pub(super) fn significance(&self) -> f64 {
        self.value.abs() / self.standard_error
    }
}

/// Unknowns that follow an effect, and the effects that won.
struct Field<'a> {
    evidence: &'a Evidence<'a>,
    active: Vec<usize>,
    /// Inverse of the information of the active columns.
    covariance: Vec<f64>,
}

/// Returns the effects that the log shows, in the order of their gains.
///
/// - `active`: columns of the unknowns that follow every effect.
pub(super) fn winners(
    evidence: &Evidence<'_>,
    active: Vec<usize>,
    effects: &[Entrant],
) -> Vec<Winner> {
    let mut winners: Vec<Winner> = Vec::new();
    let Some(mut field) = Field::new(evidence, active) else {
        return winners;
    };
    let limit = limit(effects.len());
    while winners.len() < MAX_ITERATIONS {
        let is_new = |effect: &usize| winners.iter().all(|winner| winner.effect != *effect);
        let tested = (0..effects.len())
            .filter(is_new)
            .filter_map(|effect| field.test(effect, &effects[effect].columns));
        // Effects of another joint are no rivals.
        let best_rival = |winner: &Winner| {
            let rivals = winners.iter().filter(|other| {
                let joints = [winner, *other].map(|one| effects[one.effect].joint);
                joints[0].is_none() || joints[0] == joints[1]
            });
            rivals.map(|other| other.gain).fold(0.0, f64::max)
        };
        let best = tested
            .filter(|candidate| candidate.significance() > limit)
            .filter(|candidate| candidate.gain >= LEAST_SHARE_OF_GAIN * best_rival(candidate))
            .max_by(|a, b| a.gain.total_cmp(&b.gain));
        let Some(best) = best else { break };
        let mut active = field.active;
        active.extend(&effects[best.effect].columns);
        winners.push(best);
        match Field::new(evidence, active) {
            Some(next) => field = next,
            None => break,
        }
    }
    winners
}

/// Returns the number of standard errors beyond which an effect counts. It grows with the number of
/// tested effects, so that a log without effects exceeds it with the same probability.
///
/// ```text
/// z² = 3² + 2 ln n
/// ```
fn limit(tested: usize) -> f64 {
    (SIGNIFICANT_SIGMAS.powi(2) + 2.0 * (tested.max(1) as f64).ln()).sqrt()
}

impl<'a> Field<'a> {
    fn new(evidence: &'a Evidence<'a>, active: Vec<usize>) -> Option<Self> {
        let count = active.len();
        let information: Vec<f64> = (0..count * count)
            .map(|at| evidence.entry(active[at / count], active[at % count]))
            .collect();
        Some(Self {
            covariance: covariance(&information, count)?,
            evidence,
            active,
        })
    }

    /// Tests an effect; `None` if the log does not determine it or held-out folds contradict it.
    fn test(&self, effect: usize, columns: &[usize]) -> Option<Winner> {
        let direction = match columns {
            [column] => self.direction(*column)?,
            [sine, cosine] => self.phase([self.direction(*sine)?, self.direction(*cosine)?])?,
            _ => return None,
        };
        let normal = self.evidence.normal;
        let information = direction.information;
        let value = -dot(&direction.row, &normal.gradient) / information;
        let folds: Vec<(f64, f64)> = (self.evidence.folds.iter())
            .map(|fold| {
                let score = -dot(&direction.row, &fold.gradient);
                (score, fold.quadratic(&direction.row))
            })
            .collect();
        let widening = self.widening(&direction, value, &folds);
        let of_folds: Vec<(f64, f64)> = (folds.iter())
            .filter(|(_, information)| *information > 0.0)
            .map(|(score, information)| (score / information, widening / information.sqrt()))
            .collect();
        let between = between_parts(&of_folds).map_or(0.0, |found| found.standard_error());
        let gain = held_out_gain(&folds);
        (gain > 0.0 && value.is_finite()).then(|| Winner {
            effect,
            value,
            standard_error: (widening / information.sqrt()).hypot(between),
            moves: direction.row.iter().map(|entry| entry * value).collect(),
            gain,
        })
    }

    /// Returns the factor of the standard error by the scatter of the score that is left with the effect.
    ///
    /// - `folds`: score and information of each fold.
    fn widening(&self, direction: &Direction, value: f64, folds: &[(f64, f64)]) -> f64 {
        let gradients = self.evidence.gradients;
        // Information up to the end of each fold, and between the ends by interpolation.
        let mut ends = vec![0.0];
        for (_, information) in folds {
            ends.push(ends[ends.len() - 1] + information);
        }
        let up_to = |share: f64| {
            let at = share * folds.len() as f64;
            let fold = (at as usize).min(folds.len().saturating_sub(1));
            let part = at - fold as f64;
            match ends.get(fold..fold + 2) {
                Some([begin, end]) => begin + part * (end - begin),
                _ => 0.0,
            }
        };
        let growing: Vec<f64> = (gradients.iter().enumerate())
            .map(|(part, gradient)| {
                let share = (part + 1) as f64 / gradients.len() as f64;
                (dot(&direction.row, gradient) + up_to(share) * value) / direction.information
            })
            .collect();
        widening_of(
            &growing,
            direction.information.recip(),
            self.evidence.duration,
        )
    }

    /// Returns the direction of a column, along which the active unknowns follow; `None` if the log does not
    /// determine it.
    fn direction(&self, column: usize) -> Option<Direction> {
        let count = self.active.len();
        let cross: Vec<f64> = (self.active.iter())
            .map(|&other| self.evidence.entry(other, column))
            .collect();
        let mut row = vec![0.0; self.evidence.normal.count];
        let mut information = self.evidence.entry(column, column);
        let whole = information;
        for (i, &at) in self.active.iter().enumerate() {
            let moved = -dot(&self.covariance[i * count..(i + 1) * count], &cross);
            row[at] = moved;
            information += cross[i] * moved;
        }
        row[column] = 1.0;
        (information > RELATIVE_INFORMATION * whole).then_some(Direction { row, information })
    }

    /// Returns the direction with the likeliest phase between two directions.
    fn phase(&self, [sine, cosine]: [Direction; 2]) -> Option<Direction> {
        let score = |direction: &Direction| -dot(&direction.row, &self.evidence.normal.gradient);
        let (a, b) = (score(&sine), score(&cosine));
        let mixed = self.evidence.normal.bilinear(&sine.row, &cosine.row);
        let determinant = sine.information * cosine.information - mixed * mixed;
        let least = RELATIVE_INFORMATION * sine.information * cosine.information;
        if determinant.is_nan() || determinant <= least {
            return None;
        }
        let x = (cosine.information * a - mixed * b) / determinant;
        let y = (sine.information * b - mixed * a) / determinant;
        let amplitude = x.hypot(y);
        let (x, y) = (x / amplitude, y / amplitude);
        let rows = sine.row.iter().zip(&cosine.row);
        (amplitude > 0.0).then(|| Direction {
            row: rows.map(|(sine, cosine)| x * sine + y * cosine).collect(),
            information: x * x * sine.information
                + 2.0 * x * y * mixed
                + y * y * cosine.information,
        })
    }
}

/// A direction in the space of all columns, and the information along it.
struct Direction {
    row: Vec<f64>,
    information: f64,
}

impl Evidence<'_> {
    fn entry(&self, i: usize, j: usize) -> f64 {
        self.normal.entry(i, j)
    }
}

impl NormalEquations {
    fn entry(&self, i: usize, j: usize) -> f64 {
        self.information[i.max(j) * self.count + i.min(j)]
    }

    fn quadratic(&self, row: &[f64]) -> f64 {
        self.bilinear(row, row)
    }

    fn bilinear(&self, a: &[f64], b: &[f64]) -> f64 {
        let used = |row: &[f64]| -> Vec<(usize, f64)> {
            (row.iter().copied().enumerate())
                .filter(|(_, value)| value.abs() > 0.0)
                .collect()
        };
        let b = used(b);
        let of_row =
            |i: usize| -> f64 { b.iter().map(|&(j, value)| value * self.entry(i, j)).sum() };
        used(a)
            .into_iter()
            .map(|(i, value)| value * of_row(i))
            .sum()
    }
}

/// Returns the gain of the log-likelihood of folds, each with the estimate from the other folds.
///
/// - `folds`: score and information of each fold.
fn held_out_gain(folds: &[(f64, f64)]) -> f64 {
    let (score, information) = (folds.iter()).fold((0.0, 0.0), |(score, information), fold| {
        (score + fold.0, information + fold.1)
    });
    let gain = |&(fold_score, fold_information): &(f64, f64)| {
        let others = information - fold_information;
        if others <= 0.0 {
            return 0.0;
        }
        let value = (score - fold_score) / others;
        fold_score * value - 0.5 * fold_information * value * value
    };
    folds.iter().map(gain).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums of all folds, gradients up to the end of each, and the folds.
    struct Sums {
        whole: NormalEquations,
        gradients: Vec<Vec<f64>>,
        folds: Vec<NormalEquations>,
    }

    /// Sums of a linear regression with noise of variance 1: an unknown, and three effects, of which the second is the
    /// first plus a small independent part.
    fn sums(truth: [f64; 3]) -> Sums {
        let mut state = 11_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            ((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * 12.0_f64.sqrt()
        };
        let mut whole = NormalEquations::zero(4);
        let mut gradients = Vec::new();
        let mut folds = Vec::new();
        for _ in 0..8 {
            let mut fold = NormalEquations::zero(4);
            for _ in 0..500 {
                let (first, second, third) = (random(), random(), random());
                let row = [1.0, first, 0.8 * first + 0.6 * second, third];
                let error = random()
                    + (row[1..].iter().zip(truth))
                        .map(|(x, value)| x * value)
                        .sum::<f64>();
                for i in 0..4 {
                    fold.gradient[i] -= row[i] * error;
                    for j in 0..=i {
                        fold.information[i * 4 + j] += row[i] * row[j];
                    }
                }
            }
            for (sum, fold) in whole.information.iter_mut().zip(&fold.information) {
                *sum += fold;
            }
            for (sum, fold) in whole.gradient.iter_mut().zip(&fold.gradient) {
                *sum += fold;
            }
            gradients.push(whole.gradient.clone());
            folds.push(fold);
        }
        Sums {
            whole,
            gradients,
            folds,
        }
    }

    fn entrants(columns: &[&[usize]]) -> Vec<Entrant> {
        let entrant = |columns: &&[usize]| Entrant {
            joint: None,
            columns: columns.to_vec(),
        };
        columns.iter().map(entrant).collect()
    }

    fn found(truth: [f64; 3]) -> Vec<Winner> {
        let sums = sums(truth);
        let evidence = Evidence {
            normal: &sums.whole,
            gradients: &sums.gradients,
            folds: &sums.folds.iter().collect::<Vec<_>>(),
            duration: 8.0,
        };
        winners(&evidence, vec![0], &entrants(&[&[1], &[2], &[3]]))
    }

    #[test]
    fn a_log_without_effects_has_no_winner() {
        assert_eq!(found([0.0; 3]), []);
    }

    #[test]
    fn an_effect_that_resembles_another_one_does_not_win_beside_it() {
        let found = found([0.5, 0.0, 0.0]);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(found[0].effect, 0);
        // The standard error of 4000 samples is 0.016.
        assert!((found[0].value - 0.5).abs() < 0.06, "{found:?}");
        assert!(found[0].standard_error < 0.03);
    }

    #[test]
    fn two_effects_win_in_the_order_of_their_gains() {
        let effects: Vec<usize> = (found([0.5, 0.0, 1.0]).iter())
            .map(|winner| winner.effect)
            .collect();
        assert_eq!(effects, [2, 0]);
    }

    #[test]
    fn the_phase_of_a_wave_is_found() {
        let sums = sums([0.0, 0.3, 0.4]);
        let evidence = Evidence {
            normal: &sums.whole,
            gradients: &sums.gradients,
            folds: &sums.folds.iter().collect::<Vec<_>>(),
            duration: 8.0,
        };
        let found = winners(&evidence, vec![0], &entrants(&[&[2, 3]]));
        assert_eq!(found.len(), 1);
        assert!((found[0].value - 0.5).abs() < 0.06, "{found:?}");
    }

    /// Probability beyond z standard errors on both sides, by its asymptotic series.
    fn beyond(z: f64) -> f64 {
        (2.0 / std::f64::consts::PI).sqrt() * (-z * z / 2.0).exp() / z * (1.0 - 1.0 / (z * z))
    }

    #[test]
    fn more_tests_raise_no_more_alarms() {
        let one = beyond(limit(1));
        for tested in [2, 8, 60] {
            let any = tested as f64 * beyond(limit(tested));
            assert!((0.6..1.05).contains(&(any / one)), "{tested}: {any} {one}");
        }
    }
}
