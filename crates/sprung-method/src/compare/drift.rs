//! Tests one robot for drift over time: parameters that follow a line through its runs.

use super::agreement::SIGNIFICANCE;
use super::combined::{OneResult, WithError, are_of_different_logs, with_error};
use super::dates::SECONDS_PER_DAY;
use super::drift_result::{Drift, PARAMETER_DRIFTS, ParameterDrift};
use super::result::{ComparedParameter, ComparedResult};
use super::trend::{FEWEST_RUNS, Run, Trend, adjusted, trend};
use crate::finding::{Finding, Severity};
use crate::model::short;

/// Least part of a standard error that belongs to a run alone. Without it a run with only a bias would have an infinite
/// weight.
const LEAST_OWN_PART: f64 = 0.01;

/// Tests the results of each estimator for drift.
///
/// Estimators with fewer than four results are not tested, nor those of which two results have a log in common: then
/// the settings differ, not the times. The order is that of the dates of the logs if all have one, and otherwise that
/// of the results.
pub(super) fn drifts(
    compared: &[ComparedResult],
    results: &[OneResult<'_>],
    parameters: &[ComparedParameter],
) -> Vec<Drift> {
    let mut estimators: Vec<&str> = Vec::new();
    for result in compared {
        if !estimators.contains(&result.estimator.as_str()) {
            estimators.push(&result.estimator);
        }
    }
    let of = |estimator: &&str| {
        let indices: Vec<usize> = (0..compared.len())
            .filter(|&i| compared[i].estimator == **estimator)
            .collect();
        let different = indices.iter().enumerate().all(|(at, &i)| {
            (indices[..at].iter()).all(|&j| are_of_different_logs(results[i].0, results[j].0))
        });
        (different && indices.len() >= FEWEST_RUNS)
            .then(|| of_estimator(&indices, compared, results, parameters))
            .filter(|drift| !drift.parameters.is_empty())
    };
    estimators.iter().filter_map(of).collect()
}

fn of_estimator(
    indices: &[usize],
    compared: &[ComparedResult],
    results: &[OneResult<'_>],
    parameters: &[ComparedParameter],
) -> Drift {
    let dates: Option<Vec<f64>> = indices.iter().map(|&i| compared[i].date_s).collect();
    // Runs at one time, for example simulated ones, have only the given order.
    let dates = dates.filter(|dates| dates.windows(2).any(|pair| pair[0] < pair[1]));
    let times: Vec<f64> = match &dates {
        Some(dates) => (dates.iter())
            .map(|date| (date - dates[0]) / SECONDS_PER_DAY)
            .collect(),
        None => (1..=indices.len()).map(|run| run as f64).collect(),
    };
    let tested = parameters.iter().filter_map(|parameter| {
        let runs: Vec<Run> = (indices.iter().zip(&times))
            .filter_map(|(&i, &time)| {
                let mut all = results[i].1.parameters.iter();
                let same = all.find(|p| p.name == parameter.name && p.unit == parameter.unit);
                let WithError { value, error, bias } = with_error(same?)?;
                // A bias that all runs share moves the line and does not change its slope.
                let independent_error = (error * error - bias * bias).max(0.0).sqrt();
                Some(Run {
                    time,
                    value,
                    error: independent_error.max(LEAST_OWN_PART * error),
                })
            })
            .collect();
        let found = trend(&runs)?;
        Some(parameter_drift(parameter, &runs, &found, dates.is_some()))
    });
    let mut tested: Vec<ParameterDrift> = tested.collect();
    let probabilities: Vec<f64> = tested
        .iter()
        .map(|parameter| parameter.probability)
        .collect();
    for (parameter, adjusted) in tested.iter_mut().zip(adjusted(&probabilities)) {
        parameter.adjusted_probability = adjusted;
        parameter.drifts = adjusted < SIGNIFICANCE;
    }
    let undated = indices.iter().find(|&&i| compared[i].date_s.is_none());
    Drift {
        estimator: compared[indices[0]].estimator.clone(),
        results: indices.iter().map(|&i| compared[i].label.clone()).collect(),
        times,
        time_unit: if dates.is_some() { "d" } else { "run" }.to_owned(),
        from_date_s: dates.map(|dates| dates[0]),
        without_date: undated.map(|&i| compared[i].label.clone()),
        parameters: tested,
    }
}

/// - `runs`: those that determine the parameter.
/// - `per_day`: whether the times are days.
fn parameter_drift(
    parameter: &ComparedParameter,
    runs: &[Run],
    trend: &Trend,
    per_day: bool,
) -> ParameterDrift {
    let span = [runs[0].time, runs[runs.len() - 1].time];
    let percent = |value: f64| {
        let is_significant = trend.first.abs() > trend.standard_error;
        is_significant.then(|| 100.0 * value / trend.first.abs())
    };
    ParameterDrift {
        name: parameter.name.clone(),
        unit: parameter.unit.clone(),
        results: runs.len(),
        span,
        first: trend.first,
        change: trend.change,
        standard_error: trend.standard_error,
        change_percent: percent(trend.change),
        standard_error_percent: percent(trend.standard_error),
        change_per_day: per_day.then(|| trend.change / (span[1] - span[0])),
        between_runs: trend.between_runs,
        freedom: trend.freedom,
        probability: trend.probability,
        adjusted_probability: 1.0,
        drifts: false,
    }
}

/// Reports each parameter that drifts, by the estimator with the most certain change.
pub(super) fn drift_findings(drifts: &[Drift]) -> Vec<Finding> {
    let drifting: Vec<(&Drift, &ParameterDrift)> = (drifts.iter())
        .flat_map(|drift| drift.drifting().map(move |parameter| (drift, parameter)))
        .collect();
    let mut findings: Vec<Finding> = Vec::new();
    for (_, parameter) in &drifting {
        if findings
            .iter()
            .any(|finding| finding.parameters.contains(&parameter.name))
        {
            continue;
        }
        let all = drifting
            .iter()
            .filter(|(_, other)| other.name == parameter.name);
        let clearest =
            all.min_by(|(_, a), (_, b)| a.adjusted_probability.total_cmp(&b.adjusted_probability));
        findings.extend(clearest.map(|(drift, parameter)| finding(drift, parameter)));
    }
    findings
}

fn finding(drift: &Drift, parameter: &ParameterDrift) -> Finding {
    let per_day = match parameter.change_per_day {
        Some(change) => format!(", {change:+.2e} {} per day", parameter.unit),
        None => String::new(),
    };
    Finding::new(
        Severity::Warning,
        PARAMETER_DRIFTS,
        format!(
            "{} drifts by {} over {} (results of {}{per_day}); without drift, a line through the runs would change as \
             much with a probability of {:.1e}, adjusted for {} tested parameters",
            short(&parameter.name),
            parameter.in_words(),
            drift.runs(),
            drift.estimator,
            parameter.adjusted_probability,
            drift.parameters.len(),
        ),
        "look for wear, temperature, lubrication or load that changed with the runs, and use the values of the last run; if \
         the temperature changed, log it as a covariate",
    )
    .about([parameter.name.clone()])
}
