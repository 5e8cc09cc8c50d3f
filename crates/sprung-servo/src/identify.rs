//! Identifies the parameters of a servo, with standard errors and findings.

use sprung_core::servo::ServoParameter;

use super::bench::Bench;
use super::error::ServoError;
use super::findings::findings;
use super::fit::{Counter, Fitted, fit, sums};
use super::matrix::inverse;
use super::record::{Record, Records};
use super::result::{ServoEstimate, ServoFit, ServoIdentification, ServoLog};
use super::start::start;
use super::window::{P, Setting, windows};
use crate::finding::GENERATOR;
use crate::progress::Listener;
use crate::stopwatch::Stopwatch;

/// Length of the first windows, s; their starts are the smoothed samples.
const FIRST_WINDOW_S: f64 = 0.25;

/// Lengths of the windows of the searches that follow, s, with the largest number of simulations.
const WINDOWS: [(f64, usize); 4] = [(0.5, 30), (1.0, 14), (0.7, 14), (0.85, 14)];

/// Number of the last searches whose results are averaged.
const AVERAGED: usize = 3;

/// Longest step of the integration, s: of the first searches, and of those that are averaged.
const STEPS_S: [f64; 2] = [1e-3, 5e-4];

/// Identifies the parameters of a servo.
///
/// # Errors
///
/// [`ServoError`] if the targets do not drive the positions, or if the listener stops the run.
pub fn identify(
    bench: &Bench,
    records: &Records,
    listener: &mut dyn Listener,
) -> Result<ServoIdentification, ServoError> {
    let stopwatch = Stopwatch::start();
    let unknown = bench.unknown();
    let mut counter = Counter {
        listener,
        done: 0,
        total: 14 + WINDOWS.iter().map(|(_, count)| *count as u64).sum::<u64>(),
    };
    let mut values = start(bench, &records.all).ok_or(ServoError::NotDriven)?;
    let mut setting = Setting {
        bench,
        records: &records.all,
        step_s: STEPS_S[0],
        free_start: false,
    };
    let first = windows(&records.all, FIRST_WINDOW_S);
    values = fit(values, first, &unknown, &setting, 14, &mut counter)?.values;
    setting.free_start = true;
    let mut searches = Vec::new();
    for (i, (length, evaluations)) in WINDOWS.into_iter().enumerate() {
        if i + AVERAGED >= WINDOWS.len() {
            setting.step_s = STEPS_S[1];
        }
        let windows = windows(&records.all, length);
        let of_windows: Vec<usize> = windows.iter().map(super::window::Window::record).collect();
        let lengths: Vec<usize> = windows.iter().map(super::window::Window::len).collect();
        let fitted = fit(
            values,
            windows,
            &unknown,
            &setting,
            evaluations,
            &mut counter,
        )?;
        values = fitted.values;
        searches.push(ServoSearch {
            fitted,
            of_windows,
            lengths,
        });
    }
    let averaged = &searches[searches.len() - AVERAGED..];
    let estimate = Estimate::new(averaged, &unknown);
    let fit = quality(&averaged[AVERAGED - 1], &records.all);
    let parameters = described(bench, &estimate);
    let braking = braking(bench, &estimate);
    let findings = findings(bench, &parameters, &braking, &fit);
    Ok(ServoIdentification {
        format: 1,
        generator: GENERATOR.to_owned(),
        robot: bench.robot.clone(),
        joint: bench.joint.clone(),
        logs: logs(bench, records),
        scale: bench.scale,
        parameters,
        braking,
        fit,
        findings,
        elapsed_s: stopwatch.seconds(),
    })
}

/// Result of one search, with record and length of each of its windows.
struct ServoSearch {
    fitted: Fitted,
    of_windows: Vec<usize>,
    lengths: Vec<usize>,
}

/// Values and their covariance.
struct Estimate {
    values: [f64; P],
    /// Covariance of the unknown parameters, \[P × P\]; infinite variances if it does not exist.
    covariance: Vec<f64>,
}

impl Estimate {
    /// Returns the mean of some searches with its covariance.
    ///
    /// The covariance is `H⁻¹ (Σ g gᵀ) H⁻¹ n/(n - p)` with the weighted information `H` and the
    /// gradients `g` of the `n` windows of the last search. It needs no assumption about the errors
    /// within a window. The variance between the searches, which have windows of different lengths,
    /// is added 1.5 times.
    fn new(searches: &[ServoSearch], unknown: &[usize]) -> Self {
        let count = searches.len() as f64;
        let values: [f64; P] = std::array::from_fn(|i| {
            (searches.iter().map(|search| search.fitted.values[i])).sum::<f64>() / count
        });
        let spread = |i: usize| {
            let squares = searches
                .iter()
                .map(|search| (search.fitted.values[i] - values[i]).powi(2));
            squares.sum::<f64>() / (count - 1.0)
        };
        let n = unknown.len();
        let mut covariance = vec![0.0; P * P];
        let of_windows = searches
            .last()
            .and_then(|search| sandwich(&search.fitted, unknown));
        for (i, &row) in unknown.iter().enumerate() {
            for (j, &column) in unknown.iter().enumerate() {
                let at = row * P + column;
                covariance[at] = match &of_windows {
                    Some(of_windows) => of_windows[i * n + j],
                    None if i == j => f64::INFINITY,
                    None => 0.0,
                };
            }
            covariance[row * P + row] += 1.5 * spread(row);
        }
        Self { values, covariance }
    }

    /// Returns the standard error of a parameter.
    fn error(&self, i: usize) -> f64 {
        self.covariance[i * P + i].max(0.0).sqrt()
    }
}

/// Returns the covariance of the unknown parameters from the windows, \[n × n\].
fn sandwich(fitted: &Fitted, unknown: &[usize]) -> Option<Vec<f64>> {
    let n = unknown.len();
    let (information, _) = sums(&fitted.normals, unknown);
    let inverse = inverse(&information, n)?;
    let windows = fitted.normals.len() as f64;
    let factor = windows / (windows - n as f64).max(1.0);
    let mut covariance = vec![0.0; n * n];
    for (normal, weight) in &fitted.normals {
        let moved: Vec<f64> = (0..n)
            .map(|i| {
                let row = inverse[i * n..(i + 1) * n].iter().zip(unknown);
                row.map(|(entry, &k)| entry * weight * normal.descent[k])
                    .sum()
            })
            .collect();
        for i in 0..n {
            for j in 0..n {
                covariance[i * n + j] += factor * moved[i] * moved[j];
            }
        }
    }
    Some(covariance)
}

/// Half width of a 95 % interval of a normal error, in standard errors.
const NORMAL_95: f64 = 1.959_964;

/// Returns a parameter with its interval.
fn estimated(name: String, unit: &str, value: f64, error: Option<f64>) -> ServoEstimate {
    let error = error.filter(|error| error.is_finite());
    ServoEstimate {
        name,
        unit: unit.to_owned(),
        value,
        standard_error: error,
        ci95: error.map(|error| [value - NORMAL_95 * error, value + NORMAL_95 * error]),
        fixed: false,
    }
}

fn described(bench: &Bench, estimate: &Estimate) -> Vec<ServoEstimate> {
    (ServoParameter::ALL.into_iter().enumerate())
        .map(|(i, parameter)| {
            let (name, unit) = bench.name(parameter);
            let name = format!("{}.{name}", bench.joint);
            let (mut value, mut error) = (estimate.values[i], estimate.error(i));
            // Its logarithm is estimated.
            if matches!(parameter, ServoParameter::LogStribeckVelocity) {
                value = value.exp();
                error *= value;
            }
            let fixed = bench.known(parameter).is_some();
            let error = (!fixed).then_some(error);
            ServoEstimate {
                fixed,
                ..estimated(name, unit, value, error)
            }
        })
        .collect()
}

/// Returns viscous friction and back-EMF together.
fn braking(bench: &Bench, estimate: &Estimate) -> ServoEstimate {
    use ServoParameter as Q;
    let of = |parameter: Q| estimate.values[parameter as usize];
    let (scale, back_emf) = (of(Q::TorquePerCommand), of(Q::BackEmf));
    let mut slope = [0.0; P];
    slope[Q::Viscous as usize] = 1.0;
    slope[Q::BackEmf as usize] = scale;
    slope[Q::TorquePerCommand as usize] = back_emf;
    let variance: f64 = (0..P * P)
        .filter(|at| slope[at / P] != 0.0 && slope[at % P] != 0.0)
        .map(|at| slope[at / P] * estimate.covariance[at] * slope[at % P])
        .sum();
    let value = of(Q::Viscous) + scale * back_emf;
    let (_, unit) = bench.name(Q::Viscous);
    let name = format!("{}.braking", bench.joint);
    estimated(name, unit, value, Some(variance.max(0.0).sqrt()))
}

/// Weight below which the model does not follow a window: its squared residual is more than twelve
/// times that of the noise.
const NOT_FOLLOWED: f64 = 0.2;

fn quality(search: &ServoSearch, records: &[Record]) -> ServoFit {
    let (mut samples, mut squares, mut relative, mut lost) = (0, 0.0, 0.0, 0);
    let normals = &search.fitted.normals;
    for (k, (normal, weight)) in normals.iter().enumerate() {
        if *weight < NOT_FOLLOWED {
            lost += 1;
            continue;
        }
        let noise = records[search.of_windows[k]].noise;
        samples += search.lengths[k];
        relative += normal.cost;
        squares += normal.cost * noise * noise;
    }
    let samples = samples.max(1) as f64;
    ServoFit {
        position_rms_rad: (squares / samples).sqrt(),
        position_rms_over_noise: (relative / samples).sqrt(),
        windows_not_followed: f64::from(lost) / normals.len().max(1) as f64,
    }
}

fn logs(bench: &Bench, records: &Records) -> Vec<ServoLog> {
    (records.names.iter().enumerate())
        .map(|(log, name)| {
            let of_log = || records.all.iter().filter(move |record| record.log == log);
            let load = bench.loads.get(log).copied().unwrap_or_default();
            ServoLog {
                log: name.clone(),
                samples: of_log().map(|record| record.position.len()).sum(),
                duration_s: of_log().map(Record::duration).sum(),
                load_inertia_kgm2: load.inertia,
                load_torque_nm: load.sine.hypot(load.cosine),
            }
        })
        .collect()
}
