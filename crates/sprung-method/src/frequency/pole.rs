//! A pole of the frequency response of a log, by a local rational model.

use faer::c64;

use super::weighted::{Factored, Regression, Solution};

/// Iterations of a search.
const ITERATIONS: usize = 30;

/// Largest step of the pole, and the step at which a search ends, in half widths of the window.
const LARGEST_STEP: f64 = 0.2;
const LEAST_STEP: f64 = 1e-7;

/// Least decay of a pole, in half widths of the window.
const LEAST_DECAY: f64 = 1e-4;

/// Starts of the search beside the expected pole, in half widths of the window.
const STARTS: [f64; 5] = [0.0, -0.3, 0.3, -0.6, 0.6];

/// A pole is in the window if it is at most this far from the centre, in half widths.
const FARTHEST: f64 = 0.9;

/// Smallest ratio of the mean squares that the pole explains, per unknown, to the residual.
const LEAST_RATIO: f64 = 10.0;

/// Smallest part of the output's power that the model explains.
const LEAST_COHERENCE: f64 = 0.8;

/// Lines per unknown.
const LINES_PER_UNKNOWN: usize = 2;

/// Output and inputs at the lines of a window.
#[derive(Clone, Debug)]
pub(super) struct Window<'s> {
    /// Output, \[lines\].
    pub(super) output: &'s [c64],
    /// Inputs, \[lines\] each.
    pub(super) inputs: Vec<&'s [c64]>,
    /// Frequency of each line, Hz.
    pub(super) hz: &'s [f64],
    /// Whether the spectra contain a transient.
    pub(super) transient: bool,
}

/// A lightly damped pole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pole {
    /// Natural frequency, Hz.
    pub(super) hz: f64,
    /// Its standard error, Hz.
    pub(super) error_hz: f64,
    /// Damping ratio.
    pub(super) damping: f64,
}

/// Returns the fewest lines of a window with a number of inputs.
pub(super) fn fewest_lines(inputs: usize) -> usize {
    // Three coefficients per input, as many for a transient, and the pole.
    LINES_PER_UNKNOWN * (3 * inputs + 4)
}

struct Search<'w> {
    window: &'w Window<'w>,
    /// Frequency of each line: from -1 to 1.
    r: Vec<f64>,
    transient: Vec<c64>,
}

/// A point of a search.
struct Point {
    /// Pole, in half widths of the window: frequency and decay.
    pole: c64,
    /// Sum of the weighted squares of the residuals.
    cost: f64,
    weights: Vec<f64>,
}

impl Window<'_> {
    /// Returns the pole near an expected one; `None` if the window shows no pole clearly.
    ///
    /// The output is `Σ (a_j + b_j r + c_j/(r - ρ)) u_j + d + e r + f/(r - ρ)` with the inputs `u_j`, the
    /// frequency r relative to the window and a complex pole ρ that all have in common. Given ρ, the
    /// model is linear; Gauss-Newton steps find ρ.
    ///
    /// - `expected`: natural frequency, Hz, and damping ratio.
    ///
    /// # Source
    ///
    /// `McKelvey` and Guérin, "Non-parametric frequency response estimation using a local rational
    /// model", SYSID 2012; here by output errors instead of equation errors.
    #[must_use]
    pub(super) fn pole(&self, expected: (f64, f64)) -> Option<Pole> {
        let (first, last) = (*self.hz.first()?, *self.hz.last()?);
        let (centre, half) = (0.5 * (first + last), 0.5 * (last - first));
        if self.hz.len() < fewest_lines(self.inputs.len()) {
            return None;
        }
        let search = Search {
            window: self,
            r: self.hz.iter().map(|hz| (hz - centre) / half).collect(),
            transient: vec![c64::new(1.0, 0.0); if self.transient { self.hz.len() } else { 0 }],
        };
        let decay = (expected.0 * expected.1 / half).max(0.02);
        let start = (expected.0 - centre) / half;
        let even = vec![1.0; self.hz.len()];
        let mut best = (STARTS.iter())
            .filter_map(|offset| search.descend(c64::new(start + offset, decay), even.clone()))
            .min_by(|a, b| a.cost.total_cmp(&b.cost))?;
        best = search.reweighted(best)?;
        search.accepted(&best).then_some(())?;
        let variance = search.variance(&best)?;
        let (frequency, decay) = (centre + half * best.pole.re, half * best.pole.im);
        let natural = frequency.hypot(decay);
        Some(Pole {
            hz: natural,
            // Half of the variance of a complex number is that of its real part.
            error_hz: half * (0.5 * variance).sqrt(),
            damping: decay / natural,
        })
    }
}

impl Search<'_> {
    /// Returns the regression at a pole, or that of a smooth response with as many unknowns. The last
    /// column is the derivative by the pole, if its residues are given.
    fn regression(
        &self,
        pole: Option<c64>,
        weights: &[f64],
        residues: Option<&[c64]>,
    ) -> Regression {
        let inputs = || {
            let transient = (!self.transient.is_empty()).then_some(self.transient.as_slice());
            self.window.inputs.iter().copied().chain(transient)
        };
        let mut regressors = Vec::new();
        for (k, &r) in self.r.iter().enumerate() {
            let at = c64::new(r, 0.0);
            let resonance = pole.map_or(at * r, |pole| (at - pole).inv());
            for input in inputs() {
                regressors.extend([input[k], input[k] * r, input[k] * resonance]);
            }
            if let Some(residues) = residues {
                let sum: c64 = inputs().zip(residues).map(|(u, c)| u[k] * *c).sum();
                regressors.push(sum * resonance * resonance);
            }
        }
        Regression {
            unknowns: regressors.len() / self.r.len().max(1),
            regressors,
            weights: weights.to_vec(),
        }
    }

    fn solved(&self, pole: Option<c64>, weights: &[f64]) -> Option<Solution> {
        let regression = self.regression(pole, weights, None);
        Some(regression.factored()?.solve(self.window.output))
    }

    /// Solves with the derivative by the pole, and passes the factors to `then`.
    fn linearized<T>(
        &self,
        pole: c64,
        weights: &[f64],
        then: impl FnOnce(&Factored<'_>, Solution) -> T,
    ) -> Option<T> {
        let plain = self.solved(Some(pole), weights)?;
        let residues: Vec<c64> = plain.values.iter().skip(2).step_by(3).copied().collect();
        let regression = self.regression(Some(pole), weights, Some(&residues));
        let factored = regression.factored()?;
        let solution = factored.solve(self.window.output);
        Some(then(&factored, solution))
    }

    fn cost(&self, pole: Option<c64>, weights: &[f64]) -> Option<f64> {
        Some(weighted_squares(&self.solved(pole, weights)?, weights))
    }

    fn descend(&self, start: c64, weights: Vec<f64>) -> Option<Point> {
        let mut pole = start;
        let mut cost = self.cost(Some(pole), &weights)?;
        for _ in 0..ITERATIONS {
            let Some(step) = self.linearized(pole, &weights, |_, solution| {
                solution.values.last().copied().unwrap_or_default()
            }) else {
                break;
            };
            let mut step = step * (LARGEST_STEP / step.norm()).min(1.0);
            let mut moved = None;
            for _ in 0..4 {
                let mut next = pole + step;
                next.im = next.im.max(LEAST_DECAY);
                if let Some(next_cost) = self.cost(Some(next), &weights).filter(|next| *next < cost)
                {
                    moved = Some((next, next_cost));
                    break;
                }
                step *= 0.5;
            }
            let Some((next, next_cost)) = moved else {
                break;
            };
            let far = (next - pole).norm();
            (pole, cost) = (next, next_cost);
            if far < LEAST_STEP {
                break;
            }
        }
        Some(Point {
            pole,
            cost,
            weights,
        })
    }

    /// Searches again with weights for noise that the pole amplifies, and returns the point with the
    /// largest likelihood.
    fn reweighted(&self, even: Point) -> Option<Point> {
        let mut best = (self.log_likelihood(&even)?, even);
        for part in [0.05, 1.0, f64::INFINITY] {
            let distance = |r: &f64| (c64::new(*r, 0.0) - best.1.pole).norm_sqr();
            let weights: Vec<f64> = (self.r.iter())
                .map(distance)
                .map(|d| if part.is_finite() { d / (d + part) } else { d })
                .collect();
            let Some(found) = self.descend(best.1.pole, weights) else {
                continue;
            };
            let likelihood = self.log_likelihood(&found)?;
            if likelihood > best.0 {
                best = (likelihood, found);
            }
        }
        Some(best.1)
    }

    fn log_likelihood(&self, point: &Point) -> Option<f64> {
        let count = self.r.len() as f64;
        let logs: f64 = point.weights.iter().map(|weight| weight.ln()).sum();
        let likelihood = logs - count * (point.cost / count).ln();
        (!likelihood.is_nan()).then_some(likelihood)
    }

    /// Returns whether the pole is in the window, and explains more than a smooth response.
    fn accepted(&self, point: &Point) -> bool {
        let inside = point.pole.re.abs() < FARTHEST && point.pole.im < FARTHEST;
        let Some(solution) = self
            .solved(Some(point.pole), &point.weights)
            .filter(|_| inside)
        else {
            return false;
        };
        let left = weighted_squares(&solution, &point.weights);
        let whole: f64 = (self.window.output.iter().zip(&point.weights))
            .map(|(y, weight)| weight * y.norm_sqr())
            .sum();
        let Some(smooth) = self.cost(None, &point.weights) else {
            return false;
        };
        let freedom = (self.r.len() - solution.values.len()) as f64;
        left < (1.0 - LEAST_COHERENCE) * whole
            && (smooth - left) > LEAST_RATIO * left / freedom.max(1.0)
    }

    fn variance(&self, point: &Point) -> Option<f64> {
        self.linearized(point.pole, &point.weights, |factored, solution| {
            factored.variance(solution.values.len() - 1, &solution.residuals)
        })
    }
}

fn weighted_squares(solution: &Solution, weights: &[f64]) -> f64 {
    let residuals = solution.residuals.iter().zip(weights);
    residuals.map(|(e, weight)| weight * e.norm_sqr()).sum()
}
