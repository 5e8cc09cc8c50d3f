//! A line through the estimates of one parameter over time, and the significance of its slope.

use crate::estimate::both_tails;

/// Fewest runs for a trend. With three, only enormous changes would be significant.
pub(super) const FEWEST_RUNS: usize = 4;

/// A line through estimates over time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Trend {
    /// Value of the line at the first time.
    pub(super) first: f64,
    /// Change of the line from the first to the last time.
    pub(super) change: f64,
    /// Standard error of the change.
    pub(super) standard_error: f64,
    /// Standard deviation of the runs about the line beyond their standard errors.
    pub(super) between_runs: f64,
    /// Number of runs minus two.
    pub(super) freedom: usize,
    /// Probability of at least this change, in either direction, without a trend.
    pub(super) probability: f64,
}

/// The estimate of one run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    pub(super) time: f64,
    pub(super) value: f64,
    /// Standard error.
    pub(super) error: f64,
}

/// Fits a line to the estimates of one parameter; `None` for fewer than [`FEWEST_RUNS`] runs or for runs at one
/// time.
///
/// - `runs`: in the order of time.
///
/// # Source
///
/// Meta-regression with random effects: the variance between runs as in `between_parts`, with the
/// residuals of the line and two degrees of freedom fewer. The standard error is that of Knapp and
/// Hartung, "Improved tests for a random effects meta-regression", 2003, with a factor of at least one:
/// it contains the scatter of the runs, and it is never below that of their errors.
pub(super) fn trend(runs: &[Run]) -> Option<Trend> {
    let (n, freedom) = (runs.len(), runs.len().checked_sub(2)?);
    if n < FEWEST_RUNS {
        return None;
    }
    let (begin, end) = (runs.first()?.time, runs.last()?.time);
    let fitted = Line::through(runs, 0.0)?;
    let scale = fitted.weights * freedom as f64 / n as f64;
    let variance = ((fitted.misfit - freedom as f64) / scale).max(0.0);
    let line = Line::through(runs, variance)?;
    let factor = (line.misfit / freedom as f64).max(1.0);
    let slope_error = (factor / line.spread).sqrt();
    let standard_error = slope_error * (end - begin);
    let found = Trend {
        first: line.mean + line.slope * (begin - line.middle),
        change: line.slope * (end - begin),
        standard_error,
        between_runs: variance.sqrt(),
        freedom,
        probability: both_tails(line.slope / slope_error, freedom),
    };
    (found.first.is_finite() && found.change.is_finite() && standard_error > 0.0).then_some(found)
}

/// A weighted line.
struct Line {
    weights: f64,
    middle: f64,
    mean: f64,
    slope: f64,
    // Weighted sum of the squared distances of the times from their middle.
    spread: f64,
    // Weighted sum of the squared residuals.
    misfit: f64,
}

impl Line {
    /// - `variance`: variance of the runs beyond their standard errors.
    fn through(runs: &[Run], variance: f64) -> Option<Self> {
        let weighted =
            || (runs.iter()).map(|run| (*run, (run.error * run.error + variance).recip()));
        let weights: f64 = weighted().map(|(_, w)| w).sum();
        let middle = weighted().map(|(run, w)| w * run.time).sum::<f64>() / weights;
        let mean = weighted().map(|(run, w)| w * run.value).sum::<f64>() / weights;
        let spread: f64 = (weighted())
            .map(|(run, w)| w * (run.time - middle).powi(2))
            .sum();
        let joint: f64 = weighted()
            .map(|(run, w)| w * (run.time - middle) * (run.value - mean))
            .sum();
        let slope = joint / spread;
        let misfit = weighted()
            .map(|(run, w)| w * (run.value - mean - slope * (run.time - middle)).powi(2))
            .sum();
        (slope.is_finite() && weights.is_finite()).then_some(Self {
            weights,
            middle,
            mean,
            slope,
            spread,
            misfit,
        })
    }
}

/// Returns probabilities adjusted for the number of tests: reporting those below a limit keeps the
/// expected share of false reports below it.
///
/// # Source
///
/// Benjamini and Hochberg, "Controlling the false discovery rate", 1995.
pub(super) fn adjusted(probabilities: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..probabilities.len()).collect();
    order.sort_by(|a, b| probabilities[*a].total_cmp(&probabilities[*b]));
    let (mut all, mut least) = (vec![1.0; order.len()], 1.0_f64);
    for (place, &i) in order.iter().enumerate().rev() {
        least = least.min(probabilities[i] * order.len() as f64 / (place + 1) as f64);
        all[i] = least;
    }
    all
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;
    use sprung_testing::least_inside;

    use super::super::SIGNIFICANCE;
    use super::*;

    const RUNS: usize = 10;
    const PARAMETERS: usize = 100;

    /// The method promises two false alarms in 200 comparisons. A Poisson variable with this mean exceeds nine with a
    /// probability of 5e-5.
    const MOST_ALARMS: usize = 9;

    /// Estimates of a parameter near 10 with standard errors about 0.5 %, which change by `drift` over
    /// all runs and differ between the runs by `between` beyond their errors.
    fn runs(rng: &mut ChaCha8Rng, drift: f64, between: f64) -> Vec<Run> {
        let mut normal = || rng.sample::<f64, _>(StandardNormal);
        (0..RUNS)
            .map(|run| {
                let error = 0.05 * (0.7 + 0.3 * (run % 3) as f64);
                let time = run as f64 / (RUNS - 1) as f64;
                let value = 10.0 + drift * time + error * normal() + between * normal();
                Run { time, value, error }
            })
            .collect()
    }

    /// Numbers of reported parameters with and without drift in `comparisons` of 100 parameters each, of
    /// which `drifting` drift by 5 %.
    fn reported(comparisons: usize, drifting: usize, between: f64) -> (usize, usize) {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let (mut found, mut false_alarms) = (0, 0);
        for _ in 0..comparisons {
            let probabilities: Vec<f64> = (0..PARAMETERS)
                .map(|k| {
                    let drift = if k < drifting { -0.5 } else { 0.0 };
                    trend(&runs(&mut rng, drift, between)).unwrap().probability
                })
                .collect();
            for (k, adjusted) in adjusted(&probabilities).into_iter().enumerate() {
                if adjusted < SIGNIFICANCE {
                    *(if k < drifting {
                        &mut found
                    } else {
                        &mut false_alarms
                    }) += 1;
                }
            }
        }
        (found, false_alarms)
    }

    #[test]
    fn robots_that_do_not_change_give_hardly_an_alarm() {
        for between in [0.0, 0.1] {
            let (_, alarms) = reported(200, 0, between);
            assert!(alarms <= MOST_ALARMS, "{between}: {alarms}");
        }
    }

    #[test]
    fn five_percent_over_ten_runs_are_found() {
        let (found, alarms) = reported(200, 1, 0.0);
        // The drift is eleven standard errors, and Student's limit for 1e-4 and eight degrees of freedom is 7.1. It is
        // exceeded with a probability of 0.975 (20 000 random cases).
        let least = least_inside(200, 0.975);
        assert!(found >= least && alarms <= MOST_ALARMS, "{found}, {alarms}");
        // The runs differ by twice their standard errors beyond them, so this probability is 0.128.
        let (found, alarms) = reported(200, 1, 0.1);
        let expected = least_inside(200, 0.128)..=200 - least_inside(200, 1.0 - 0.128);
        assert!(expected.contains(&found), "{found}");
        assert!(alarms <= MOST_ALARMS, "{alarms}");
    }

    #[test]
    fn equal_errors_give_the_common_line() {
        // Least squares by hand: middle 1.5, slope 2, residuals ±0.1.
        let at = |time: f64, value: f64| Run {
            time,
            value,
            error: 1e-3,
        };
        let runs = [at(0.0, 1.1), at(1.0, 2.9), at(2.0, 4.9), at(3.0, 7.1)];
        let found = trend(&runs).unwrap();
        assert!((found.first - 1.0).abs() < 1e-9 && (found.change - 6.0).abs() < 1e-9);
        // The error of the slope by the residuals is √(0.04 / 2 / 5).
        let error = 3.0 * 0.004_f64.sqrt();
        assert!(
            (found.standard_error / error - 1.0).abs() < 1e-3,
            "{found:?}"
        );
        // Two degrees of freedom have a closed form: 1 - t/√(2 + t²) with t² = 4/0.004.
        assert!(
            (found.probability / 9.985e-4 - 1.0).abs() < 3e-3,
            "{found:?}"
        );
    }

    #[test]
    fn few_runs_and_runs_at_one_time_have_no_trend() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut runs = runs(&mut rng, -5.0, 0.0);
        assert_eq!(trend(&runs[..3]), None);
        for run in &mut runs {
            run.time = 3.0;
        }
        assert_eq!(trend(&runs), None);
        assert_eq!(trend(&[]), None);
    }

    #[test]
    fn adjusted_probabilities_of_an_example() {
        let found = adjusted(&[0.01, 0.04, 0.03, 0.005]);
        for (found, expected) in found.iter().zip([0.02, 0.04, 0.04, 0.02]) {
            assert!((found - expected).abs() < 1e-15, "{found}");
        }
        assert!(adjusted(&[]).is_empty());
    }
}
