//! Combines repeated results of one estimator from different logs, weighted by their information.

use super::result::{CombinedParameter, CombinedResult, ComparedResult};
use crate::estimate::{
    ErrorParts, EstimateResult, Identification, LogInfo, NORMAL_95, ParameterEstimate,
    between_parts,
};

/// One result, and the identification that contains it.
pub(super) type OneResult<'a> = (&'a Identification, &'a EstimateResult);

/// Combines the results of each estimator.
///
/// Results of different robots, of one log, and estimators with one result are not combined.
pub(super) fn combined(
    compared: &[ComparedResult],
    results: &[OneResult<'_>],
) -> Vec<CombinedResult> {
    let mut estimators: Vec<&str> = Vec::new();
    for result in compared {
        if !estimators.contains(&result.estimator.as_str()) {
            estimators.push(&result.estimator);
        }
    }
    let of = |estimator: &&str| {
        let indices: Vec<usize> = (0..results.len())
            .filter(|&i| compared[i].estimator == **estimator)
            .collect();
        let different = indices.iter().enumerate().all(|(at, &i)| {
            (indices[..at].iter()).all(|&j| are_of_different_logs(results[i].0, results[j].0))
        });
        let indices: Vec<usize> = indices.into_iter().filter(|_| different).collect();
        let first = results[*indices.first()?].1;
        let parameters: Vec<CombinedParameter> = (first.parameters.iter())
            .filter_map(|parameter| {
                let same = |&i: &usize| {
                    let mut all = results[i].1.parameters.iter();
                    all.find(|p| p.name == parameter.name && p.unit == parameter.unit)
                };
                let estimates: Vec<&ParameterEstimate> = indices.iter().filter_map(same).collect();
                combine(&estimates)
            })
            .collect();
        (!parameters.is_empty()).then(|| CombinedResult {
            estimator: (*estimator).to_owned(),
            results: indices.iter().map(|&i| compared[i].label.clone()).collect(),
            parameters,
        })
    };
    estimators.iter().filter_map(of).collect()
}

/// Returns whether two identifications of one robot have no log in common, by the names, lengths, dates
/// and digests of the logs.
pub(super) fn are_of_different_logs(one: &Identification, other: &Identification) -> bool {
    let same = |a: &LogInfo, b: &LogInfo| {
        (&a.file, a.window, a.samples, a.recorded) == (&b.file, b.window, b.samples, b.recorded)
            && (a.duration_s - b.duration_s).abs() <= f64::EPSILON * a.duration_s
            && a.date_s.map(f64::to_bits) == b.date_s.map(f64::to_bits)
            && (a.digest == b.digest || a.digest.is_empty() || b.digest.is_empty())
    };
    one.robot == other.robot && !one.logs().any(|a| other.logs().any(|b| same(a, b)))
}

/// Combines estimates of one parameter; `None` if fewer than two have an interval.
///
/// With `w = 1/s²`, s the half width of the interval over 1.96, the value is `Σ w x / Σ w`. Of each
/// error the bias b is common to all results: its mean `Σ w b / Σ w` remains. The rest e is
/// independent and becomes `√(Σ w² e²) / Σ w`. If the results differ beyond their errors, the deviation
/// between them is the third part, as for several logs of one identification.
fn combine(estimates: &[&ParameterEstimate]) -> Option<CombinedParameter> {
    let with_errors: Vec<WithError> = estimates.iter().filter_map(|p| with_error(p)).collect();
    let values: Vec<(f64, f64)> = with_errors
        .iter()
        .map(|one| (one.value, one.error))
        .collect();
    let between = between_parts(&values)?;
    let weights: Vec<f64> = with_errors.iter().map(|one| one.error.powi(-2)).collect();
    let sum: f64 = weights.iter().sum();
    let each = || with_errors.iter().zip(&weights);
    let independent: f64 = each()
        .map(|(one, w)| w * w * (one.error * one.error - one.bias * one.bias).max(0.0))
        .sum();
    let error_parts = ErrorParts {
        sampling: independent.sqrt() / sum,
        between_parts: between.standard_error(),
        bias: each().map(|(one, w)| w * one.bias).sum::<f64>() / sum,
    };
    let error = (error_parts.sampling)
        .hypot(error_parts.between_parts)
        .hypot(error_parts.bias);
    let (value, half) = (between.mean, NORMAL_95 * error);
    let first = estimates.first()?;
    let freedom = between.freedom as f64;
    Some(CombinedParameter {
        name: first.name.clone(),
        unit: first.unit.clone(),
        results: with_errors.len(),
        value,
        standard_error: error,
        ci95: [value - half, value + half],
        error_parts,
        chi_square: between.statistic,
        freedom: between.freedom,
        probability: between.probability,
        i_squared_percent: if between.statistic > freedom {
            100.0 * (1.0 - freedom / between.statistic)
        } else {
            0.0
        },
    })
}

/// An estimate with an interval.
#[derive(Clone, Copy, Debug)]
pub(super) struct WithError {
    pub(super) value: f64,
    /// The standard error that matches the interval.
    pub(super) error: f64,
    /// The bias in this error.
    pub(super) bias: f64,
}

/// Returns an estimate with its error; `None` without an interval.
pub(super) fn with_error(estimate: &ParameterEstimate) -> Option<WithError> {
    if estimate.fixed {
        return None;
    }
    let [low, high] = estimate.ci95?;
    let error = (high - low) / (2.0 * NORMAL_95);
    let bias = (estimate.error_parts.zip(estimate.standard_error))
        .map_or(0.0, |(parts, whole)| error * parts.bias / whole);
    let value = estimate.value?;
    (value.is_finite() && error.is_finite() && error > 0.0 && bias.is_finite())
        .then_some(WithError { value, error, bias })
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    use super::*;

    fn estimate(value: f64, error: f64, bias: f64) -> ParameterEstimate {
        let half = NORMAL_95 * error;
        ParameterEstimate {
            name: "joint1.stiffness".to_owned(),
            symbol: String::new(),
            unit: "N·m/rad".to_owned(),
            value: Some(value),
            standard_error: Some(error),
            error_parts: Some(ErrorParts {
                sampling: (error * error - bias * bias).sqrt(),
                between_parts: 0.0,
                bias,
            }),
            ci95: Some([value - half, value + half]),
            unconstrained: None,
            one_sided: false,
            physical: None,
            sum_with: None,
            nominal: None,
            identifiable: true,
            fixed: false,
            torque_rms_nm: None,
            torque_share: None,
            torque_over_residual: None,
        }
    }

    fn combined(all: &[ParameterEstimate]) -> Option<CombinedParameter> {
        combine(&all.iter().collect::<Vec<_>>())
    }

    #[test]
    fn precise_results_have_large_weights() {
        // Weights 4 and 1: (4 · 1 + 1.5) / 5.
        let found = combined(&[estimate(1.0, 0.5, 0.0), estimate(1.5, 1.0, 0.0)]).unwrap();
        assert!((found.value - 1.1).abs() < 1e-12);
        assert!((found.standard_error - 5_f64.sqrt().recip()).abs() < 1e-12);
        assert!((found.chi_square - (0.04 + 0.16)).abs() < 1e-12);
        assert_eq!((found.freedom, found.results), (1, 2));
        assert!(found.i_squared_percent.abs() < 1e-12);
    }

    #[test]
    fn combining_does_not_reduce_the_bias() {
        let all = vec![estimate(1.0, 0.5, 0.3); 100];
        let found = combined(&all).unwrap();
        assert!((found.error_parts.bias - 0.3).abs() < 1e-12);
        assert!((found.error_parts.sampling - 0.04).abs() < 1e-12);
        assert!((found.standard_error - 0.3_f64.hypot(0.04)).abs() < 1e-12);
    }

    #[test]
    fn one_interval_is_not_combined() {
        let mut given = estimate(1.0, 0.1, 0.0);
        given.fixed = true;
        let mut open = estimate(1.0, 0.1, 0.0);
        open.ci95 = None;
        assert_eq!(combined(&[estimate(1.0, 0.1, 0.0), given, open]), None);
        assert_eq!(combined(&[]), None);
    }

    /// Results of six logs with independent errors, one common error and, in the second case, a
    /// parameter that changes between the logs by three standard errors.
    #[test]
    fn intervals_contain_the_truth() {
        const TRIALS: usize = 4000;
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut normal = || rng.sample::<f64, _>(StandardNormal);
        for (change, rejected) in [(0.0, 0.0..0.07), (0.6, 0.85..1.01)] {
            let (mut hits, mut apart) = (0, 0);
            for _ in 0..TRIALS {
                let bias = 0.1 * normal();
                let all: Vec<ParameterEstimate> = (0..6)
                    .map(|run| {
                        let independent_error = 0.1 * f64::from(1 + run % 3);
                        let value = 5.0 + bias + change * normal() + independent_error * normal();
                        estimate(value, independent_error.hypot(0.1), 0.1)
                    })
                    .collect();
                let found = combined(&all).unwrap();
                hits += usize::from((found.ci95[0]..found.ci95[1]).contains(&5.0));
                apart += usize::from(found.probability < 0.05);
            }
            let [hits, apart] = [hits, apart].map(|count| count as f64 / TRIALS as f64);
            assert!(hits > 0.94, "{change}: {hits}");
            assert!(rejected.contains(&apart), "{change}: {apart}");
        }
    }
}
