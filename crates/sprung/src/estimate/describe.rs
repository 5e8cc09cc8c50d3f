//! Results and curves in the form of the files.

use sprung_core::drives::MOTOR_SIDE;

use super::judge::Verdict;
use super::least_squares::{Fitted, MotorRow, residual, torques};
use super::result::{EstimateResult, MotorRowResult, ParameterEstimate};
use crate::curves::{CurveSet, Curves};
use crate::description::Estimator;
use crate::model::{Model, Parameter, ROWS, Theta};
use crate::regression::{FilteredSample, System};

/// Returns the result of an estimator, without its warnings.
pub(super) fn describe(
    model: &Model,
    estimator: Estimator,
    theta: &Theta,
    errors: &[f64],
    fitted: &Fitted,
    system: &System,
) -> EstimateResult {
    let solution = &fitted.solution;
    let torques = torques(model, system, theta);
    let parameters = model
        .parameters()
        .iter()
        .enumerate()
        .map(|(i, parameter)| {
            let known = solution.identifiable[i];
            let mut estimate = estimate(
                parameter,
                known.then_some(theta[i]),
                Some(errors[i]).filter(|e| known && e.is_finite()),
                match estimator {
                    Estimator::LeastSquares => fitted.interval,
                    // How far a running estimate wandered makes no interval.
                    Estimator::Lsff => f64::INFINITY,
                },
            );
            if known {
                let (torque, share) = torques[i];
                estimate.torque_rms_nm = finite(torque);
                estimate.torque_share = finite(share);
            }
            estimate
        })
        .collect();
    let rows = residual(model, system, theta);
    let named = |i: usize| model.row_name(i);
    EstimateResult {
        estimator: estimator.name().to_owned(),
        verdict: Verdict::Good,
        rank: solution.rank,
        condition_number: finite(solution.condition_number),
        condition_number_scaled: finite(solution.condition_number_scaled),
        parameters,
        motor_rows: match estimator {
            Estimator::LeastSquares => (fitted.motor_rows.iter().enumerate())
                .map(|(joint, row)| describe_motor_row(model, joint, row, fitted.interval))
                .collect(),
            Estimator::Lsff => Vec::new(),
        },
        residual_rms: (rows.iter().enumerate())
            .map(|(i, (rms, _))| (named(i), *rms))
            .collect(),
        relative_residual: (rows.iter().enumerate())
            .filter(|(_, (_, rhs))| *rhs > 0.0)
            .map(|(i, (rms, rhs))| (named(i), rms / rhs))
            .collect(),
        warnings: Vec::new(),
        elapsed_s: 0.0,
    }
}

fn describe_motor_row(
    model: &Model,
    joint: usize,
    row: &MotorRow,
    interval: f64,
) -> MotorRowResult {
    MotorRowResult {
        joint: model.joints()[joint].clone(),
        parameters: MOTOR_SIDE
            .iter()
            .enumerate()
            .map(|(i, &kind)| {
                let parameter = &model.parameters()[model.index(kind, joint)];
                let known = row.identifiable[i];
                estimate(
                    parameter,
                    known.then_some(row.values[i]),
                    finite(row.standard_error[i]).filter(|_| known),
                    interval,
                )
            })
            .collect(),
        condition_number: finite(row.condition_number),
        relative_residual: finite(row.relative_residual),
    }
}

fn estimate(
    parameter: &Parameter,
    value: Option<f64>,
    standard_error: Option<f64>,
    interval: f64,
) -> ParameterEstimate {
    let half = standard_error.and_then(|error| finite(interval * error));
    ParameterEstimate {
        name: parameter.name.clone(),
        symbol: parameter.symbol.clone(),
        unit: parameter.unit.to_owned(),
        value,
        standard_error,
        ci95: value.zip(half).map(|(v, h)| [v - h, v + h]),
        nominal: parameter.nominal,
        identifiable: value.is_some(),
        torque_rms_nm: None,
        torque_share: None,
    }
}

fn finite(value: f64) -> Option<f64> {
    Some(value).filter(|v| v.is_finite())
}

/// Returns the trace of an estimator.
pub(super) fn trace_of(
    estimator: Estimator,
    points: impl Iterator<Item = (f64, Option<Vec<f64>>)>,
) -> CurveSet {
    let mut set = CurveSet {
        label: estimator.name().to_owned(),
        time: Vec::new(),
        values: vec![Vec::new(); Theta::default().len()],
    };
    for (time, theta) in points {
        set.time.push(time);
        for (i, values) in set.values.iter_mut().enumerate() {
            values.push(theta.as_ref().map(|theta| theta[i]));
        }
    }
    set
}

/// Returns the filtered right-hand sides, measured and by each estimator.
pub(super) fn fit_curves(
    model: &Model,
    thetas: &[(Estimator, Theta)],
    samples: &[FilteredSample],
) -> Curves {
    let time: Vec<f64> = samples.iter().map(|sample| sample.time).collect();
    let collect = |label: &str, of: &dyn Fn(&FilteredSample) -> [f64; ROWS]| {
        let mut values = vec![Vec::new(); ROWS];
        for sample in samples {
            for (values, value) in values.iter_mut().zip(of(sample)) {
                values.push(Some(value));
            }
        }
        CurveSet {
            label: label.to_owned(),
            time: time.clone(),
            values,
        }
    };
    let mut sets = vec![collect("measured", &|sample| sample.rhs)];
    for (estimator, theta) in thetas {
        sets.push(collect(estimator.name(), &|sample| sample.predicted(theta)));
    }
    Curves {
        columns: (0..ROWS).map(|row| model.row_name(row)).collect(),
        sets,
    }
}
