//! Tests whether repeated estimates differ by more than their intervals allow.

use super::result::{ComparedParameter, ComparedResult, ComparedValue, RUNS_DISAGREE};
use crate::estimate::{NORMAL_95, between_parts};
use crate::finding::{Finding, Severity};
use crate::model::short;

/// Significance of a disagreement: the probability of a false alarm for all parameters of one
/// estimator together, if the errors are independent and normal with the given intervals.
pub const SIGNIFICANCE: f64 = 0.01;

/// Limit of the parameters that a finding names.
const PARAMETERS_IN_TEXT: usize = 5;

/// Test of one parameter for agreement between results.
struct AgreementTest<'a> {
    parameter: &'a ComparedParameter,
    low: f64,
    high: f64,
    // Root mean square distance from the mean, relative to the standard errors.
    excess: f64,
    probability: f64,
}

/// Returns the number of tests, and for each estimator the parameters that disagree between its
/// results.
///
/// For each parameter with an interval in K results the statistic is `Σ (x_i − x̄)²/s_i²`, x̄ the
/// mean weighted by 1/s², s the half width of the 95 % interval over 1.96. For independent errors
/// it is chi-square with K − 1 degrees of freedom. A parameter disagrees if the probability of its
/// statistic is below [`SIGNIFICANCE`] over the number of parameters tested (Bonferroni). Results
/// of one log share its errors, so they differ less: the test then has less power, but no more
/// false alarms.
pub(super) fn runs_disagree(
    compared: &[ComparedResult],
    parameters: &[ComparedParameter],
) -> (usize, Vec<Finding>) {
    let (mut tested, mut findings) = (0, Vec::new());
    let mut done: Vec<&str> = Vec::new();
    for result in compared {
        let estimator = result.estimator.as_str();
        if done.contains(&estimator) {
            continue;
        }
        done.push(estimator);
        let indices: Vec<usize> = (0..compared.len())
            .filter(|&i| compared[i].estimator == estimator)
            .collect();
        let tests: Vec<AgreementTest<'_>> = (parameters.iter())
            .filter_map(|parameter| test(parameter, &indices))
            .collect();
        tested += tests.len();
        findings.extend(of_estimator(estimator, &indices, compared, &tests));
    }
    (tested, findings)
}

fn of_estimator(
    estimator: &str,
    indices: &[usize],
    compared: &[ComparedResult],
    tests: &[AgreementTest<'_>],
) -> Option<Finding> {
    let limit = SIGNIFICANCE / tests.len().max(1) as f64;
    let mut apart: Vec<&AgreementTest> = tests.iter().filter(|t| t.probability < limit).collect();
    if apart.is_empty() {
        return None;
    }
    apart.sort_by(|a, b| b.excess.total_cmp(&a.excess));
    let mut texts: Vec<String> = (apart.iter().take(PARAMETERS_IN_TEXT))
        .map(|apart| describe(apart))
        .collect();
    if apart.len() > PARAMETERS_IN_TEXT {
        texts.push(format!("and {} more", apart.len() - PARAMETERS_IN_TEXT));
    }
    let same_settings = indices
        .iter()
        .all(|&i| compared[i].settings.agree(&compared[indices[0]].settings));
    let remedy = if same_settings {
        "parameters that change with the controller's gains, the speed or the load show an effect that \
         the model lacks (a torque delay, a friction law, play, another inertia); validate each result \
         on the other logs"
    } else {
        "the settings differ too: first identify all logs with the same settings; differences that \
         remain show an effect that the model lacks"
    };
    Some(
        Finding::new(
            Severity::Warning,
            RUNS_DISAGREE,
            format!(
                "{} results of {estimator} differ by more than their intervals allow in {} of {} \
                 parameters: {}",
                indices.len(),
                apart.len(),
                tests.len(),
                texts.join("; ")
            ),
            remedy,
        )
        .about(apart.iter().map(|apart| apart.parameter.name.clone())),
    )
}

fn describe(apart: &AgreementTest<'_>) -> String {
    let AgreementTest {
        parameter,
        low,
        high,
        excess,
        ..
    } = apart;
    let middle = 0.5 * (low + high);
    format!(
        "{} from {low:.5} to {high:.5} {} ({:.2} %, {excess:.1} times their standard errors)",
        short(&parameter.name),
        parameter.unit,
        100.0 * (high - low) / middle.abs(),
    )
}

fn test<'a>(parameter: &'a ComparedParameter, indices: &[usize]) -> Option<AgreementTest<'a>> {
    let values: Vec<(f64, f64)> = (indices.iter())
        .filter_map(|&i| estimate(parameter.values[i].as_ref()?))
        .collect();
    let between = between_parts(&values)?;
    let fold =
        |start: f64, with: fn(f64, f64) -> f64| values.iter().map(|(x, _)| *x).fold(start, with);
    Some(AgreementTest {
        parameter,
        low: fold(f64::INFINITY, f64::min),
        high: fold(f64::NEG_INFINITY, f64::max),
        excess: (between.statistic / between.freedom as f64).sqrt(),
        probability: between.probability,
    })
}

/// Returns a value and the standard error that matches its interval.
fn estimate(value: &ComparedValue) -> Option<(f64, f64)> {
    if value.fixed {
        return None;
    }
    let [low, high] = value.ci95?;
    let error = (high - low) / (2.0 * NORMAL_95);
    Some((value.value?, error)).filter(|(x, s)| x.is_finite() && s.is_finite() && *s > 0.0)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    use super::*;

    /// A parameter with normal errors about a separate true value in each run.
    fn parameter(rng: &mut ChaCha8Rng, name: usize, truth: &[f64]) -> ComparedParameter {
        let values = truth.iter().enumerate().map(|(run, truth)| {
            let error = 0.1 * (1 + run) as f64;
            let value = truth + error * rng.sample::<f64, _>(StandardNormal);
            Some(ComparedValue {
                value: Some(value),
                standard_error: Some(error),
                ci95: Some([value - NORMAL_95 * error, value + NORMAL_95 * error]),
                fixed: false,
                difference_percent: None,
                difference_standard_errors: None,
            })
        });
        ComparedParameter {
            name: name.to_string(),
            symbol: String::new(),
            unit: String::new(),
            values: values.collect(),
        }
    }

    /// Fraction of many comparisons with at least one disagreeing parameter.
    fn alarms(truth: &[f64]) -> f64 {
        const COMPARISONS: usize = 4000;
        const PARAMETERS: usize = 15;
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let indices: Vec<usize> = (0..truth.len()).collect();
        let alarms = (0..COMPARISONS).filter(|_| {
            (0..PARAMETERS).any(|name| {
                let parameter = parameter(&mut rng, name, truth);
                let apart = test(&parameter, &indices).unwrap();
                apart.probability < SIGNIFICANCE / PARAMETERS as f64
            })
        });
        alarms.count() as f64 / COMPARISONS as f64
    }

    #[test]
    fn false_alarm_rate_matches_the_significance() {
        for runs in [2, 3, 6] {
            let share = alarms(&vec![5.0; runs]);
            // The significance is 1 %. The share of 4000 comparisons has a standard deviation of
            // 0.16 %; the limits are 3 and 4 of them away.
            assert!((0.005..0.016).contains(&share), "{runs} runs: {share}");
        }
    }

    #[test]
    fn true_differences_are_found() {
        // Six times the combined standard error.
        let share = alarms(&[5.0, 5.0 + 6.0 * 0.1 * 5_f64.sqrt()]);
        // Each of 15 parameters exceeds the limit of 3.4 combined standard errors with a probability of 0.995, so a
        // comparison without any of them does not occur.
        assert!(share > 1.0 - 1e-9, "{share}");
    }

    #[test]
    fn parameters_without_intervals_are_not_tested() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut parameter = parameter(&mut rng, 0, &[1.0, 9.0]);
        assert!(test(&parameter, &[0, 1]).is_some());
        assert!(test(&parameter, &[1]).is_none());
        if let Some(value) = &mut parameter.values[1] {
            value.ci95 = None;
        }
        assert!(test(&parameter, &[0, 1]).is_none());
    }
}
